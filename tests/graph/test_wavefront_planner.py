"""The planner of ways over DDS: a path for a goal, another for another map, none for a bad goal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from nav_msgs.msg import OccupancyGrid  # noqa: E402, I001
from nav_msgs.msg import Path as PathMsg
from robot_messages import LATCHED, statuses, tf_of, time_of  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

NODE = (Path(__file__).with_name("listening.py"), "sjmc_planner.nodes.wavefront_planner_node")


def map_of(wall: int = 0) -> OccupancyGrid:
    """Return a room of 6 x 4 m with a wall across it at 3 m, of so many cells of 0.1 m."""
    cells = np.zeros((40, 60), dtype=np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    cells[:wall, 30] = 100
    msg = OccupancyGrid()
    msg.header.frame_id = "map"
    msg.info.width, msg.info.height, msg.info.resolution = 60, 40, 0.1
    msg.info.origin.orientation.w = 1.0
    msg.data = cells.ravel().tolist()
    return msg


def goal_of(x: float, y: float, frame: str = "map") -> PoseStamped:
    msg = PoseStamped()
    msg.header.frame_id = frame
    msg.pose.position.x, msg.pose.position.y, msg.pose.orientation.w = x, y, 1.0
    return msg


class Graph(SimpleNamespace):
    """The node, what it is sent, and the paths it gave."""

    def beat(self) -> None:
        """Say where the robot is: 1 m into the room."""
        stamp_ns = self.peer.node.get_clock().now().nanoseconds
        self.tf.publish(tf_of("odom", "base_link", stamp_ns, 0.0))
        self.peer.spin(0.05)

    def until(self, is_so: Callable[[], bool]) -> None:
        for _ in range(1200):
            if is_so():
                return
            self.beat()
        pytest.fail(f"not so; paths: {len(self.paths)}\n{self.node.text}")

    def points(self) -> np.ndarray:
        """Return the newest path's places."""
        places = [(p.pose.position.x, p.pose.position.y) for p in self.paths[-1].poses]
        return np.array(places).reshape(-1, 2)

    def has_said(self, words: str, level: bytes) -> bool:
        said = statuses(self.diagnostics, "path")
        return bool(said) and words in said[-1].message and said[-1].level == level


@pytest.fixture
def graph(start, peer) -> Graph:
    """Return a running node that knows where its robot stands in `odom` on `map`."""
    node = start(*NODE, "--ros-args", "-p", "radius_m:=0.2")
    node.wait_for("ready", 120.0)
    made = Graph(
        node=node, peer=peer,
        paths=peer.collect(PathMsg, "path", LATCHED),
        diagnostics=peer.collect(DiagnosticArray, "/diagnostics", 10),
        statics=peer.publisher(TFMessage, "/tf_static", LATCHED, to=node),
        tf=peer.publisher(TFMessage, "/tf", 10, to=node),
        maps=peer.publisher(OccupancyGrid, "map", LATCHED, to=node),
        goals=peer.publisher(PoseStamped, "goal_pose", 5, to=node),
    )  # fmt: skip
    peer.wait_to_hear("path", "/diagnostics")
    node.wait_for("/path is sent to 1")
    placed = tf_of("map", "odom", 0, 1.0)
    placed.transforms[0].transform.translation.y = 1.0
    placed.transforms[0].header.stamp = time_of(0)
    made.statics.publish(placed)
    return made


def test_a_goal_gives_a_path_in_the_maps_frame(graph):
    graph.maps.publish(map_of())
    graph.goals.publish(goal_of(5.0, 1.0))
    graph.until(lambda: bool(graph.paths))
    assert graph.paths[-1].header.frame_id == "map"
    assert graph.points()[0] == pytest.approx((1.0, 1.0))
    assert graph.points()[-1] == pytest.approx((5.0, 1.0))
    assert graph.paths[-1].poses[3].pose.orientation.w == pytest.approx(1.0, abs=0.01)


