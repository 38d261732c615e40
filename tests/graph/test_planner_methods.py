"""Every method behind the node, on a laser and on a camera's free space; how soon it stops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped, TwistStamped  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from test_local_planner import GOAL_POSE, NODE, Robot, goal_of, speed_of  # noqa: E402

from sjmc_planner.methods import METHODS  # noqa: E402

S, PERIOD_NS = 1_000_000_000, 50_000_000
ROBOT = ("-p", "robot.radius_m:=0.2", "-p", "robot.drive:=differential")


@pytest.fixture
def launch(start: Callable[..., Any], peer: Any) -> Callable[..., Robot]:
    """Return what starts the planner with arguments on the test's own clock, and a goal ahead."""

    def _launch(*words: str, scan: str = "scan") -> Robot:
        stamped = ("-p", "enable_stamped_cmd_vel:=true", "-p", "use_sim_time:=true")
        node = start(*NODE, "--ros-args", *GOAL_POSE, *ROBOT, *stamped, *words)
        node.wait_for("ready", 120.0)
        clock = peer.publisher(Clock, "/clock", 5)
        robot = Robot(peer, node, TwistStamped, clock=clock, scan=scan)
        robot.stamp_ns = S
        peer.publisher(PoseStamped, "goal_pose", 5, to=node).publish(goal_of(2.0))
        robot.until(lambda: robot.commands and speed_of(robot.commands[-1]) > 0.1)
        return robot

    return _launch


def stamp_of(msg: TwistStamped) -> int:
    return msg.header.stamp.sec * S + msg.header.stamp.nanosec


@pytest.mark.parametrize("name", sorted(METHODS))
def test_each_method_drives_and_minds_what_stands_ahead(launch, name):
    """A post of 20 cm at 0.7 m, seen by 9 beams: it turns aside, or goes slower."""
    robot = launch("-p", f"method:={name}")
    robot.until(lambda: robot.commands[-1].twist.linear.x > 0.39)
    assert robot.commands[-1].twist.angular.z == pytest.approx(0.0, abs=1e-6)
    robot.ranges[86:95] = 0.7

    def minds() -> bool:
        twist = robot.commands[-1].twist
        return abs(twist.angular.z) > 0.05 or twist.linear.x < 0.36

    robot.until(minds)


@pytest.mark.parametrize("name", ["vfh_plus", "sjmc"])
def test_a_cameras_free_space_drives_it_as_a_laser_does(launch, name):
    """Directions behind the robot's own mast are never seen: NaN (LaserScan out, REP 117)."""
    robot = launch("-p", f"method:={name}", "-r", "scan:=floor/free_space", scan="floor/free_space")
    robot.ranges[:10] = np.nan
    robot.ranges[100:120] = -np.inf
    robot.until(robot.is_in("driving"))
    robot.ranges[:] = np.nan
    robot.until(lambda: speed_of(robot.commands[-1]) == 0.0)
    assert robot.state()[1]


def test_a_scan_that_stays_away_stops_it_within_one_period_of_its_time_limit(launch):
    """By the commands' own stamps: the last that moves is no later than 0.5 s and one period
    after the last scan."""
    robot = launch("-p", "scan_timeout_s:=0.5")
    robot.silent = {"scan"}
    last_scan_ns = robot.stamp_ns
    robot.until(lambda: speed_of(robot.commands[-1]) == 0.0)
    robot.until(robot.is_in("stopped", "/scan: "))
    moving = [stamp_of(m) for m in robot.commands if speed_of(m) > 0.0]
    assert max(moving) <= last_scan_ns + S // 2 + PERIOD_NS


def test_a_clock_that_jumps_back_stops_it_and_it_goes_on_from_there(launch):
    robot = launch()
    robot.stamp_ns += 20 * S
    robot.until(lambda: stamp_of(robot.commands[-1]) > 21 * S and speed_of(robot.commands[-1]) > 0)
    robot.stamp_ns -= 15 * S
    robot.until(lambda: stamp_of(robot.commands[-1]) < 15 * S)
    back = next(i for i, m in enumerate(robot.commands) if stamp_of(m) > 21 * S)
    later = [m for m in robot.commands[back:] if stamp_of(m) < 15 * S]
    assert speed_of(later[0]) == 0.0
    robot.until(robot.is_in("driving"))
    robot.until(lambda: speed_of(robot.commands[-1]) > 0.1)
