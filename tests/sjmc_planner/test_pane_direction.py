"""Which way a pane lies: told by echoes of several places, and by none alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from sjmc_planner.pane_direction import pane_line

TOL_RAD = 0.06
NO_PLACES, NO_RANGES = np.zeros((0, 2)), np.zeros(0)


def line_of(tilt: float, mount: SE2, num: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Return places passed on the way to a sonar along a line, and how far off it is of each.

    The line is 0.8 m off the sonar, its normal `tilt` beside the sonar's axis.
    """
    normal = np.array([np.cos(mount.yaw + tilt), np.sin(mount.yaw + tilt)])
    way = np.array([np.cos(mount.yaw - 1.0), np.sin(mount.yaw - 1.0)])
    places = np.array([mount.x, mount.y]) - np.outer(0.12 * np.arange(1, num + 1), way)
    return places, 0.8 + (np.array([mount.x, mount.y]) - places) @ normal


def test_an_echo_alone_lies_across_the_axis_and_is_told_by_no_other() -> None:
    line = pane_line(0.8, SE2(0.2, 0.1, 1.0), NO_PLACES, NO_RANGES)
    assert line.tilt == pytest.approx(0.0, abs=1e-9) and line.num_others == 0


@pytest.mark.parametrize("tilt", [-0.35, -0.15, 0.0, 0.2, 0.4])
def test_echoes_on_a_drive_past_a_pane_tell_which_way_it_lies(tilt: float) -> None:
    mount = SE2(0.14, 0.28, 0.785)
    line = pane_line(0.8, mount, *line_of(tilt, mount))
    assert line.tilt == pytest.approx(tilt, abs=TOL_RAD) and line.num_others == 6


def test_echoes_of_other_things_are_not_counted() -> None:
    mount = SE2(0.0, 0.0, 0.0)
    places, ranges = line_of(0.2, mount)
    places = np.concatenate((places, [[0.0, 0.3], [0.1, 0.4]]))
    line = pane_line(0.8, mount, places, np.append(ranges, [0.3, 0.25]))
    assert line.tilt == pytest.approx(0.2, abs=TOL_RAD) and line.num_others == 6


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-0.4, 0.4))
def test_moving_robot_and_pane_together_changes_nothing(
    yaw: float, x: float, y: float, tilt: float
) -> None:
    mount, moved = SE2(0.1, 0.2, 0.5), SE2(x, y, yaw)
    places, ranges = line_of(tilt, mount)
    here, there = (pane_line(0.8, mount, places, ranges),
                   pane_line(0.8, moved @ mount, moved @ places, ranges))  # fmt: skip
    assert there.num_others == here.num_others
    assert there.tilt == pytest.approx(here.tilt, abs=0.04)  # a step of what is asked
