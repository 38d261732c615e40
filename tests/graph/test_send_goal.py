"""The command that sends a goal to the planner, over DDS."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from nav_msgs.msg import OccupancyGrid  # noqa: E402
from robot_messages import LATCHED, tf_of  # noqa: E402
from test_local_planner import NODE as LOCAL_PLANNER  # noqa: E402
from test_local_planner import Robot, launch  # noqa: E402, F401, a fixture
from test_wavefront_planner import NODE as WAVEFRONT_PLANNER  # noqa: E402
from test_wavefront_planner import map_of  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

SENDER = (Path(__file__).with_name("listening.py"), "sjmc_planner.nodes.send_goal_node")


def test_a_goal_sent_by_the_command_is_followed_until_it_is_reached(launch, start):  # noqa: F811
    run = launch(goal=False)
    far = start(*SENDER, "--ros-args", "-p", "x_m:=2.0", "-p", "y_m:=-0.5")
    run.robot.until(lambda: "driving, 2.06 m left" in far.text)
    assert far.stop(signal.SIGINT) == 0 and "reached" not in far.text
    here = start(*SENDER, "--ros-args", "-p", "x_m:=0.0")
    run.robot.until(lambda: here.has_ended)
    assert here.wait_for_exit() == 0 and "reached, 0.00 m left" in here.text


def test_a_goal_that_nobody_listens_to_is_said_and_one_sent_without_waiting_is_enough(start, peer):
    given = ("--ros-args", "-p", "x_m:=1", "-p", "y_m:=-0.5", "-p", "waits:=false")
    sender = start(*SENDER, *given)
    sender.wait_for("nobody listens to /goal_pose")
    goals = peer.collect(PoseStamped, "goal_pose", 5)
    peer.spin_until(lambda: sender.has_ended)
    assert sender.wait_for_exit() == 0
    peer.spin_until(lambda: goals)
    assert goals[0].header.frame_id == "odom"
    assert (goals[0].pose.position.x, goals[0].pose.position.y) == (1.0, -0.5)


def goal(x: float, frame: str = "odom") -> tuple[str, ...]:
    """Return arguments; `odom` lies at (1, 1) m on the map, and the robot at its origin."""
    return "--ros-args", "-p", f"frame:={frame}", "-p", f"x_m:={x}", "-p", "y_m:=0.0"


@pytest.fixture
def over_a_map(start, peer) -> Robot:
    """Return the robot of both planners, which stands in a room of 6 x 4 m."""
    ways = start(*WAVEFRONT_PLANNER, "--ros-args", "-p", "radius_m:=0.2")
    planner = start(*LOCAL_PLANNER)
    for node in (ways, planner):
        node.wait_for("ready", 120.0)
    robot = Robot(peer, planner)
    peer.publisher(OccupancyGrid, "map", LATCHED, to=ways).publish(map_of())
    placed = tf_of("map", "odom", 0, 1.0)
    placed.transforms[0].transform.translation.y = 1.0
    mounted = tf_of("base_link", "laser", 0, 0.0)
    placed.transforms.append(mounted.transforms[0])
    peer.publisher(TFMessage, "/tf_static", LATCHED, to=ways).publish(placed)
    robot.ways, robot.planner = ways, planner
    return robot


def test_reached_is_said_of_the_goal_that_was_sent_and_of_no_other(over_a_map, start):
    robot = over_a_map
    here = start(*SENDER, *goal(0.0))
    robot.until(lambda: here.has_ended)
    assert here.wait_for_exit() == 0 and "reached, 0.00 m left" in here.text
    unknown = start(*SENDER, *goal(0.0, "nowhere"))
    robot.until(lambda: "waiting: frame 'nowhere'" in unknown.text or unknown.has_ended)
    seen = len(robot.states)
    robot.until(lambda: len(robot.states) > seen + 12)  # six seconds more
    assert not unknown.has_ended and "reached" not in unknown.text
    assert unknown.stop(signal.SIGINT) == 0
    assert robot.planner.text.count("an empty path") == 1
    assert robot.ways.text.count("m to map (1.000, 1.000) found") == 1


@pytest.mark.parametrize(
    ("given", "words"),
    [(goal(100.0, "map"), "is outside of the map"), (goal(1.0, "base_link"), "fixed to the robot")],
)
def test_a_goal_without_a_way_is_said_with_its_reason_and_given_up(over_a_map, start, given, words):
    sender = start(*SENDER, *given)
    over_a_map.until(lambda: sender.has_ended)
    assert sender.wait_for_exit() == 1
    assert words in sender.text and "given up: no way" in sender.text
    assert sender.text.count("no way: ") == 1
