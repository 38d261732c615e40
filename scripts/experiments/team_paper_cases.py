"""The paper's own experiment: four robots, each alone and all together, beside Tables 1 and 2."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from experiments.team_alone import circles, least_squares, with_own_poses
from experiments.team_judge import Verdict, bound_ratio, consistency, judge
from experiments.team_layouts import random_layout
from experiments.team_rows import Row, timed
from experiments.team_views_sim import Scene, Senses, see

NOISES_DEG = (2.0, 3.0, 4.0)
NUM_ROBOTS = 4
PAPER_ALONE = {"x_mm": 284.0, "y_mm": 292.0, "theta_deg": 15.0}
PAPER_TEAM = {"x_mm": 225.0, "y_mm": 168.0, "theta_deg": 10.0}
PAPER_TABLES = {
    "x_mm": ((74, 151, 342, 348), (79, 171, 198, 427)),
    "y_mm": ((139, 281, 338, 49), (34, 280, 83, 140)),
    "theta_deg": ((2, 26, 8, 6), (1, 14, 17, 3)),
}
"""Tables 1 and 2: the errors of robots A to D."""
METHODS = ("circles", "alone", "published", "team")
_TO_UNITS = np.array([1e3, 1e3, 180.0 / math.pi])
_TEAM = Row(table="paper_cases", title="", num_robots=NUM_ROBOTS)
_PUBLISHED = Row(table="paper_cases", title="", num_robots=NUM_ROBOTS, method="published")


def case_scene(noise_deg: float, seed: int) -> Scene:
    """Return four robots as the paper has them: rough poses by method 1 on the same bearings."""
    senses = Senses(noise=math.radians(noise_deg), rough_sd=None)
    return with_own_poses(see(random_layout(seed, NUM_ROBOTS), senses, seed))


def paper_case(noise_deg: float, seeds: Iterable[int]) -> dict[str, Any]:
    """Return the errors of each method on layouts with one deviation of the bearings."""
    verdicts: dict[str, list[Verdict]] = {method: [] for method in METHODS}
    for seed in seeds:
        scene = case_scene(noise_deg, seed)
        verdicts["circles"].append(judge(scene, circles(scene), 0.0, counts_rough=False))
        verdicts["alone"].append(judge(scene, least_squares(scene), 0.0, counts_rough=False))
        for row in (_PUBLISHED, _TEAM):
            verdicts[row.method].append(judge(scene, *timed(scene, row), counts_rough=False))
    team, alone = verdicts["team"], verdicts["alone"]
    return {
        "noise_deg": noise_deg,
        "robots": sum(len(v.errors) for v in team),
        **{method: _errors(found) for method, found in verdicts.items()},
        "paper": PAPER_TEAM,
        "paper_alone": PAPER_ALONE,
        "ratio_to_alone": _ratio(team, alone),
        "ratio_to_circles": _ratio(team, verdicts["circles"]),
        "published_ratio_to_alone": _ratio(verdicts["published"], alone),
        "identified_share": _identified(team),
        "published_identified_share": _identified(verdicts["published"]),
        "crlb_ratio": bound_ratio([v for v in team if v.is_exact]),
        **consistency(team),
        "solve_ms": float(np.median([v.ms for v in team])),
        "published_ms": float(np.median([v.ms for v in verdicts["published"]])),
    }


def fits_best(cases: Sequence[Mapping[str, Any]]) -> float:
    """Return the deviation whose errors alone are nearest to the paper's, by ratio, deg."""

    def off(case: Mapping[str, Any]) -> float:
        return sum(abs(math.log(case["alone"][key] / PAPER_ALONE[key])) for key in PAPER_ALONE)

    return float(min(cases, key=off)["noise_deg"])


def _errors(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return mean absolute errors, their quartiles, and how many robots got a pose."""
    errors = np.concatenate([v.errors for v in verdicts])
    given = np.abs(errors[np.isfinite(errors[:, 0])]) * _TO_UNITS
    if not len(given):
        return {**dict.fromkeys(PAPER_TEAM), "position_mm": None, "quartiles": None, "answers": 0}
    quartiles = np.percentile(given, (25, 50, 75), axis=0).T
    keys = tuple(PAPER_TEAM)
    return {
        **dict(zip(keys, given.mean(axis=0).tolist(), strict=True)),
        "position_mm": float(np.hypot(*given[:, :2].T).mean()),
        "quartiles": dict(zip(keys, quartiles.tolist(), strict=True)),
        "answers": len(given),
    }


def _ratio(team: Sequence[Verdict], alone: Sequence[Verdict]) -> float | None:
    """Return the mean position error of a team over that of the same robots alone."""
    off = [np.hypot(*np.concatenate([v.errors for v in found])[:, :2].T) for found in (team, alone)]
    both = np.isfinite(off[0]) & np.isfinite(off[1])
    return float(off[0][both].mean() / off[1][both].mean()) if both.any() else None


def _identified(verdicts: Sequence[Verdict]) -> float:
    return sum(v.num_right for v in verdicts) / sum(v.num_views for v in verdicts)
