"""The live team's figures: errors at the stamps of poses, over what was heard."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="the experiment runs nodes")

from experiments.live_team_graph import ROBOTS, Heard
from floornav_common.se2 import SE2

S = 1_000_000_000


def heard_of(off: SE2, cov: np.ndarray) -> Heard:
    """Two poses of each robot, off by so much while it drives along x at 1 m/s."""
    heard = Heard(1)
    for name in ROBOTS:
        for second in (1, 2):
            heard._truth[name].add(second * S, SE2(float(second), 0.0, 0.0))
        for topic in ("landmark_pose", "team_pose"):
            for stamp_ns in (S + S // 2, 5 * S):
                pose = SE2(stamp_ns / S + off.x, off.y, off.yaw)
                heard._poses[name, topic].append((stamp_ns, pose, cov))
    return heard


def test_errors_are_taken_where_the_truth_is_known() -> None:
    heard = heard_of(SE2(0.03, -0.04, 0.1), np.diag([0.03**2, 0.04**2, 0.1**2]))
    found = heard.errors("r1", "team_pose")
    assert found["poses"] == 1  # nothing is true of the fifth second
    assert (found["mean_x_mm"], found["mean_y_mm"]) == pytest.approx((30.0, 40.0))
    assert found["mean_deg"] == pytest.approx(math.degrees(0.1))
    assert found["rms_m"] == pytest.approx(0.05)
    assert found["nees"] == pytest.approx(3.0)


def test_a_robot_that_says_nothing_has_no_errors() -> None:
    found = Heard(1).errors("r2", "team_pose")
    assert found["poses"] == 0 and found["rms_m"] is None
