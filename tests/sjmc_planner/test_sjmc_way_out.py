"""Ways out: the way round that is free beside a pane, kept to until a course is faced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sjmc_scenes import CONFIG, PERIOD, ROBOT, scan_of

from floornav_common.se2 import SE2
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.methods import make_method
from sjmc_planner.planning import REACHED, STILL, TURNING, Goal, Obstacles, RobotState

HERE = SE2.identity()
ALONG = np.arange(-3.0, 3.0, 0.05)
LONG_S = 40.0


def gap(points: np.ndarray, pose: SE2) -> float:
    """Return how far the robot's box is from points, m."""
    x, y = (pose.inverse() @ points).T
    ahead = np.maximum(np.maximum(x - ROBOT.front_m, -ROBOT.rear_m - x), 0.0)
    return float(np.hypot(ahead, np.maximum(np.abs(y) - ROBOT.half_width_m, 0.0)).min())


def drive(points: np.ndarray, goal: np.ndarray) -> tuple[list[str], list[SE2], list[float]]:
    """Drive among points that only a map knows; return states, poses and gaps."""
    method, pose, velocity, moved = make_method(CONFIG), HERE, STILL, HERE
    states, poses, gaps = [], [], []
    for _ in range(round(LONG_S / PERIOD)):
        target = (pose.inverse() @ goal[None])[0]
        seen = replace(Obstacles(scan_of([]), HERE), known=pose.inverse() @ points)
        decision = method.decide(
            RobotState(velocity, velocity, moved), seen, Goal(target, float(np.hypot(*target)))
        )
        velocity = ramped(velocity, decision.command, ROBOT, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
        states.append(decision.state)
        poses.append(pose)
        gaps.append(gap(points, pose))
        if decision.state == REACHED:
            break
    return states, poses, gaps


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("off", [0.40, 0.45])
def test_beside_a_pane_it_turns_its_nose_past_where_its_tail_would_not_pass(
    side: float, off: float
) -> None:
    """The goal is behind on the open side; turned that way, the tail would go through the pane."""
    pane = np.column_stack((ALONG, np.full(len(ALONG), side * off)))
    states, poses, gaps = drive(pane, np.array([-2.0, -1.5 * side]))
    assert states[-1] == REACHED and min(gaps) > 0.02
    first = next(pose.yaw for pose in poses if abs(pose.yaw) > 0.5)
    assert np.sign(first) == side  # towards the pane
    assert TURNING in states


def test_what_is_taken_for_something_in_the_robot_takes_no_care_off_the_rest() -> None:
    """A speck in the robot; a post right before it, and the goal behind the post."""
    speck = np.array([[0.1, 0.1]])
    method, pose, velocity, moved = make_method(CONFIG), HERE, STILL, HERE
    post = np.column_stack((np.full(21, 0.6), np.linspace(-0.5, 0.5, 21)))
    for _ in range(100):
        known = np.concatenate((speck, pose.inverse() @ post))  # the speck goes along
        seen = replace(Obstacles(scan_of([]), HERE), known=known)
        target = (pose.inverse() @ np.array([[3.0, 0.0]]))[0]
        decision = method.decide(RobotState(velocity, velocity, moved), seen, Goal(target, 3.0))
        velocity = ramped(velocity, decision.command, ROBOT, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
        assert gap(post, pose) > 0.02
