"""How soon the planner stops for each of its reasons, by the stamps of its own commands.

The test holds the clock, so that a busy machine changes nothing: what is sent at one time of that
clock is compared with when the reason came up.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped, TwistStamped  # noqa: E402
from nav_msgs.msg import OccupancyGrid  # noqa: E402, I001
from nav_msgs.msg import Path as PathMsg
from robot_messages import LATCHED, tf_of  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from test_local_planner import GOAL_POSE, NODE, NUM_BEAMS, Robot, goal_of, speed_of  # noqa: E402
from test_wavefront_planner import goal_of as map_goal_of  # noqa: E402
from test_wavefront_planner import map_of  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

WAVEFRONT = (Path(__file__).with_name("listening.py"), "sjmc_planner.nodes.wavefront_planner_node")
S, PERIOD_NS = 1_000_000_000, 50_000_000
LIMIT_S = 0.5  # of all inputs
ROBOT = ("-p", "robot.radius_m:=0.2", "-p", "robot.drive:=differential", "-p", "method:=vfh_plus")
STAMPED = ("-p", "enable_stamped_cmd_vel:=true", "-p", "use_sim_time:=true")


@pytest.fixture
def launch(start: Callable[..., Any], peer: Any) -> Callable[..., SimpleNamespace]:
    """Return what starts the planner on the test's own clock, and drives it by what `tell` does."""

    def _launch(*words: str, tell: Callable[[Any, Any], Any]) -> SimpleNamespace:
        node = start(*NODE, "--ros-args", *ROBOT, *STAMPED, *words)
        node.wait_for("ready", 120.0)
        robot = Robot(peer, node, TwistStamped, clock=peer.publisher(Clock, "/clock", 5))
        robot.stamp_ns = S
        told = tell(peer, node)
        robot.until(lambda: robot.commands and speed_of(robot.commands[-1]) > 0.2)
        return SimpleNamespace(robot=robot, told=told, node=node)

    return _launch


def tell_goal(peer: Any, node: Any) -> Any:
    goals = peer.publisher(PoseStamped, "goal_pose", 5, to=node)
    goals.publish(goal_of(2.0))
    return goals


def tell_path(peer: Any, node: Any) -> Any:
    paths = peer.publisher(PathMsg, "path", LATCHED, to=node)
    paths.publish(path_to(2.0))
    return paths


def path_to(*xs: float) -> PathMsg:
    msg = PathMsg(poses=[goal_of(x) for x in xs])
    msg.header.frame_id = "odom"
    return msg


def stamp_of(msg: TwistStamped) -> int:
    return msg.header.stamp.sec * S + msg.header.stamp.nanosec


def last_that_moves(robot: Robot) -> int:
    """Return when the last command that moves was sent, once zeros come for a while."""
    robot.until(lambda: len(robot.commands) > 5 and not any(map(speed_of, robot.commands[-5:])))
    return max(stamp_of(m) for m in robot.commands if speed_of(m) > 0.0)


@pytest.mark.parametrize("what", ["scan", "odom", "tf"])
def test_an_input_that_stays_away_stops_it_one_period_after_its_time(launch, what):
    robot = launch(*GOAL_POSE, tell=tell_goal).robot
    robot.silent, came_ns = {what}, robot.stamp_ns
    assert last_that_moves(robot) <= came_ns + LIMIT_S * S + PERIOD_NS
    assert robot.state()[0] == "stopped"


def test_odometry_that_is_no_number_stops_it_in_the_period_in_which_it_comes(launch):
    robot = launch(*GOAL_POSE, tell=tell_goal).robot
    robot.speed, came_ns = float("nan"), robot.stamp_ns + PERIOD_NS
    # Of the same stamp, the clock may be heard before the message.
    assert last_that_moves(robot) <= came_ns + PERIOD_NS
    assert robot.is_in("stopped", "must be finite")()


def test_a_scan_of_no_numbers_brakes_it_from_the_next_period_on_as_hard_as_it_may(launch):
    robot = launch(*GOAL_POSE, tell=tell_goal).robot
    robot.ranges, came_ns = np.full(NUM_BEAMS, np.nan), robot.stamp_ns + PERIOD_NS
    end_ns = last_that_moves(robot)
    after = [m for m in robot.commands if came_ns + PERIOD_NS <= stamp_of(m) <= end_ns]
    steps = np.diff([m.twist.linear.x for m in after])
    assert (steps <= -0.3 * PERIOD_NS / S + 1e-6).all()
    assert end_ns <= came_ns + 2 * PERIOD_NS + (0.4 / 0.3) * S


