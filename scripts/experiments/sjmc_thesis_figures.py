"""Figures of the thesis's experiments from their drives; a share of nothing is None."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from experiments.crowd_scenes import ROBOT
from experiments.sjmc_thesis_drives import CROSSING, HALL, PUBLISHED, STATIC, Outcome, Task

Drives = Mapping[Task, Outcome]


def response_rows(done: Drives, danger: float) -> list[dict[str, Any]]:
    """Return Fig. 5.2: time against C, and beside it the methods without C."""
    rows = []
    own = {t: r for t, r in done.items() if t.method != PUBLISHED or t.danger == danger}
    groups = _groups(own, STATIC, lambda t: (t.distance, t.method, t.response))
    for (start, method, response), runs in groups:
        c = response if method == PUBLISHED else None
        rows.append({"start_m": start, "c": c, "method": method, **_times(runs)})
    return rows


def danger_rows(done: Drives, chosen: Sequence[float]) -> list[dict[str, Any]]:
    """Return Fig. 5.3: time against L_DANGER for some C."""
    rows = []
    own = {t: r for t, r in done.items() if t.method == PUBLISHED and t.response in chosen}
    groups = _groups(own, STATIC, lambda t: (t.distance, t.response, t.danger))
    for (start, c, danger), runs in groups:
        rows.append({"start_m": start, "l_danger_m": danger, "c": c, **_times(runs)})
    return rows


def straight_rows(done: Drives) -> list[dict[str, Any]]:
    """Return Fig. 5.5: share of runs that stayed straight, and without a contact, by distance."""
    rows = []
    for (distance, method), runs in _groups(done, CROSSING, lambda t: (t.distance, t.method)):
        gaps = [r.min_gap_m for r in runs]
        rows.append({
            "distance_m": distance, "method": method,
            "success": _share(r.is_straight and r.is_done and not r.contacts for r in runs),
            "straight": _share(r.is_straight and r.is_done for r in runs),
            "contacts": sum(r.contacts > 0 for r in runs),
            "contacts_by_robot": sum(r.by_robot > 0 for r in runs),
            "clear": _share(g >= 0.2 for g in gaps), "min_gap_m": min(gaps),
            "median_gap_m": float(np.median(gaps)), "runs": len(runs),
            "time_s": float(np.median([r.time_s for r in runs])),
        })  # fmt: skip
    return rows


def hall_rows(done: Drives) -> list[dict[str, Any]]:
    """Return Table 2.2: success by density and kind, with the weaving."""
    rows = []
    groups = _groups(done, HALL, lambda t: (t.is_dynamic, t.density != "low", t.method))
    for (is_dynamic, is_high, method), runs in groups:
        there = [r for r in runs if r.is_success]
        rows.append({
            "density": "high" if is_high else "low", "kind": "dynamic" if is_dynamic else "static",
            "method": method, "success": _share(r.is_success for r in runs), "runs": len(runs),
            "contacts_by_robot": sum(r.by_robot for r in runs),
            "heading_changes": float(np.mean([r.heading_changes for r in runs])),
            "time_s": float(np.median([r.time_s for r in there])) if there else None,
        })  # fmt: skip
    return rows


def stable_rows(done: Drives, kind: str, method: str) -> dict[str, Any]:
    """Return 5.2.4: of people who yield, how often the robot kept straight on because they did."""
    found: dict[str, Any] = {}
    for name, yields in (("yielding", True), ("unyielding", False)):
        runs = [
            r for t, r in done.items()
            if (t.kind, t.method, t.is_yielding) == (kind, method, yields)
        ]  # fmt: skip
        answered = (r.is_success and (r.is_straight or not yields) for r in runs)
        found[name] = {
            "success": _share(answered), "collisions": sum(r.contacts > 0 for r in runs),
            "by_robot": sum(r.by_robot > 0 for r in runs), "runs": len(runs),
            "stepped_aside": _share(r.has_moved for r in runs),
            "min_gap_m": min((r.min_gap_m for r in runs), default=None),
            "time_s": float(np.median([r.time_s for r in runs])) if runs else None,
        }  # fmt: skip
    return found


def static_figures(done: Drives) -> dict[str, Any]:
    """Return the times past the static obstacle, and what a good VFH+ needs, by start."""
    found: dict[str, Any] = {}
    for start in sorted({t.distance for t in done if t.kind == STATIC}):
        runs = {
            method: [
                r for t, r in done.items()
                if (t.kind, t.method, t.distance) == (STATIC, method, start)
            ]
            for method in ("sjmc", "vfh_plus")
        }  # fmt: skip
        runs[PUBLISHED] = [
            r for t, r in done.items()
            if (t.kind, t.method, t.distance, t.response, t.danger)
            == (STATIC, PUBLISHED, start, 2.7, 1.9)
        ]  # fmt: skip
        times = {m: _mean([r.time_s for r in rs]) for m, rs in runs.items()}
        ours, peer = times["sjmc"], times["vfh_plus"]
        allowed = [1.1 * (r.path_m / ROBOT.speed_m_s + 1.0) for r in runs["vfh_plus"]]
        found[f"start_{start:g}_m"] = {
            "ratio": None if ours is None or peer is None else ours / peer,
            "time_s": times, "vfh_plus_allowed_s": _mean(allowed),
            "published_ratio": None if times[PUBLISHED] is None or peer is None
            else times[PUBLISHED] / peer,
            "contacts": {m: sum(r.contacts for r in rs) for m, rs in runs.items()},
        }  # fmt: skip
    return found


def _groups(done: Drives, kind: str, key: Any) -> list[tuple[Any, list[Outcome]]]:
    tasks = sorted((t for t in done if t.kind == kind), key=key)
    return [(k, [done[t] for t in group]) for k, group in groupby(tasks, key=key)]


def _times(runs: Sequence[Outcome]) -> dict[str, Any]:
    times = [r.time_s for r in runs if r.is_done]
    return {
        "time_s": _mean(times), "sd_s": float(np.std(times)) if times else None,
        "runs": len(runs), "contacts": sum(r.contacts for r in runs),
        "path_m": _mean([r.path_m for r in runs]),
    }  # fmt: skip


def _mean(values: Sequence[float]) -> float | None:
    return math.fsum(values) / len(values) if values else None


def _share(flags: Iterable[bool]) -> float | None:
    found = list(flags)
    return sum(found) / len(found) if found else None
