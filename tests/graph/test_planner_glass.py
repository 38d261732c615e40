"""Glass before the planner, over DDS: of `map/glass`, and heard by a sonar; a scan sees none."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from nav_msgs.msg import OccupancyGrid  # noqa: E402, I001
from robot_messages import LATCHED, tf_of, time_of  # noqa: E402
from sensor_msgs.msg import Range  # noqa: E402
from test_local_planner import GOAL_POSE, NODE, Robot, goal_of, speed_of  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

ROBOT = ("-p", "robot.radius_m:=0.2", "-p", "robot.drive:=differential")


def pane_map(x: float, frame: str = "map") -> OccupancyGrid:
    """Return a layer of 4 x 4 m about the origin with a pane across it at x."""
    cells = np.full((80, 80), -1, dtype=np.int8)
    cells[:, round((x + 2.0) / 0.05)] = 100
    msg = OccupancyGrid()
    msg.header.frame_id = frame
    msg.info.width, msg.info.height, msg.info.resolution = 80, 80, 0.05
    msg.info.origin.position.x = msg.info.origin.position.y = -2.0
    msg.info.origin.orientation.w = 1.0
    msg.data = cells.ravel().tolist()
    return msg


@pytest.fixture
def launch(start: Callable[..., Any], peer: Any) -> Callable[..., SimpleNamespace]:
    """Return what starts the planner with arguments, and a goal 2 m ahead of an open scan."""

    def _launch(*words: str) -> SimpleNamespace:
        node = start(*NODE, "--ros-args", *GOAL_POSE, *ROBOT, *words)
        node.wait_for("ready", 120.0)
        robot = Robot(peer, node)
        run = SimpleNamespace(
            node=node, robot=robot, peer=peer,
            glass=peer.publisher(OccupancyGrid, "map/glass", LATCHED, to=node),
            sonar=peer.publisher(Range, "sonar", 10, to=node),
            statics=peer.publisher(TFMessage, "/tf_static", LATCHED, to=node),
        )  # fmt: skip
        peer.publisher(PoseStamped, "goal_pose", 5, to=node).publish(goal_of(2.0))
        robot.until(lambda: robot.commands and speed_of(robot.commands[-1]) > 0.3)
        return run

    return _launch


def is_ahead(robot: Robot) -> bool:
    """Tell whether the robot drives straight on."""
    last = robot.commands[-1]
    return last.linear.x > 0.3 and abs(last.angular.z) < 0.01


@pytest.mark.parametrize("method", ["sjmc", "vfh_plus", "omni_velocity"])
def test_a_pane_of_the_map_stops_or_turns_it_where_the_map_frame_says(launch, method):
    """The map's origin is 5 m behind the robot: a pane at 0.7 m of it is far behind."""
    run = launch("-p", f"method:={method}")
    run.statics.publish(tf_of("map", "odom", 0, 5.0))
    run.glass.publish(pane_map(0.7))
    for _ in range(20):
        run.robot.beat()
    assert is_ahead(run.robot)
    run.statics.publish(tf_of("map", "odom", 0, 0.0))
    run.robot.until(lambda: not is_ahead(run.robot))
    run.glass.publish(pane_map(-1.5))
    run.robot.until(lambda: is_ahead(run.robot))


def test_what_is_not_to_be_minded_is_not_listened_to(start, peer):
    node = start(*NODE, "--ros-args", "-p", "known.minds_map:=false", "-p", "known.echo_m:=0.0")
    node.wait_for("ready", 120.0)
    Robot(peer, node)  # waits until its inputs are found
    assert peer.node.count_subscribers("odom") == 1
    assert peer.node.count_subscribers("map/glass") == 0
    assert peer.node.count_subscribers("sonar") == 0


def test_glass_somewhere_on_a_map_where_the_robot_is_not_placed_stops_it(launch):
    run = launch("-p", "method:=vfh_plus")
    run.glass.publish(pane_map(-1.5))
    run.robot.until_stopped("pose: ")
    assert "'map'" in run.robot.state()[1]
    run.statics.publish(tf_of("map", "odom", 0, 0.0))
    run.robot.until(run.robot.is_in("driving"))


def echo_of(run: SimpleNamespace, r: float, frame: str = "sonar_0") -> Range:
    msg = Range(radiation_type=Range.ULTRASOUND, field_of_view=0.35, min_range=0.1, max_range=5.0)
    msg.header.stamp = time_of(run.peer.node.get_clock().now().nanoseconds)
    msg.header.frame_id, msg.range = frame, r
    return msg


def beat_with_echoes(run: SimpleNamespace, r: float) -> None:
    run.sonar.publish(echo_of(run, r))
    run.robot.beat()


@pytest.mark.parametrize("method", ["sjmc", "vfh_plus"])
def test_echoes_from_close_by_stop_or_turn_it_until_they_are_over(launch, method):
    run = launch("-p", f"method:={method}", "-p", "known.echo_hold_s:=0.5")
    run.statics.publish(tf_of("base_link", "sonar_0", 0, 0.1))
    run.peer.spin(0.2)
    for _ in range(400):
        beat_with_echoes(run, 0.5)
        if not is_ahead(run.robot):
            break
    assert not is_ahead(run.robot)
    for _ in range(400):
        beat_with_echoes(run, 3.0)
        if is_ahead(run.robot):
            break
    assert is_ahead(run.robot)


def test_a_sonar_that_was_heard_and_falls_silent_stops_it(launch):
    run = launch("-p", "method:=vfh_plus")
    run.statics.publish(tf_of("base_link", "sonar_0", 0, 0.1))
    run.peer.spin(0.2)
    for _ in range(10):
        beat_with_echoes(run, 3.0)
    assert run.robot.state()[0] == "driving"
    run.robot.until_stopped("/sonar: no longer arriving")
    for _ in range(400):
        beat_with_echoes(run, 3.0)
        if run.robot.state()[0] == "driving":
            break
    assert run.robot.state()[0] == "driving"


def test_an_echo_of_a_sonar_that_nobody_placed_stops_it(launch):
    run = launch("-p", "method:=vfh_plus")
    for _ in range(400):
        beat_with_echoes(run, 0.8)
        if run.robot.state()[0] == "stopped":
            break
    assert "sonar_0" in run.robot.state()[1]
