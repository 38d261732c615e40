"""A planner whose pose has two sources that contradict each other stops, and says why."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from geometry_msgs.msg import PoseStamped, TwistStamped  # noqa: E402
from robot_messages import tf_of  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from test_local_planner import GOAL_POSE, NODE, Robot, goal_of, speed_of  # noqa: E402
from test_planner_stops import PERIOD_NS, ROBOT, STAMPED, S, last_that_moves  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

from floornav_common.ros.qos import RELIABLE_QOS  # noqa: E402

AHEAD_NS = 2 * PERIOD_NS  # as our localizers stamp map->odom
BESIDE_M = 1.5


class PlacedRobot(Robot):
    """Somebody says where its `odom` is: `places`, one source each, the first stamped ahead."""

    def __init__(self, peer: Any, node: Any) -> None:
        super().__init__(peer, node, TwistStamped, clock=peer.publisher(Clock, "/clock", 5))
        self.stamp_ns = S
        self.places: list[float] = [0.0]
        self._map_tf = peer.publisher(TFMessage, "/tf", 10, to=node, num=2)
        self.sayings = peer.publisher(DiagnosticArray, "/diagnostics", RELIABLE_QOS, to=node)

    def beat(self) -> None:
        """Send what a robot sends, and where it is."""
        assert self.stamp_ns is not None
        for number, place in enumerate(self.places):
            ahead_ns = PERIOD_NS + (0 if number else AHEAD_NS)
            self._map_tf.publish(tf_of("map", "odom", self.stamp_ns + ahead_ns - number, place))
        super().beat()

    def say(self, level: bytes, text: str, who: str = "/grid_mapper") -> None:
        """Say what a localizer says of map->odom."""
        status = DiagnosticStatus(level=level, name=f"{who}: transform map to odom", message=text)
        self.sayings.publish(DiagnosticArray(status=[status]))

    def drives(self) -> bool:
        """Return whether the newest command moves it."""
        return bool(self.commands) and speed_of(self.commands[-1]) > 0.2


@pytest.fixture
def robot(start: Callable[..., Any], peer: Any) -> PlacedRobot:
    """Return a robot that drives to a goal in `map`."""
    node = start(*NODE, "--ros-args", *ROBOT, *STAMPED, *GOAL_POSE)
    node.wait_for("ready", 120.0)
    placed = PlacedRobot(peer, node)
    goal = goal_of(20.0)
    goal.header.frame_id = "map"
    peer.publisher(PoseStamped, "goal_pose", 5, to=node).publish(goal)
    placed.until(placed.drives)
    return placed


def test_two_that_send_map_to_odom_stop_it_until_one_is_left(robot: PlacedRobot) -> None:
    robot.places, came_ns = [0.0, BESIDE_M], robot.stamp_ns
    assert last_that_moves(robot) <= came_ns + 4 * PERIOD_NS
    assert robot.is_in("stopped", "'map' to 'odom' jumps to and fro by 1.5 m")()
    robot.places = [BESIDE_M]
    robot.until(robot.drives)


def test_one_that_corrects_itself_does_not_stop_it(robot: PlacedRobot) -> None:
    """As after a loop was closed, or after `initialpose`."""
    robot.places = [BESIDE_M]
    num_before = len(robot.states)
    for _ in range(40):
        robot.beat()
    assert robot.drives()
    said = {v.value for m in robot.states[num_before:] for v in m.values if v.key == "state"}
    assert said <= {"driving"}


def test_a_localizer_that_fell_silent_for_another_stops_it_while_it_says_so(
    robot: PlacedRobot,
) -> None:
    robot.say(DiagnosticStatus.ERROR, "of another robot", who="/r2/grid_mapper")
    for _ in range(10):
        robot.beat()
    assert robot.drives()
    robot.say(DiagnosticStatus.ERROR, "also published by /amcl")
    robot.until(robot.is_in("stopped", "/grid_mapper: also published by /amcl"))
    assert not any(map(speed_of, robot.commands[-1:]))
    robot.say(DiagnosticStatus.OK, "no other source")
    robot.until(robot.drives)
