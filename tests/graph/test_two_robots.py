"""Two robots in one world, each with its own mapper and planner, told apart in both usual ways."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from test_local_planner import goal_of
from tf2_msgs.msg import TFMessage

from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS

LISTENING = Path(__file__).with_name("listening.py")
DRIVING = (
    "goal_source:=goal_pose", "method:=vfh_plus", "robot.drive:=differential",
    "robot.radius_m:=0.45", "robot.speed_m_s:=0.6",
)  # fmt: skip
NODES = ("grid_mapper.nodes.grid_mapper_node", "sjmc_planner.nodes.local_planner_node")
ROBOTS = ("r1", "r2")
PLACES = {"r1": (-1.5, 0.0), "r2": (1.5, 0.6)}
WORLD = """\
name: two
walls:
  - {from_m: [-4, -2.5], to_m: [4, -2.5]}
  - {from_m: [4, -2.5], to_m: [4, 3]}
  - {from_m: [4, 3], to_m: [-4, 3]}
  - {from_m: [-4, 3], to_m: [-4, -2.5]}
robots:
  - {name: r1, model: segway_rmp50, position_m: [-1.5, 0.0]}
  - {name: r2, model: segway_rmp50, position_m: [1.5, 0.6]}
"""
# How a robot's nodes are told which one they are; its map's frame; its topic of transforms.
WAYS = {
    "topic": (("-r", "/tf:=tf", "-r", "/tf_static:=tf_static"), "map", "/{}/tf"),
    "prefix": (("-p", "frame_prefix:={}/"), "{}/map", "/tf"),
}


@pytest.fixture
def graph(start: Callable[..., Any], tmp_path: Path) -> Callable[[str], dict[str, Any]]:
    """Return a function that starts both robots' nodes and the world in one of the ways."""

    def begin(scheme: str) -> dict[str, Any]:
        nodes = {}
        for robot in ROBOTS:
            own = [word.format(robot) for word in WAYS[scheme][0]]
            common = ["-r", f"__ns:=/{robot}", "-p", "use_sim_time:=true", *own]
            for module in NODES:
                words = [w for p in DRIVING for w in ("-p", p)] if "planner" in module else []
                nodes[robot, module] = start(LISTENING, module, "--ros-args", *common, *words)
        for node in nodes.values():
            node.wait_for("ready", 240.0)
        (tmp_path / "two.yaml").write_text(WORLD)
        given = (f"world:={tmp_path / 'two.yaml'}", f"tf_scheme:={scheme}", "real_time_factor:=0.5")
        words = [word for p in given for word in ("-p", p)]
        start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *words).wait_for("ready")
        return nodes

    return begin


def place_of(msg: Any) -> tuple[float, float]:
    return msg.pose.pose.position.x, msg.pose.pose.position.y


@pytest.mark.parametrize("scheme", list(WAYS))
def test_each_robot_maps_and_drives_by_itself(graph, peer, scheme: str) -> None:
    _, map_frame, tf_topic = WAYS[scheme]
    collect = lambda kind, topic, qos: {r: peer.collect(kind, f"/{r}/{topic}", qos) for r in ROBOTS}  # noqa: E731
    truth = collect(Odometry, "ground_truth/odom", RELIABLE_QOS)
    poses = collect(PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
    maps = collect(OccupancyGrid, "map", LATCHED_QOS)
    states = peer.collect(DiagnosticStatus, "/r2/planner/state", RELIABLE_QOS)
    frames = {r: peer.collect(TFMessage, tf_topic.format(r), RELIABLE_QOS) for r in ROBOTS}
    nodes = graph(scheme)
    goals = peer.publisher(PoseStamped, "/r2/goal_pose", 5, to=nodes["r2", NODES[1]])
    peer.spin_until(lambda: all(poses.values()) and all(maps.values()))
    goals.publish(goal_of(1.2, 0.2, map_frame.format("r2")))  # r2 begins at its map's origin
    state = lambda: {v.key: v.value for v in states[-1].values}["state"] if states else ""  # noqa: E731
    peer.spin_until(lambda: state() == "reached", 240.0)
    (x1, y1), (x2, y2) = (place_of(truth[r][-1]) for r in ROBOTS)
    assert math.hypot(x1 - PLACES["r1"][0], y1 - PLACES["r1"][1]) < 0.02
    assert math.hypot(x2 - PLACES["r2"][0] - 1.2, y2 - PLACES["r2"][1] - 0.2) < 0.25
    for robot in ROBOTS:
        own = [t for m in frames[robot] for t in m.transforms]
        assert maps[robot][-1].header.frame_id == map_frame.format(robot)
        assert map_frame.format(robot) in {t.header.frame_id for t in own}
    assert math.hypot(*place_of(poses["r1"][-1])) < 0.05
    assert math.dist(place_of(poses["r2"][-1]), (1.2, 0.2)) < 0.25
