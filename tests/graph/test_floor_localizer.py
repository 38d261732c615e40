"""The floor localizer over DDS: drawn masks, then the whole chain in the simulated field."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from floor_scene import FRAME_NS, FloorRobot, goal_bearing, mask_from
from geometry_msgs.msg import PoseWithCovarianceStamped
from heard_poses import Heard, HeardTruth, is_near

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from floornav_common.ros.messages import (
    ns_to_stamp,
    pose_to_se2,
    stamp_to_ns,
)
from floornav_common.ros.qos import RELIABLE_QOS
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


def test_a_pose_is_settled_by_a_goal_kept_and_found_again(start: Any, peer: Any) -> None:
    """One node lives through all of it: every stage begins where the last one ends."""
    node = start(*NODE, "--ros-args", "-p", "publish_tf:=true")
    node.wait_for("ready", START_S)
    heard, robot = Heard(peer, "floor_pose"), FloorRobot(peer, node)
    mask, odometry = mask_from(HERE), ODOM @ HERE

    heard.see_until(
        robot, heard.says(WARN, "no transform", "transforms of /floor/mask"), mask, odometry
    )
    assert not heard.poses  # nobody has said where the camera is

    robot.stand()
    heard.see_until(robot, heard.says(WARN, "2 poses fit alike"), mask, odometry)
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
    heard.see_until(robot, heard.says(OK, "known"), mask, odometry, seen)
    assert is_near(heard.poses[-1], HERE, NEAR_M, NEAR_RAD)
    assert heard.poses[-1].header.frame_id == "map"
    assert stamp_to_ns(heard.poses[-1].header.stamp) % FRAME_NS == 0
    estimate = estimate_from_msg(heard.poses[-1])
    assert normalized_error(estimate.pose, HERE, estimate.cov) < FAR_OFF
    heard.see_until(
        robot, lambda: bool(heard.map_to_odom()), mask, odometry
    )  # it listens for a second first
    off = difference(heard.map_to_odom()[-1], ODOM.inverse())
    assert np.abs(off).max() < 5.0 * NEAR_M

    heard.see_until(robot, heard.says(ERROR, "lost"), np.zeros_like(mask), odometry)
    heard.see_until(
        robot, heard.says(OK, "known"), mask, odometry, seen
    )  # covered for long it is open

    carried = mask_from(THERE)
    seen = [goal_bearing(THERE, "goal_blue")]
    num = heard.see_until(
        robot, lambda: is_near(heard.poses[-1], THERE, NEAR_M, NEAR_RAD), carried, odometry, seen
    )
    later = stamp_to_ns(heard.poses[-1].header.stamp)
    began = robot.stamp_ns - (num - 1) * FRAME_NS
    assert later - began <= 1_000_000_000
    wrong = [m for m in heard.poses if stamp_to_ns(m.header.stamp) >= began]
    assert all(is_near(m, THERE, NEAR_M, NEAR_RAD) for m in wrong)

    other = np.zeros((50, 300), np.uint8)
    heard.see_until(robot, heard.says(ERROR, "give `camera_model` of the camera"), other, odometry)
    heard.see_until(robot, heard.says(ERROR, "refused", "input /floor/mask"), other, odometry)
    heard.see_until(robot, heard.says(OK, "known"), carried, odometry, seen)
    assert node.stop() == 0


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
    heard = HeardTruth(peer, "floor_pose")
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
    for msg, true in heard.wait_for(5, START_S):
        x, y, yaw = difference(pose_to_se2(msg.pose.pose), true)
        assert math.hypot(x, y) < 0.05 and abs(yaw) < math.radians(2.0)
