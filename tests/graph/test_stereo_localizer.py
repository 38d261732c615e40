"""The stereo localizer over DDS: a small room drawn from its map, then the whole chain."""

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
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from robot_messages import statuses
from stereo_scene import FRAME_NS, StereoRobot, small_room
from tf2_msgs.msg import TFMessage

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN
from floornav_common.ros.messages import pose_to_se2, stamp_to_ns, transform_from_msg
from floornav_common.ros.qos import RELIABLE_QOS, TF_QOS
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference
from multi_localizer.ros_conversions import estimate_from_msg
from multi_localizer.voxel_map import save_voxel_map

LISTENING = Path(__file__).with_name("listening.py")
NODE = (LISTENING, "multi_localizer.nodes.stereo_localizer_node")
START_S = 240.0  # kernels may have to be compiled first, on a busy machine
NEAR_M, NEAR_RAD = 0.03, 0.03
HERE, AHEAD = SE2(1.9, 1.4, 0.4), SE2(1.95, 1.42, 0.45)
ODOM = SE2(2.0, 1.0, 0.5)  # where odometry has the map's origin


class Heard:
    """What the node says."""

    def __init__(self, peer: Any) -> None:
        self.poses = peer.collect(PoseWithCovarianceStamped, "stereo_pose", RELIABLE_QOS)
        self.candidates = peer.collect(PoseArray, "stereo_pose/candidates", RELIABLE_QOS)
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        self.transforms: list[TFMessage] = peer.collect(TFMessage, "/tf", TF_QOS)
        peer.wait_to_hear("stereo_pose", "stereo_pose/candidates", "/diagnostics", "/tf")

    def says(self, level: bytes, words: str, part: str = "stereo pose") -> Callable[[], bool]:
        """Return whether the newest status of a part is so."""

        def is_so() -> bool:
            said = statuses(self.states, part)
            return bool(said) and said[-1].level == level and words in said[-1].message

        return is_so


def is_near(msg: PoseWithCovarianceStamped, pose: SE2) -> bool:
    x, y, yaw = np.abs(difference(pose_to_se2(msg.pose.pose), pose))
    return bool(max(x, y) < NEAR_M and yaw < NEAR_RAD)


def see_until(robot: StereoRobot, is_done: Callable[[], bool], *what: Any, **how: Any) -> None:
    """Show the same again and again."""
    for _ in range(600):
        robot.see(*what, **how)
        if robot.peer.spin_until(is_done, 0.2, must=False):
            return
    pytest.fail("not so after 600 moments")


def test_a_pose_is_found_followed_by_one_pair_and_given_up(
    start: Any, peer: Any, tmp_path: Path
) -> None:
    """One node lives through all of it: every stage begins where the last one ends."""
    path = save_voxel_map(tmp_path / "room.npz", small_room())
    node = start(*NODE, "--ros-args", "-p", f"map_file:={path}", "-p", "publish_tf:=true")
    node.wait_for("ready", START_S)
    heard, robot = Heard(peer), StereoRobot(peer, node)
    odometry = ODOM @ HERE

    untransformed = heard.says(WARN, "no transform", "transforms of /stereo/front/disparity")
    see_until(robot, untransformed, HERE, odometry, has_info=False)
    robot.stand()
    see_until(robot, heard.says(ERROR, "no camera_info"), HERE, odometry, has_info=False)
    assert not heard.poses

    see_until(robot, heard.says(OK, "known"), HERE, odometry)
    assert is_near(heard.poses[-1], HERE) and heard.candidates[-1].poses
    assert heard.poses[-1].header.frame_id == "map"
    assert stamp_to_ns(heard.poses[-1].header.stamp) % FRAME_NS == 0
    assert (np.diag(estimate_from_msg(heard.poses[-1]).cov) > 0.0).all()
    see_until(robot, lambda: bool(_sent(heard)), HERE, odometry)  # it listens for a second first
    off = difference(_sent(heard)[-1], ODOM.inverse())
    assert np.abs(off).max() < 5.0 * NEAR_M

    alone = heard.says(WARN, "by front alone: no disparities of rear")
    see_until(robot, alone, AHEAD, ODOM @ AHEAD, pairs=("front",))
    assert is_near(heard.poses[-1], AHEAD)

    robot.skew_ns = 7_000_000
    see_until(robot, heard.says(ERROR, "different stamps"), AHEAD, ODOM @ AHEAD)
    robot.skew_ns = 0
    see_until(robot, heard.says(OK, "known"), AHEAD, ODOM @ AHEAD)
    peer.spin_until(heard.says(STALE, "no disparities"), START_S)
    num = len(heard.poses)
    peer.spin(0.3)
    assert len(heard.poses) == num
    assert node.stop() == 0


def _sent(heard: Heard) -> list[SE2]:
    return [
        transform_from_msg(t.transform).to_se2()
        for m in heard.transforms
        for t in m.transforms
        if (t.header.frame_id, t.child_frame_id) == ("map", "odom")
    ]


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


def test_in_the_simulated_room_the_pose_comes_from_the_cameras_alone(
    start: Any, peer: Any, tmp_path: Path
) -> None:
    """sim_bridge, stereo_matcher, stereo_localizer, each its own process."""
    pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
    from experiments.stereo_world_map import map_of_world

    path = save_voxel_map(tmp_path / "room.npz", map_of_world("stereo_room", 0.02, 0.16))
    truth: dict[int, SE2] = {}
    keep = lambda m: truth.__setitem__(  # noqa: E731
        stamp_to_ns(m.header.stamp), pose_to_se2(m.pose.pose)
    )
    peer.node.create_subscription(Odometry, "ground_truth/odom", keep, RELIABLE_QOS)
    poses = peer.collect(PoseWithCovarianceStamped, "stereo_pose", RELIABLE_QOS)
    common = ("--ros-args", "-p", "use_sim_time:=true")
    nodes = [
        start(LISTENING, "multi_localizer.nodes.stereo_matcher_node", *common),
        start(*NODE, *common, "-p", f"map_file:={path}", "-p", "panorama_spacing_m:=0.16"),
    ]
    for node in nodes:
        node.wait_for("ready", START_S)
    world = ("-p", "world:=stereo_room", "-p", "real_time_factor:=0.3")
    start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *world)
    known = lambda: [m for m in poses if stamp_to_ns(m.header.stamp) in truth]  # noqa: E731
    peer.spin_until(lambda: len(known()) >= 5, START_S)
    for msg in known():
        x, y, yaw = difference(pose_to_se2(msg.pose.pose), truth[stamp_to_ns(msg.header.stamp)])
        assert math.hypot(x, y) < 0.08 and abs(yaw) < math.radians(2.0)
