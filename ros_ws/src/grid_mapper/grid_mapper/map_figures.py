"""The figures of a mapping run: by summary key, and as lines for the screen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from floornav_common.report_page import Section, Table
from grid_mapper.layers import LayeredMapper
from grid_mapper.map_run import MapRun
from grid_mapper.published_relations import SOURCE, published_errors
from grid_mapper.relations import Relation, RelationErrors

NUM_WORST = 5


def sonar_figures(run: MapRun, mapper: LayeredMapper, num_glass: int) -> dict[str, Any]:
    """Return what became of the sonar readings, by summary key; None where there were none."""
    if not run.num_ranges:
        return {}
    counts = mapper.sonar_counts
    return {
        "ranges_placed": counts.placed,
        "ranges_counted": counts.counted,
        "ranges_void": counts.void,
        "ranges_unplaced": run.num_ranges - counts.placed,
        "glass_cells": num_glass,
        "ms_per_range_median": float(np.median(run.range_ms)),
        "ms_per_range_p99": float(np.quantile(run.range_ms, 0.99)),
    }


def relation_figures(errors: RelationErrors) -> dict[str, Any]:
    """Return mean, median, deviation and the worst of relation errors, by summary key."""
    trans, rot = errors.translations, np.degrees(errors.rotations)
    is_empty = len(trans) == 0
    return {
        "relations_trans_m": None if is_empty else float(np.mean(trans)),
        "relations_trans_median_m": None if is_empty else float(np.median(trans)),
        "relations_trans_std_m": None if is_empty else float(np.std(trans)),
        "relations_rot_deg": None if is_empty else float(np.mean(rot)),
        "relations_rot_median_deg": None if is_empty else float(np.median(rot)),
        "relations_rot_std_deg": None if is_empty else float(np.std(rot)),
        "relations_used": len(trans),
        "relations_total": errors.num_total,
        "relations_worst": [
            {
                "t1": relation.stamp1_ns * 1e-9,
                "t2": relation.stamp2_ns * 1e-9,
                "trans_m": translation,
                "rot_deg": float(np.degrees(rotation)),
            }
            for relation, translation, rotation in errors.worst(NUM_WORST)
        ],
    }


def published_figures(relations: Sequence[Relation]) -> dict[str, Any]:
    """Return what others reached against the same relations, by summary key; None if unknown."""
    rows = [
        {"method": row.method, "trans_m": row.mean, "trans_std_m": row.std}
        for row in published_errors(relations)
    ]
    return {"relations_published": rows or None}


def screen_text(summary: dict[str, Any]) -> str:
    """Return the figures of a run as lines for the screen."""
    s = summary
    lines = [
        f"scans: {s['scans']}, used {s['scans_used']}, not trusted {s['scans_untrusted']};"
        f" way {s['path_m']:.1f} m in {s['duration_s']:.1f} s"
    ]
    if s["ms_median"] is not None:
        lines.append(
            f"time per scan: median {s['ms_median']:.2f} ms, p99 {s['ms_p99']:.2f} ms;"
            f" memory at most {s['peak_mb']:.0f} MB"
        )
    if s["beam_order"]:
        lines.append(f"beams of a scan: {s['beam_order']}")
    if s["loops"] is not None:
        lines.append(loop_line(s))
    odd = {
        "without transform": s["scans_without_transform"], "stamps going back":
        s["stamps_backwards"], "stamps repeated": s["stamps_repeated"], "jumps back in time":
        s["time_jumps"], "malformed": s["malformed"], "before the robot was found":
        s["scans_unplaced"],
    }  # fmt: skip
    if any(odd.values()):
        lines.append("met: " + ", ".join(f"{n} {name}" for name, n in odd.items() if n))
    if s["ranges"]:
        lines.append(_sonar_line(s))
    lines.extend(_relation_lines(s))
    if s["ate_m"] is not None:
        lines.append(f"ATE {s['ate_m']:.4f} m, RPE {s['rpe_m']:.4f} m ({s['gt_poses']} poses)")
    return "\n".join(lines)


def loop_line(s: dict[str, Any]) -> str:
    """Return what became of the loops."""
    reasons = ", ".join(f"{reason} {num}" for reason, num in s["loops_refused"].items())
    return (
        f"loops closed: {s['loops']} between {s['nodes']} nodes; refused"
        f" {sum(s['loops_refused'].values())}{f' ({reasons})' if reasons else ''}"
    )


def _sonar_line(s: dict[str, Any]) -> str:
    return (
        f"sonar readings: {s['ranges']}, placed {s['ranges_placed']}, of these saying nothing"
        f" {s['ranges_void']}, counted {s['ranges_counted']}; cells of glass: {s['glass_cells']}"
    )


def _relation_lines(s: dict[str, Any]) -> list[str]:
    if s["relations_used"] is None:
        return []
    lines = [f"relations: {s['relations_used']} of {s['relations_total']} matched"]
    if s["relations_used"]:
        for key, unit in (("trans", "m"), ("rot", "deg")):
            mean, median, std = (
                s[f"relations_{key}{what}_{unit}"] for what in ("", "_median", "_std")
            )
            name = "translation" if key == "trans" else "rotation"
            lines.append(
                f"  {name}: mean {mean:.4f} {unit}, median {median:.4f}, deviation {std:.4f}"
            )
        lines.extend(
            f"  worst: {w['trans_m']:.3f} m, {w['rot_deg']:.2f} deg"
            f" from {w['t1']:.3f} s to {w['t2']:.3f} s"
            for w in s["relations_worst"]
        )
    return lines + _published_lines(s)


def _published_lines(s: dict[str, Any]) -> list[str]:
    if not s["relations_published"]:
        return []
    rows = [
        f"{row['method']} {row['trans_m']:.3f} +- {row['trans_std_m']:.3f}"
        for row in s["relations_published"]
    ]
    return [f"  published, translation in m: {', '.join(rows)}", f"  ({_caveat(s)}; {SOURCE})"]


def _caveat(s: dict[str, Any]) -> str:
    used, total = s["relations_used"], s["relations_total"]
    return f"published over all {total} relations, ours over the {used} matched ones"


def relation_sections(s: dict[str, Any]) -> list[Section]:
    """Return the part of the page that has the relation errors beside the published ones."""
    if not s["relations_used"]:
        return []
    published = s["relations_published"] or []
    ours = [f"{s[f'relations_trans{k}_m']:.3f}" for k in ("", "_std")]
    ours += [f"{s[f'relations_rot{k}_deg']:.2f}" for k in ("", "_std")]
    head = ["poses", "relations", "translation, m", "deviation", "rotation, deg", "deviation"]
    rows = [["this run", f"{s['relations_used']} of {s['relations_total']}", *ours]] + [
        [row["method"], "all", f"{row['trans_m']:.3f}", f"{row['trans_std_m']:.3f}", "-", "-"]
        for row in published
    ]
    text = [f"Rows below the first: {SOURCE}; {_caveat(s)}."] if published else []
    return [Section("Against known relations", [Table(head, rows), *text])]
