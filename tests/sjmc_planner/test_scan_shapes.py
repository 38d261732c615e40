"""Middles of things in a scan, by hand and against drawn bodies."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scans import Circle, drawn_scan

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.scan_clusters import cluster_beams
from sjmc_planner.scan_shapes import HALF, HIDDEN, NUM_COLUMNS, WIDTH, X, Y, shapes_of

TOL_M = 0.02


def shapes(scan: Scan, sensor: SE2 | None = None, radius: float = 0.2) -> np.ndarray:
    num = len(scan.ranges)
    labels, ends = np.empty(num, dtype=np.int64), np.empty((num, 3), dtype=np.int64)
    step = abs(scan.angle_increment)
    count = cluster_beams(scan.ranges, scan.range_min, scan.range_max, step, 0.8, labels, ends)
    rows, which = np.empty((count, NUM_COLUMNS)), np.empty(count, dtype=np.int64)
    place = (SE2.identity() if sensor is None else sensor).as_array()
    num_rows = shapes_of(
        scan.ranges, ends, count, scan.angle_min, scan.angle_increment, place, 0.8, radius, rows,
        which,
    )  # fmt: skip
    return rows[:num_rows]


@pytest.mark.parametrize(
    ("x", "y", "radius"), [(2.0, 0.0, 0.2), (-1.5, 1.0, 0.25), (3.0, -2.0, 0.3)]
)
def test_the_middle_and_radius_of_a_body(x: float, y: float, radius: float) -> None:
    (row,) = shapes(drawn_scan([(x, y, radius)], num_beams=1440))
    assert np.allclose(row[[X, Y, HALF]], (x, y, radius), atol=TOL_M)


def test_a_leg_is_found_where_it_stands() -> None:
    (row,) = shapes(drawn_scan([(1.5, 0.4, 0.065)], num_beams=1440))
    assert np.allclose(row[[X, Y]], (1.5, 0.4), atol=TOL_M)
    assert row[WIDTH] < 0.14


def test_places_are_in_the_frame_of_the_sensors_pose() -> None:
    sensor = SE2(1.0, -2.0, 0.7)
    (row,) = shapes(drawn_scan([(2.0, -1.0, 0.2)], T_world_sensor=sensor, num_beams=1440), sensor)
    assert np.allclose(row[[X, Y]], (2.0, -1.0), atol=TOL_M)


def test_a_body_half_hidden_is_found_from_its_free_edge() -> None:
    circles: list[Circle] = [(1.0, 0.1, 0.1), (2.0, 0.0, 0.2)]  # the near one hides its left half
    rows = shapes(drawn_scan(circles, num_beams=1440))
    (row,) = rows[rows[:, X] > 1.5]
    assert row[HIDDEN] == 1.0
    assert np.allclose(row[[X, Y]], (2.0, 0.0), atol=0.05)
    (alone,) = shapes(drawn_scan(circles[1:], num_beams=1440))
    assert alone[HIDDEN] == 0.0


def test_walls_are_left_out() -> None:
    assert len(shapes(drawn_scan(walls=[(2, -3, 2, 3)]))) == 0


def test_a_mirrored_scan_has_mirrored_middles() -> None:
    circles: list[Circle] = [(2.0, 0.5, 0.2), (1.5, 0.9, 0.1), (-1.0, 2.0, 0.06)]
    scan = drawn_scan(circles, num_beams=721, fov=4.2)
    flipped = Scan(scan.ranges[::-1].copy(), scan.angle_min, scan.angle_increment, 0.05, 8.0)
    a, b = shapes(scan), shapes(flipped)
    assert np.allclose(a[:, [X, Y]], b[::-1][:, [X, Y]] * (1.0, -1.0), atol=1e-9)
