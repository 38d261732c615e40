"""What the beams of a scan say of the robot's surroundings."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.beam_ends import BeamReader
from sjmc_planner.planning import Obstacles

STEP = np.pi / 8
NAN, INF = np.nan, np.inf


def read(ranges, gap=0.0, sensor=None, angle_min=-np.pi, range_min=0.5, range_max=4.0):
    scan = Scan(np.array(ranges, dtype=float), angle_min, STEP, range_min, range_max)
    return BeamReader(gap).read(Obstacles(scan, SE2.identity() if sensor is None else sensor))


def test_a_hit_stands_where_its_beam_ends_seen_from_the_base():
    """A laser 1 m ahead that looks left, a hit 2 m ahead of it: at (1, 2)."""
    ends = read([INF, 2.0, INF], angle_min=-STEP, sensor=SE2(1.0, 0.0, np.pi / 2))
    assert ends.points == pytest.approx(np.array([[1.0, 2.0]]))


def test_what_each_range_means():
    """REP 117, and a driver's 0 for no return: not looked."""
    ends = read([INF, 5.0, 3.0, 0.2, -INF, NAN, 0.0], angle_min=0.0)
    assert ends.ranges[:5].tolist() == [INF, INF, 3.0, 0.5, 0.5]
    assert np.isnan(ends.ranges[5:]).all()
    assert len(ends.points) == 3


def test_narrow_gaps_take_the_nearer_range_beside_them_and_wide_ones_stay():
    ranges = [1.0, NAN, 2.0, NAN, NAN, 3.0]
    one = read(ranges, gap=STEP, angle_min=0.0).ranges
    assert one[:3].tolist() == [1.0, 1.0, 2.0] and np.isnan(one[3:5]).all()
    two = read(ranges, gap=2.0 * STEP, angle_min=0.0).ranges
    assert two.tolist() == [1.0, 1.0, 2.0, 2.0, 2.0, 3.0]


def test_a_gap_over_the_ends_of_a_full_circle_is_one_gap():
    ranges = np.full(16, 2.0)
    ranges[[0, 15]], ranges[14] = NAN, 1.0
    assert np.isnan(read(ranges, gap=STEP).ranges[[0, 15]]).all()
    assert read(ranges, gap=2.0 * STEP).ranges[[0, 15]].tolist() == [1.0, 1.0]


def test_a_gap_at_the_end_of_a_part_of_a_circle_has_one_side():
    assert read([NAN, 2.0, 1.0, NAN], gap=STEP, angle_min=0.0).ranges.tolist() == [2, 2, 1, 1]


def test_directions_that_no_beam_looked_along_are_unseen():
    """Beams from 0 to 90 degrees; the one at 45 degrees saw nothing."""
    ends = read([1.0, INF, NAN, INF, INF], angle_min=0.0)
    bearings = np.radians([0.0, 22.5, 45.0, 60.0, 80.0, 101.0, 102.0, -12.0, 180.0])
    unseen = ends.unseen(bearings, 0.1, 2.0).tolist()
    assert unseen == [False, False, True, True, False, False, True, True, True]


def test_a_full_circle_has_no_unseen_direction():
    bearings = np.linspace(-np.pi, np.pi, 101)
    assert not read(np.full(16, INF)).unseen(bearings, 0.1, 2.0).any()


def test_what_a_laser_ahead_has_beside_it_is_unseen():
    """A half circle from 1 m ahead: beside the robot's middle nothing was looked at."""
    ends = read(np.full(9, INF), angle_min=-np.pi / 2, sensor=SE2(1.0, 0.0, 0.0))
    assert ends.unseen(np.radians([0.0, 90.0]), 1.1, 2.0).tolist() == [False, True]
