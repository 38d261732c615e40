"""The most room that a robot can leave who crosses its way, without turning."""

from __future__ import annotations

import math

import pytest

from experiments.sjmc_thesis_bound import best_gap, bound_rows


def test_who_never_brakes_in_time_leaves_the_way_of_the_person_to_its_corner() -> None:
    """At rest and never acting, the corner (front, 0.28 m) is off the walk's line by geometry."""
    distance, never = 1.5, 100.0
    front = math.sqrt((distance + 0.2) ** 2 - 0.9**2) + 0.1 - 0.2
    corner = (1.8 * front - 1.5 * (0.28 + 0.9)) / math.hypot(1.5, 1.8)
    assert best_gap(distance, 1.0, 0.0, never) == pytest.approx(corner - 0.2, abs=2e-3)


def test_the_sooner_and_slower_the_more_room() -> None:
    assert best_gap(1.3, 1.4, 0.0, 0.1) > best_gap(1.3, 1.4, 0.0, 0.3) + 0.05
    assert best_gap(1.3, 1.4, 0.0, 0.2) > best_gap(1.3, 1.4, 0.15, 0.2) + 0.1
    assert best_gap(1.3, 0.8, 0.0, 0.2) > best_gap(1.3, 1.4, 0.0, 0.2)


def test_rows_are_of_the_distances_that_the_walk_can_begin_at() -> None:
    rows = bound_rows([0.9, 1.3])
    assert [(r["distance_m"], r["walker_m_s"]) for r in rows] == [
        (1.3, 0.8),
        (1.3, 1.1),
        (1.3, 1.4),
    ]
    for row in rows:
        at_once, waits, creeps = (
            row["at_rest_told_at_once_m"], row["at_rest_told_by_the_next_scan_m"],
            row["creeping_told_by_the_next_scan_m"],
        )  # fmt: skip
        assert at_once > waits > creeps


def test_before_the_fastest_walker_at_1_3_m_the_creeping_speed_decides() -> None:
    """With the wait for a scan 0.2 m are left at rest and at 0.02 m/s, and not at 0.03 m/s."""
    gaps = [best_gap(1.3, 1.4, speed, 0.2) for speed in (0.0, 0.02, 0.03, 0.05)]
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[1] > 0.2 > gaps[2]