def test_a_goal_of_another_frame_is_taken_to_the_map(graph):
    graph.maps.publish(map_of())
    graph.goals.publish(goal_of(3.0, 0.5, frame="odom"))
    graph.until(lambda: bool(graph.paths))
    assert graph.points()[-1] == pytest.approx((4.0, 1.5))


def test_a_goal_waits_for_a_map_and_says_so(graph):
    graph.goals.publish(goal_of(5.0, 1.0))
    graph.until(lambda: graph.has_said("no map on /map yet", b"\x03"))
    graph.maps.publish(map_of())
    graph.until(lambda: bool(graph.paths))


def test_a_map_that_closes_the_way_gives_another_path(graph):
    graph.maps.publish(map_of())
    graph.goals.publish(goal_of(5.0, 1.0))
    graph.until(lambda: bool(graph.paths))
    assert graph.points()[:, 1].max() < 1.2
    graph.maps.publish(map_of(wall=25))
    graph.until(lambda: len(graph.paths) > 1)
    assert graph.points()[:, 1].max() > 2.6


@pytest.mark.parametrize(
    ("place", "words"),
    [((50.0, 1.0), "is outside of the map"), ((3.05, 1.0), "is inside an obstacle")],
)
def test_a_goal_that_cannot_be_is_named_and_the_old_path_is_canceled(graph, place, words):
    graph.maps.publish(map_of(wall=25))
    graph.goals.publish(goal_of(5.0, 1.0))
    graph.until(lambda: bool(graph.paths) and len(graph.points()) > 1)
    graph.goals.publish(goal_of(*place))
    graph.until(lambda: len(graph.points()) == 0)
    graph.until(lambda: graph.has_said(words, b"\x02"))


def test_a_goal_fixed_to_the_robot_is_refused(graph):
    graph.maps.publish(map_of())
    graph.goals.publish(goal_of(1.0, 0.0, frame="base_link"))
    graph.until(lambda: graph.has_said("goal: 'base_link' is fixed to the robot", b"\x02"))
    assert not graph.paths


def test_a_goal_that_it_cannot_place_yet_takes_the_last_path_back_though_its_end_is_reached(graph):
    graph.maps.publish(map_of())
    graph.goals.publish(goal_of(1.0, 1.0))
    graph.until(lambda: graph.has_said("idle: no goal", b"\x00") and bool(graph.paths))
    assert len(graph.points()) > 0
    graph.goals.publish(goal_of(1.0, 0.0, frame="nowhere"))
    graph.until(lambda: len(graph.points()) == 0)
    num = len(graph.paths)
    for _ in range(20):
        graph.beat()
    assert len(graph.paths) == num  # once


def test_a_way_is_said_in_the_log_once_a_goal(graph):
    graph.maps.publish(map_of())
    for _ in range(3):
        graph.goals.publish(goal_of(5.0, 1.0))
        graph.beat()
    graph.until(lambda: "way of 4.0 m to map (5.000, 1.000) found" in graph.node.text)
    graph.goals.publish(goal_of(4.0, 1.0))
    graph.until(lambda: "way of 3.0 m to map (4.000, 1.000) found" in graph.node.text)
    assert graph.node.text.count(" found") == 2


def test_without_a_pose_it_says_what_is_missing(start, peer):
    node = start(*NODE)
    node.wait_for("ready", 120.0)
    diagnostics = peer.collect(DiagnosticArray, "/diagnostics", 10)
    peer.publisher(OccupancyGrid, "map", LATCHED, to=node).publish(map_of())
    peer.publisher(PoseStamped, "goal_pose", 5, to=node).publish(goal_of(5.0, 1.0))

    def is_said() -> bool:
        said = statuses(diagnostics, "path")
        return bool(said) and "waiting: " in said[-1].message and "'map'" in said[-1].message

    peer.spin_until(is_said)
