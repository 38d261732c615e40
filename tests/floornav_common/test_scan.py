"""Scans: which beams are measurements (REP 117), and where their points are."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.twists import steady_offsets

NAN, INF = math.nan, math.inf


def test_points_lie_where_the_beams_point():
    scan = Scan(np.array([1.0, 2.0, 3.0]), -math.pi / 2.0, math.pi / 2.0, 0.1, 10.0)
    assert scan.points() == pytest.approx(np.array([[0.0, -1.0], [2.0, 0.0], [0.0, 3.0]]), abs=1e-9)


@pytest.mark.parametrize(
    ("value", "is_hit"),
    [(1.0, True), (0.5, True), (10.0, True), (0.49, False), (10.1, False), (0.0, False),
     (-1.0, False), (NAN, False), (INF, False), (-INF, False)],
)  # fmt: skip
def test_only_ranges_within_the_limits_are_hits(value, is_hit):
    scan = Scan(np.array([value]), 0.0, 0.1, 0.5, 10.0)
    assert scan.is_hit.tolist() == [is_hit]
    assert len(scan.points()) == is_hit


def test_a_limit_of_infinity_does_not_make_infinity_a_hit():
    assert not Scan(np.array([INF]), 0.0, 0.1, 0.0, INF).is_hit.any()


def test_a_beam_of_a_turning_and_driving_sensor_by_hand():
    # 1 m/s ahead, a quarter of a turn in the second between two beams: an arc to (2, 2) / pi.
    scan = Scan(np.array([1.0, 3.0]), 0.0, 0.0, 0.1, 10.0, 1.0, (1.0, 0.0, math.pi / 2.0))
    there = 2.0 / math.pi
    assert scan.angles == pytest.approx([0.0, math.pi / 2.0])
    assert scan.points() == pytest.approx(np.array([[1.0, 0.0], [there, there + 3.0]]))


ranges = st.lists(st.floats(0.2, 20.0), min_size=2, max_size=40)
rates = st.floats(-2.0, 2.0)


@given(ranges, st.tuples(rates, rates, rates), st.floats(-0.01, 0.01))
def test_each_point_is_what_its_beam_measured_from_where_the_sensor_was(values, twist, step):
    raw = Scan(np.array(values), -1.0, 0.05, 0.1, 30.0, step)
    points = replace(raw, twist=twist).points()
    for k, (point, measured) in enumerate(zip(points, raw.points(), strict=True)):
        (x, y) = steady_offsets(twist, np.array([k * step]))[0]
        then = SE2(x, y, twist[2] * k * step)
        assert (then.inverse() @ point[None])[0] == pytest.approx(measured, abs=1e-9)


@given(ranges, st.floats(0.0, 0.01))
def test_a_sensor_that_stands_sees_what_one_without_motion_sees(values, step):
    still = Scan(np.array(values), -1.0, 0.05, 0.1, 30.0, step)
    assert np.array_equal(replace(still, twist=(0.0, 0.0, 0.0)).points(), still.points())
    assert np.array_equal(replace(still, twist=(1.0, 0.5, 1.0)).points()[0], still.points()[0])