def test_a_laser_that_repeats_itself_stops_it_once_it_has_moved(launch):
    robot = launch(*GOAL_POSE, tell=tell_goal).robot
    robot.ranges, robot.noise_m, robot.speed = np.full(NUM_BEAMS, 5.0), 0.0, 0.3
    came_ns = robot.stamp_ns
    assert last_that_moves(robot) <= came_ns + (0.1 / 0.3) * S + 2 * PERIOD_NS
    assert robot.is_in("stopped", "the sensor is stuck")()
    robot.noise_m = 1e-6
    robot.until(lambda: speed_of(robot.commands[-1]) > 0.2)


@pytest.mark.parametrize(
    "xs", [(), (1.0, float("nan"))], ids=["taken back, as with a goal off the map", "no numbers"]
)
def test_a_path_taken_back_or_of_no_numbers_stops_it_at_the_next_period(launch, xs):
    run = launch(tell=tell_path)
    run.told.publish(path_to(*xs))
    heard_ns = run.robot.stamp_ns
    words = "an empty path" if not xs else "must be finite"
    run.robot.until(lambda: words in run.node.text)
    # The line may have come while the clock stood one beat further.
    said_ns = run.robot.stamp_ns
    assert last_that_moves(run.robot) <= max(heard_ns, said_ns) + PERIOD_NS
    assert run.robot.state()[0] == "idle"


def test_a_goal_outside_of_the_map_stops_a_robot_that_drives_to_another(start, peer):
    """Both planners: the goal is refused, the path taken back, the robot stands."""
    planner = start(*NODE, "--ros-args", *ROBOT, *STAMPED)
    ways = start(*WAVEFRONT, "--ros-args", "-p", "radius_m:=0.2", "-p", "use_sim_time:=true")
    planner.wait_for("ready", 120.0)
    ways.wait_for("ready", 120.0)
    clock = peer.publisher(Clock, "/clock", 5, to=ways, num=1)
    robot = Robot(peer, planner, TwistStamped, clock=clock)
    robot.stamp_ns = S
    placed = tf_of("map", "odom", 0, 1.0)
    placed.transforms[0].transform.translation.y = 1.0
    peer.publisher(TFMessage, "/tf_static", LATCHED, to=ways).publish(placed)
    peer.publisher(OccupancyGrid, "map", LATCHED, to=ways).publish(map_of())
    goals = peer.publisher(PoseStamped, "goal_pose", 5, to=ways)
    goals.publish(map_goal_of(5.0, 1.0))
    robot.until(lambda: robot.commands and speed_of(robot.commands[-1]) > 0.2)
    goals.publish(map_goal_of(50.0, 1.0))
    robot.until(lambda: "outside of the map" in ways.text)
    robot.until(robot.is_in("idle"))
    said_ns = robot.stamp_ns
    assert last_that_moves(robot) <= said_ns + PERIOD_NS


@pytest.mark.parametrize("method", ["sjmc", "vfh_plus", "omni_velocity"])
def test_commands_never_change_faster_than_the_robot_may(launch, method):
    """A wall jumps to and fro before it, so that it turns, brakes and starts again."""
    robot = launch(*GOAL_POSE, "-p", f"method:={method}", tell=tell_goal).robot
    for k in range(120):
        robot.ranges = np.full(NUM_BEAMS, np.inf)
        if k % 40 > 20:
            robot.ranges[80:100] = 0.55
        robot.beat()
    assert robot.state()[0] != "stopped"
    speeds = np.array([m.twist.linear.x for m in robot.commands])
    turns = np.array([m.twist.angular.z for m in robot.commands])
    assert np.abs(np.diff(speeds)).max() <= 0.3 * PERIOD_NS / S + 1e-6
    assert np.abs(np.diff(turns)).max() <= 2.0 * PERIOD_NS / S + 1e-6
    assert np.abs(speeds).max() <= 0.4 + 1e-6 and np.abs(turns).max() <= 1.2 + 1e-6
    assert np.abs(np.diff(speeds)).max() > 0.0
