"""The floor localizer over DDS: drawn masks, then the whole chain in the simulated field."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from diagnostic_msgs.msg import DiagnosticArray
from floor_scene import FRAME_NS, FloorRobot, goal_bearing, mask_from
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from robot_messages import statuses
from tf2_msgs.msg import TFMessage

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from floornav_common.ros.messages import (
    ns_to_stamp,
    pose_to_se2,
    stamp_to_ns,
    transform_from_msg,
)
from floornav_common.ros.qos import RELIABLE_QOS, TF_QOS
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference, normalized_error
from multi_localizer.ros_conversions import estimate_from_msg, estimate_to_msg

LISTENING = Path(__file__).with_name("listening.py")
NODE = (LISTENING, "multi_localizer.nodes.floor_localizer_node")
START_S = 240.0  # kernels may have to be compiled first, on a busy machine
NEAR_M, NEAR_RAD = 0.01, 0.01
FAR_OFF = 40.0  # chi-squared of 3 degrees: once in 10^8
HERE, THERE = SE2(-0.6, 0.2, 0.4), SE2(0.7, -0.3, -2.0)
ODOM = SE2(2.0, 1.0, 0.5)  # where odometry has the map's origin


class Heard:
    """What the node says."""

    def __init__(self, peer: Any) -> None:
        self.poses = peer.collect(PoseWithCovarianceStamped, "floor_pose", RELIABLE_QOS)
        self.candidates = peer.collect(PoseArray, "floor_pose/candidates", RELIABLE_QOS)
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        self.transforms: list[TFMessage] = peer.collect(TFMessage, "/tf", TF_QOS)
        peer.wait_to_hear("floor_pose", "floor_pose/candidates", "/diagnostics", "/tf")

    def says(self, level: bytes, words: str, part: str = "floor pose") -> Callable[[], bool]:
        """Return whether the newest status of a part is so."""

        def is_so() -> bool:
            said = statuses(self.states, part)
            return bool(said) and said[-1].level == level and words in said[-1].message

        return is_so


def is_near(msg: PoseWithCovarianceStamped, pose: SE2) -> bool:
    x, y, yaw = np.abs(difference(pose_to_se2(msg.pose.pose), pose))
    return bool(max(x, y) < NEAR_M and yaw < NEAR_RAD)


def see_until(robot: FloorRobot, is_done: Callable[[], bool], *what: Any) -> int:
    """Show the same again and again; return how often."""
    for num in range(1, 400):
        robot.see(*what)
        if robot.peer.spin_until(is_done, 0.15, must=False):
            return num
    pytest.fail("not so after 400 masks")


def test_a_pose_is_settled_by_a_goal_kept_and_found_again(start: Any, peer: Any) -> None:
    """One node lives through all of it: every stage begins where the last one ends."""
    node = start(*NODE, "--ros-args", "-p", "publish_tf:=true")
    node.wait_for("ready", START_S)
    heard, robot = Heard(peer), FloorRobot(peer, node)
    mask, odometry = mask_from(HERE), ODOM @ HERE

    see_until(robot, heard.says(WARN, "no transform", "transforms of /floor/mask"), mask, odometry)
    assert not heard.poses  # nobody has said where the camera is

    robot.stand()
    see_until(robot, heard.says(WARN, "2 poses fit alike"), mask, odometry)
    assert not heard.poses and len(heard.candidates[-1].poses) == 2
    fits = [pose_to_se2(p) for p in heard.candidates[-1].poses]
    assert min(np.abs(difference(fit, HERE)).max() for fit in fits) < NEAR_M

    told = peer.publisher(PoseWithCovarianceStamped, "initialpose", RELIABLE_QOS, to=node)
    far = PoseEstimate(SE2(50.0, 0.0, 0.0), np.diag([0.5, 0.5, 0.3]) ** 2)
    told.publish(estimate_to_msg(far, ns_to_stamp(robot.stamp_ns), "map"))
    node.wait_for("initialpose refused: none of the 2 poses that fit")

    void = [math.nan, math.inf]
    robot.see(mask, odometry, void)
    robot.see(mask, odometry, [])
    seen = [goal_bearing(HERE, "goal_blue")]
    see_until(robot, heard.says(OK, "known"), mask, odometry, seen)
    assert is_near(heard.poses[-1], HERE)
    assert heard.poses[-1].header.frame_id == "map"
    assert stamp_to_ns(heard.poses[-1].header.stamp) % FRAME_NS == 0
    estimate = estimate_from_msg(heard.poses[-1])
    assert normalized_error(estimate.pose, HERE, estimate.cov) < FAR_OFF
    see_until(robot, lambda: bool(_sent(heard)), mask, odometry)  # it listens for a second first
    off = difference(_sent(heard)[-1], ODOM.inverse())
    assert np.abs(off).max() < 5.0 * NEAR_M

    see_until(robot, heard.says(ERROR, "lost"), np.zeros_like(mask), odometry)
    see_until(robot, heard.says(OK, "known"), mask, odometry, seen)  # covered for long it is open

    carried = mask_from(THERE)
    seen = [goal_bearing(THERE, "goal_blue")]
    num = see_until(robot, lambda: is_near(heard.poses[-1], THERE), carried, odometry, seen)
    later = stamp_to_ns(heard.poses[-1].header.stamp)
    began = robot.stamp_ns - (num - 1) * FRAME_NS
    assert later - began <= 1_000_000_000
    wrong = [m for m in heard.poses if stamp_to_ns(m.header.stamp) >= began]
    assert all(is_near(m, THERE) for m in wrong)

    other = np.zeros((50, 300), np.uint8)
    see_until(robot, heard.says(ERROR, "give `camera_model` of the camera"), other, odometry)
    see_until(robot, heard.says(ERROR, "refused", "input /floor/mask"), other, odometry)
    see_until(robot, heard.says(OK, "known"), carried, odometry, seen)
    assert node.stop() == 0


def _sent(heard: Heard) -> list[SE2]:
    return [
        transform_from_msg(t.transform).to_se2()
        for m in heard.transforms
        for t in m.transforms
        if (t.header.frame_id, t.child_frame_id) == ("map", "odom")
    ]


@pytest.mark.parametrize(
    ("parameter", "words"),
    [
        ("plan:=moon", "'moon' in plans"), ("camera_model:=nobody", "camera_models"),
        ("use_odom:=false -p publish_tf:=true", "publish_tf needs use_odom"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line_and_exit_code_2(start: Any, parameter: str, words: str) -> None:
    process = start(*NODE, "--ros-args", "-p", *parameter.split())
    assert process.wait_for_exit(START_S) == 2
    assert words in process.text and "Traceback" not in process.text


def test_in_the_simulated_field_the_pose_comes_from_the_camera_alone(start: Any, peer: Any) -> None:
    """sim_bridge, floor_detector, marker_detector, floor_localizer, each its own process."""
    pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
    truth: dict[int, SE2] = {}
    keep = lambda m: truth.__setitem__(  # noqa: E731
        stamp_to_ns(m.header.stamp), pose_to_se2(m.pose.pose)
    )
    peer.node.create_subscription(Odometry, "ground_truth/odom", keep, RELIABLE_QOS)
    poses = peer.collect(PoseWithCovarianceStamped, "floor_pose", RELIABLE_QOS)
    nodes = [
        start(LISTENING, f"{module}_node", "--ros-args", "-p", "use_sim_time:=true")
        for module in (
            "floor_perception.nodes.floor_detector", "floor_perception.nodes.marker_detector",
            "multi_localizer.nodes.floor_localizer",
        )
    ]  # fmt: skip
    for node in nodes:
        node.wait_for("ready", START_S)
    world = ("-p", "world:=small_size_field", "-p", "real_time_factor:=0.5")
    start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *world)
    known = lambda: [m for m in poses if stamp_to_ns(m.header.stamp) in truth]  # noqa: E731
    peer.spin_until(lambda: len(known()) >= 5, START_S)
    for msg in known():
        x, y, yaw = difference(pose_to_se2(msg.pose.pose), truth[stamp_to_ns(msg.header.stamp)])
        assert math.hypot(x, y) < 0.05 and abs(yaw) < math.radians(2.0)
