"""The stereo localizer over DDS: a small room drawn from its map, then the whole chain."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from geometry_msgs.msg import PoseWithCovarianceStamped
from heard_poses import Heard, HeardTruth, is_near
from stereo_scene import FRAME_NS, StereoRobot, small_room

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN
from floornav_common.ros.messages import ns_to_stamp, pose_to_se2, stamp_to_ns
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference
from multi_localizer.ros_conversions import estimate_from_msg, estimate_to_msg
from multi_localizer.voxel_map import save_voxel_map

LISTENING = Path(__file__).with_name("listening.py")
NODE = (LISTENING, "multi_localizer.nodes.stereo_localizer_node")
START_S = 240.0  # kernels may have to be compiled first, on a busy machine
NEAR_M, NEAR_RAD = 0.03, 0.03
HERE, AHEAD = SE2(1.9, 1.4, 0.4), SE2(1.95, 1.42, 0.45)
ODOM = SE2(2.0, 1.0, 0.5)  # where odometry has the map's origin


def test_a_pose_is_found_followed_by_one_pair_and_given_up(
    start: Any, peer: Any, tmp_path: Path
) -> None:
    """One node lives through all of it: every stage begins where the last one ends."""
    path = save_voxel_map(tmp_path / "room.npz", small_room())
    node = start(*NODE, "--ros-args", "-p", f"map_file:={path}", "-p", "publish_tf:=true")
    node.wait_for("ready", START_S)
    heard, robot = Heard(peer, "stereo_pose", wait_s=0.2, most=601), StereoRobot(peer, node)
    odometry = ODOM @ HERE

    untransformed = heard.says(WARN, "no transform", "transforms of /stereo/front/disparity")
    heard.see_until(robot, untransformed, HERE, odometry, has_info=False)
    robot.stand()
    heard.see_until(robot, heard.says(ERROR, "no camera_info"), HERE, odometry, has_info=False)
    assert not heard.poses

    heard.see_until(robot, heard.says(OK, "known"), HERE, odometry)
    heard.see_until(robot, lambda: bool(heard.poses and heard.candidates), HERE, odometry)
    assert is_near(heard.poses[-1], HERE, NEAR_M, NEAR_RAD) and heard.candidates[-1].poses
    assert heard.poses[-1].header.frame_id == "map"
    assert stamp_to_ns(heard.poses[-1].header.stamp) % FRAME_NS == 0
    assert (np.diag(estimate_from_msg(heard.poses[-1]).cov) > 0.0).all()
    heard.see_until(
        robot, lambda: bool(heard.map_to_odom()), HERE, odometry
    )  # it listens for a second first
    off = difference(heard.map_to_odom()[-1], ODOM.inverse())
    assert np.abs(off).max() < 5.0 * NEAR_M

    covered = heard.says(WARN, "goes on by odometry alone")
    robot.is_covered = True
    heard.see_until(robot, covered, HERE, odometry)
    num = len(heard.poses)
    heard.see_until(robot, heard.says(ERROR, "lost"), HERE, odometry)
    assert len(heard.poses) == num
    robot.is_covered = False
    heard.see_until(robot, heard.says(OK, "known"), HERE, odometry)

    alone = heard.says(WARN, "by front alone: no disparities of rear")
    heard.see_until(robot, alone, AHEAD, ODOM @ AHEAD, pairs=("front",))
    assert is_near(heard.poses[-1], AHEAD, NEAR_M, NEAR_RAD)

    robot.skew_ns = 7_000_000
    heard.see_until(robot, heard.says(ERROR, "different stamps"), AHEAD, ODOM @ AHEAD)
    robot.skew_ns = 0
    heard.see_until(robot, heard.says(OK, "known"), AHEAD, ODOM @ AHEAD)
    peer.spin_until(heard.says(STALE, "no disparities"), START_S)
    num = len(heard.poses)
    peer.spin(0.3)
    assert len(heard.poses) == num
    assert node.stop() == 0


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ((), "make_voxel_map makes one"),
        (("map_file:=/nowhere/map.npz",), "no voxel map /nowhere/map.npz"),
        (("map_file:=x", "use_odom:=false", "publish_tf:=true"), "publish_tf needs use_odom"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    start: Any, parameters: tuple[str, ...], words: str
) -> None:
    args = [word for p in parameters for word in ("-p", p)]
    process = start(*NODE, "--ros-args", *args)
    assert process.wait_for_exit(START_S) == 2
    assert words in process.text and "Traceback" not in process.text


def test_a_map_in_another_frame_is_one_line_and_exit_code_2(start: Any, tmp_path: Path) -> None:
    path = save_voxel_map(tmp_path / "room.npz", replace(small_room(), frame="lab"))
    process = start(*NODE, "--ros-args", "-p", f"map_file:={path}")
    assert process.wait_for_exit(START_S) == 2
    assert "frame 'lab'" in process.text and "map_frame:=lab" in process.text
    assert "Traceback" not in process.text


def test_a_pose_that_is_told_where_nothing_fits_is_refused(
    start: Any, peer: Any, tmp_path: Path
) -> None:
    path = save_voxel_map(tmp_path / "room.npz", replace(small_room(), frame="lab"))
    use = (f"map_file:={path}", "map_frame:=lab", "publish_tf:=true")
    node = start(*NODE, "--ros-args", *(word for p in use for word in ("-p", p)))
    node.wait_for("ready", START_S)
    heard, robot = Heard(peer, "stereo_pose", wait_s=0.2, most=601), StereoRobot(peer, node)
    robot.stand()
    publisher = peer.node.create_publisher(PoseWithCovarianceStamped, "initialpose", RELIABLE_QOS)
    heard.see_until(robot, heard.says(OK, "known"), HERE, ODOM)
    assert heard.poses[-1].header.frame_id == "lab"
    away = PoseEstimate(SE2(HERE.x, HERE.y, HERE.yaw + 2.0), np.diag([0.01, 0.01, 0.01]))
    publisher.publish(estimate_to_msg(away, ns_to_stamp(FRAME_NS), "lab"))
    heard.see_until(robot, lambda: "initialpose refused: nothing" in node.text, HERE, ODOM)
    assert node.stop() == 0


def test_in_the_simulated_room_the_pose_comes_from_the_cameras_alone(
    start: Any, peer: Any, tmp_path: Path
) -> None:
    """sim_bridge, stereo_matcher, stereo_localizer, each its own process."""
    pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
    from experiments.stereo_world_map import map_of_world

    path = save_voxel_map(tmp_path / "room.npz", map_of_world("stereo_room", 0.02, 0.16))
    heard = HeardTruth(peer, "stereo_pose")
    common = ("--ros-args", "-p", "use_sim_time:=true")
    nodes = [
        start(LISTENING, "multi_localizer.nodes.stereo_matcher_node", *common),
        start(*NODE, *common, "-p", f"map_file:={path}", "-p", "panorama_spacing_m:=0.16"),
    ]
    for node in nodes:
        node.wait_for("ready", START_S)
    world = ("-p", "world:=stereo_room", "-p", "real_time_factor:=0.3")
    start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *world)
    for msg, true in heard.wait_for(5, START_S):
        x, y, yaw = difference(pose_to_se2(msg.pose.pose), true)
        assert math.hypot(x, y) < 0.08 and abs(yaw) < math.radians(2.0)
