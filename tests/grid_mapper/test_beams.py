"""Beams placed in the map: which are used, where they point, how far they reach."""

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.beams import beams_of

VALUES = np.array([1.0, np.nan, np.inf, -np.inf, 0.0, 20.0, 0.05, 3.0])


def test_only_hits_and_clear_beams_are_used():
    scan = Scan(VALUES, -0.3, 0.1, 0.1, 10.0)
    beams = beams_of(scan, SE2(1.0, 2.0, 0.5), no_return_free_m=4.0)
    assert beams.is_hit.tolist() == [True, False, True]
    assert beams.ranges == pytest.approx([1.0, 4.0, 3.0])
    assert beams.angles == pytest.approx([0.2, 0.4, 0.9])
    assert beams.origins.tolist() == [[1.0, 2.0]] * 3


@pytest.mark.parametrize(("free", "reach"), [(0.0, []), (4.0, [4.0]), (50.0, [10.0])])
def test_a_beam_without_return_is_free_as_far_as_asked_but_not_beyond_its_range(free, reach):
    scan = Scan(np.array([np.inf]), 0.0, 0.1, 0.1, 10.0)
    assert beams_of(scan, SE2.identity(), free).ranges.tolist() == reach


def test_a_clockwise_sensor_is_placed_clockwise():
    scan = Scan(np.array([1.0, 1.0]), 0.3, -0.1, 0.1, 10.0)
    beams = beams_of(scan, SE2.identity(), 0.0)
    assert beams.angles == pytest.approx([0.3, 0.2]) and beams.angle_increment == 0.1


def test_beams_of_a_moving_sensor_end_where_its_points_are():
    scan = Scan(VALUES, -0.3, 0.1, 0.1, 10.0, 0.02, (0.5, -0.2, 1.5))
    pose = SE2(1.0, 2.0, 0.5)
    beams = beams_of(scan, pose, no_return_free_m=4.0)
    ends = beams.origins + beams.ranges[:, None] * np.column_stack(
        (np.cos(beams.angles), np.sin(beams.angles))
    )
    assert ends[beams.is_hit] == pytest.approx(pose @ scan.points())
    moved = beams.origins - [1.0, 2.0]
    assert np.hypot(*moved.T) == pytest.approx([0.0, 0.04 * 0.5385, 0.14 * 0.5385], rel=3e-3)
    assert beams.angle_increment == pytest.approx(0.1 + 1.5 * 0.02)
