"""Drift of poses by hand, and kiss-icp on scans of a square room."""

from __future__ import annotations

import math

import numpy as np
import pytest

from experiments.free_space_odometry import drift, kiss_icp_poses
from floornav_common.se2 import SE2


def test_poses_that_agree_up_to_their_frame_have_no_drift() -> None:
    truth = [SE2(0.1 * k, 0.02 * k, 0.1 * k) for k in range(5)]
    other = SE2(3.0, -1.0, 2.0)
    found = drift([other @ pose for pose in truth], truth, 0.4)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-5)


def test_drift_is_counted_from_the_first_pose() -> None:
    truth = [SE2.identity(), SE2(1.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0)]
    poses = [SE2.identity(), SE2(1.0, 0.3, 0.0), SE2(2.0, 0.4, math.pi / 2.0)]
    found = drift(poses, truth, 2.0)
    assert (found["end_m"], found["worst_m"]) == pytest.approx((0.4, 0.4))
    assert found["end_share"] == pytest.approx(0.2)
    assert found["rms_m"] == pytest.approx(math.sqrt((0.09 + 0.16) / 3.0))
    assert found["end_deg"] == pytest.approx(90.0)


def test_kiss_icp_follows_a_robot_through_a_room() -> None:
    """Walls at x = -1.3 and 1.3, y = -0.7 and 0.7; 0.4 m along x in steps of 4 cm."""
    bearings = np.linspace(-math.pi, math.pi, 180, endpoint=False)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), -1)
    scans = []
    for k in range(11):
        x = 0.04 * k
        with np.errstate(divide="ignore"):
            reach = np.minimum(
                np.where(ways[:, 0] > 0, (1.3 - x) / ways[:, 0], (-1.3 - x) / ways[:, 0]),
                0.7 / np.abs(ways[:, 1]),
            )
        scans.append(reach[:, None] * ways)
    poses = kiss_icp_poses(scans)
    assert (poses[-1].x, poses[-1].y) == pytest.approx((0.4, 0.0), abs=0.03)
    assert poses[-1].yaw == pytest.approx(0.0, abs=0.02)
