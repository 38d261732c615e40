"""What earlier scans saw free tells what has moved."""

from __future__ import annotations

import numpy as np
from drawn_scans import Circle, Wall, drawn_scan
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.scan_clusters import cluster_beams
from sjmc_planner.seen_free import SeenFree, told_of

WALL: list[Wall] = [(4, -4, 4, 4)]


def told(now: Scan, now_at: SE2, earlier: Scan, earlier_at: SE2) -> np.ndarray:
    """Return what is told of each thing, from left to right seen from behind: by first beam."""
    kept = SeenFree()
    kept.keep(earlier, earlier.ranges, earlier_at.as_array())
    kept.age(0.3)
    num = len(now.ranges)
    labels, ends = np.empty(num, dtype=np.int64), np.empty((num, 3), dtype=np.int64)
    step = abs(now.angle_increment)
    count = cluster_beams(now.ranges, now.range_min, now.range_max, step, 0.8, labels, ends)
    things = np.arange(count)
    return told_of(now.ranges, ends, things, count, now_at.as_array(), *kept.kept())


def nearest_thing(scan: Scan, values: np.ndarray) -> np.ndarray:
    num = len(scan.ranges)
    labels, ends = np.empty(num, dtype=np.int64), np.empty((num, 3), dtype=np.int64)
    step = abs(scan.angle_increment)
    cluster_beams(scan.ranges, scan.range_min, scan.range_max, step, 0.8, labels, ends)
    return values[labels[np.argmin(scan.ranges)]]


def test_somebody_who_came_stands_where_it_was_free() -> None:
    at = SE2.identity()
    earlier, now = drawn_scan([(2.0, 1.0, 0.2)], WALL), drawn_scan([(2.0, 0.4, 0.2)], WALL)
    free, known, _ = nearest_thing(now, told(now, at, earlier, at))
    assert free == 1.0
    assert known == 0.0


def test_somebody_who_stands_is_known() -> None:
    at = SE2.identity()
    scan = drawn_scan([(2.0, 0.4, 0.2)], WALL)
    free, known, _ = nearest_thing(scan, told(scan, at, scan, at))
    assert free == 0.0
    assert known == 1.0


def test_what_was_hidden_is_neither_free_nor_known() -> None:
    at = SE2.identity()
    earlier, now = drawn_scan([(1.0, 0.0, 0.5)], WALL), drawn_scan([(3.0, 0.0, 0.2)], WALL)
    assert np.array_equal(nearest_thing(now, told(now, at, earlier, at)), (0.0, 0.0, 0.0))


def test_what_was_not_measured_is_not_free() -> None:
    at = SE2.identity()
    earlier, now = drawn_scan(walls=WALL), drawn_scan([(2.0, 0.0, 0.2)], WALL)
    earlier.ranges[:] = np.nan
    assert np.array_equal(nearest_thing(now, told(now, at, earlier, at)), (0.0, 0.0, 0.0))


def test_who_walks_straight_away_has_left_a_place() -> None:
    at = SE2.identity()
    earlier, now = drawn_scan([(1.6, 0.0, 0.2)], WALL), drawn_scan([(2.0, 0.0, 0.2)], WALL)
    free, known, left = nearest_thing(now, told(now, at, earlier, at))
    assert (free, known) == (0.0, 0.0)
    assert left == 1.0


def test_what_stands_behind_something_that_stands_has_left_nothing() -> None:
    circles: list[Circle] = [(1.6, 0.3, 0.2), (2.4, 0.0, 0.3)]
    earlier = drawn_scan(circles, WALL)
    now_at = SE2(0.4, -0.5, 0.2)
    now = drawn_scan(circles, WALL, now_at)
    assert told(now, now_at, earlier, SE2.identity())[:, 2].max() == 0.0


@settings(max_examples=60)
@given(
    x=st.floats(-0.4, 0.4), y=st.floats(-0.4, 0.4), yaw=st.floats(-0.5, 0.5),
    cx=st.floats(1.2, 3.2), cy=st.floats(-2.0, 2.0), radius=st.floats(0.05, 0.35),
)  # fmt: skip
def test_nothing_that_stands_is_ever_where_it_was_free(
    x: float, y: float, yaw: float, cx: float, cy: float, radius: float
) -> None:
    circles: list[Circle] = [(cx, cy, radius), (cx - 0.5, cy + 0.9, 0.1)]
    then, now_at = SE2.identity(), SE2(x, y, yaw)
    earlier, now = drawn_scan(circles, WALL), drawn_scan(circles, WALL, now_at)
    found = told(now, now_at, earlier, then)
    assert found[:, 0].max() == 0.0
    assert found[:, 2].max() < 0.5
