"""Time of checking every triangle, as Kato et al. did, beside the whole solve."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.team_peers import count_triangles, num_triples
from experiments.team_rows import Row, scene_of
from multi_localizer.team_config import PublishedTeamConfig

_NOISE_DEG = 1.0
_MOST_CHECKED = 2e8  # combinations; of larger teams a part of the triples is timed


def every_triangle(sweep: Sequence[Mapping[str, Any]], seed: int) -> list[dict[str, Any]]:
    """Return for each size of team what the check takes, and what our solve took.

    `is_measured` is False where only a part of the triples was checked and the time is that part's,
    scaled by the number of triples.
    """
    tolerance = PublishedTeamConfig().angle_tolerance_rad
    rows = []
    for done in (row for row in sweep if row["noise_deg"] == _NOISE_DEG):
        scene = scene_of(Row(table="", title="", num_robots=done["n"]), seed)
        count_triangles(scene, tolerance, 1)  # compiles
        pairs = [len(v.bearings) * (len(v.bearings) - 1) // 2 for v in scene.views]
        triples = num_triples(done["n"])
        combinations = triples * (sum(pairs) / len(pairs)) ** 3
        checked = max(1, min(triples, int(triples * _MOST_CHECKED / max(combinations, 1.0))))
        started = time.perf_counter()
        found = count_triangles(scene, tolerance, checked)
        ms = 1e3 * (time.perf_counter() - started)
        rows.append(
            {
                "n": done["n"],
                "triples": triples,
                "combinations": combinations,
                "fitting": found if checked == triples else None,
                "is_measured": checked == triples,
                "ms": ms * triples / checked,
                "solve_ms": done["solve_ms"],
            }
        )
    return rows
