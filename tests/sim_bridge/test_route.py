"""The route follower, with a robot that does what it is told."""

import math

import pytest

from floornav_common.se2 import SE2
from sim_bridge.config import RouteConfig
from sim_bridge.route import RouteFollower

DT = 0.05


def _drive(route: tuple[float, ...], pose: SE2, max_steps: int = 2000) -> list[SE2]:
    follower, poses = RouteFollower(RouteConfig(route_m=route)), [pose]
    for _ in range(max_steps):
        command = follower.step(poses[-1])
        if command is None:
            return poses
        motion = SE2(command.speed * DT, 0.0, 0.0) @ SE2(0.0, 0.0, command.yaw_rate * DT)
        poses.append(poses[-1] @ motion)
    pytest.fail("did not arrive")


def test_it_arrives_at_the_end_of_a_bent_route() -> None:
    last = _drive((0.0, 0.0, 3.0, 0.0, 3.0, 3.0), SE2.identity())[-1]
    assert math.hypot(last.x - 3.0, last.y - 3.0) < 0.1


def test_it_stays_near_the_line() -> None:
    poses = _drive((0.0, 0.0, 5.0, 0.0), SE2(0.0, 0.1, 0.3))
    assert max(abs(pose.y) for pose in poses[60:]) < 0.02


def test_a_dead_end_is_driven_in_and_out() -> None:
    poses = _drive((0.0, 0.0, 3.0, 0.0, 0.0, 0.0), SE2.identity())
    assert max(pose.x for pose in poses) > 2.5
    assert math.hypot(poses[-1].x, poses[-1].y) < 0.1


def test_a_crossing_is_not_taken_for_a_short_cut() -> None:
    eight = (0.0, 0.0, 4.0, 0.0, 4.0, 2.0, 2.0, 2.0, 2.0, -2.0, 0.0, -2.0)
    poses = _drive(eight, SE2.identity())
    assert max(pose.y for pose in poses) > 1.7


def test_an_odd_number_of_coordinates_is_refused() -> None:
    with pytest.raises(ValueError, match="route_m"):
        RouteConfig(route_m=(1.0, 2.0, 3.0))
