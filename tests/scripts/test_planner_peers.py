"""The planners of others: they drive, they keep clear, and they get around a thing."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pyrvo", reason="pyrvo is not installed")

from experiments.planner_dwa import _clearance
from experiments.planner_peers import PEERS
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.limited_motion import moved_by, ramped
from sjmc_planner.planning import DRIVING, REACHED, STILL, Goal, Obstacles, RobotState

PERIOD, NUM = 0.05, 360
RADIUS = 0.25


def robot_of(drive: str) -> RobotConfig:
    return RobotConfig(
        drive=drive, radius_m=RADIUS, speed_m_s=0.6, accel_m_s2=0.8, yaw_accel_rad_s2=2.5
    )


def scan_of(pose: SE2, posts) -> Scan:
    """Return what a full circle of beams sees of posts (x, y, radius)."""
    step = 2.0 * np.pi / NUM
    angles = -np.pi + step * np.arange(NUM)
    ranges = np.full(NUM, np.inf)
    for x, y, r in posts:
        px, py = (pose.inverse() @ np.array([[x, y]]))[0]
        along = px * np.cos(angles) + py * np.sin(angles)
        aside2 = px * px + py * py - along**2
        near = along - np.sqrt(np.maximum(r * r - aside2, 0.0))
        ranges = np.where((aside2 < r * r) & (along > 0.0), np.minimum(near, ranges), ranges)
    return Scan(ranges, -np.pi, step, 0.02, 6.0)


def driven(name: str, drive: str, posts, goal=(4.0, 0.0)):
    """Drive by a perfect base and laser; return the places and whether the goal was reached."""
    robot = robot_of(drive)
    method = PEERS[name](LocalPlannerConfig(robot=robot, control_period_s=PERIOD))
    pose, velocity, moved = SE2.identity(), STILL, SE2.identity()
    places = [(0.0, 0.0)]
    for _ in range(500):
        point = (pose.inverse() @ np.array([goal], dtype=float))[0]
        decision = method.decide(
            RobotState(velocity, velocity, moved), Obstacles(scan_of(pose, posts), SE2.identity()),
            Goal(point, float(np.hypot(*point))),
        )  # fmt: skip
        if decision.state == REACHED:
            return np.array(places), True
        assert decision.state == DRIVING or decision.reason
        velocity = ramped(velocity, decision.command, robot, PERIOD)
        moved = moved_by(velocity, PERIOD)
        pose = pose @ moved
        places.append((pose.x, pose.y))
    return np.array(places), False


@pytest.mark.parametrize("name", sorted(PEERS))
@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_in_the_open_they_drive_straight_to_the_goal(name, drive):
    places, is_there = driven(name, drive, [])
    assert is_there and np.abs(places[:, 1]).max() < 0.02


@pytest.mark.parametrize("name", sorted(PEERS))
@pytest.mark.parametrize("drive", ["omni", "differential"])
def test_they_get_around_a_post_without_touching_it(name, drive):
    places, is_there = driven(name, drive, [(2.0, 0.08, 0.2)])
    assert is_there
    assert np.hypot(*(places - [2.0, 0.08]).T).min() >= 0.2 + RADIUS


def test_clearance_by_hand():
    """Straight at 0.5 m/s to a point 2 m ahead with 0.3 m of robot: 1.7 m; aside: none."""
    points = np.array([[2.0, 0.0]])
    v, still = np.array([0.5, 0.5]), np.zeros(2)
    turning = np.array([0.0, 1.0])
    found = _clearance(v, still, turning, points, 0.3)
    assert found[0] == pytest.approx(1.7, abs=1e-3) and np.isinf(found[1])


def test_the_wave_makes_its_way_around_what_is_seen_and_stops_where_there_is_none() -> None:
    from experiments.planner_wavefront import WavefrontPeer, map_of

    config = LocalPlannerConfig(robot=robot_of("differential"), control_period_s=PERIOD)
    state = RobotState(STILL, STILL, SE2.identity())
    seen = Obstacles(scan_of(SE2.identity(), [(2.0, 0.15, 0.4)]), SE2.identity())
    wave = WavefrontPeer(config)
    decision = wave.decide(state, seen, Goal(np.array([4.0, 0.0]), 4.0))
    assert decision.state == DRIVING and decision.command.yaw_rate < 0.0  # the freer side

    grid = map_of(np.array([[1.0, 0.5], [-2.0, 0.0]]), np.array([3.0, -1.0]))
    assert np.count_nonzero(grid.cells) == 2
    assert grid.to_cells(np.array([[0.0, 0.0], [3.0, -1.0]])).min() >= 0
    around = [(np.cos(a), np.sin(a), 0.2) for a in np.linspace(-np.pi, np.pi, 24)]
    shut = Obstacles(scan_of(SE2.identity(), around), SE2.identity())
    stopped = WavefrontPeer(config).decide(state, shut, Goal(np.array([4.0, 0.0]), 4.0))
    assert stopped.command == STILL and stopped.reason == "no direction is open"
