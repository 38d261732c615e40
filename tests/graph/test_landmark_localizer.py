"""The landmark localizer over DDS: bearings by hand, then what a camera sees in the simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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
from tf2_msgs.msg import TFMessage

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from floornav_common.ros.messages import (
    ns_to_stamp,
    pose_to_se2,
    poses_to_msg,
    se2_to_pose,
    stamp_to_ns,
    transform_from_msg,
)
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.ros.transforms import StaticTransformBroadcaster, TransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from multi_localizer.landmarks import load_landmarks
from multi_localizer.pose_estimate import difference, normalized_error
from multi_localizer.ros_conversions import estimate_from_msg

LISTENING = Path(__file__).with_name("listening.py")
NODE = (LISTENING, "multi_localizer.nodes.landmark_localizer_node")
START_S = 240.0
NEAR_M = 0.001
FAR_OFF = 40.0  # chi-squared of 3 degrees: once in 10^8
FIELD = load_landmarks("middle_size_field")
T_BASE_FLOOR = SE2(0.1, 0.0, 0.0)
FRAME = "omni_camera_floor"
HERE = SE2(1.0, -0.7, 0.6)
ODOM = SE2(5.0, -3.0, 1.0)


def bearings_from(base: SE2) -> dict[str, float]:
    sensor = base @ T_BASE_FLOOR
    place = np.array([sensor.x, sensor.y])
    found = {}
    for kind, (mark,) in FIELD.items():
        x, y = mark.point_seen(place) - place
        found[kind] = math.atan2(y, x) - sensor.yaw
    return found


class LandmarkRobot:
    """Sends bearings of all classes, one moment after the other."""

    def __init__(self, peer: Any, node: Any, has_odometry: bool = False) -> None:
        self.peer, self.stamp_ns = peer, 5_000_000_000
        self.frames = dict.fromkeys(FIELD, FRAME)
        self.odometry = peer.publisher(Odometry, "odom", RELIABLE_QOS) if has_odometry else None
        self.topics = {
            kind: peer.publisher(PoseArray, f"bearings/{kind}", RELIABLE_QOS, to=node)
            for kind in FIELD
        }
        self.poses = peer.collect(PoseWithCovarianceStamped, "landmark_pose", RELIABLE_QOS)
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        peer.wait_to_hear("landmark_pose", "/diagnostics")
        self._statics = StaticTransformBroadcaster(peer.node)

    def stand(self) -> None:
        """Say where the camera is."""
        self._statics.send("base_link", FRAME, 0, Transform3.from_se2(T_BASE_FLOOR))

    def stand_beside(self, kind: str, frame: str, T_base_sensor: SE2) -> None:
        """Let one class be seen in another frame."""
        self.frames[kind] = frame
        self._statics.send("base_link", frame, 0, Transform3.from_se2(T_base_sensor))

    def drive(self, T_odom_base: SE2) -> None:
        """Say where odometry has the robot, up to what will be seen next."""
        odom = Odometry(child_frame_id="base_link")
        odom.header.frame_id = "odom"
        odom.header.stamp = ns_to_stamp(self.stamp_ns + 150_000_000)
        odom.pose.pose = se2_to_pose(T_odom_base)
        assert self.odometry is not None
        self.odometry.publish(odom)

    def see(self, bearings: Mapping[str, Any]) -> None:
        """Send a moment: an empty array of each class that is not seen."""
        if self.odometry is not None:
            self.drive(ODOM)
        self.stamp_ns += 100_000_000
        for kind, publisher in self.topics.items():
            values = np.atleast_1d(bearings[kind]) if kind in bearings else np.zeros(0)
            seen = [SE2(0.0, 0.0, 0.0)] * len(values)
            msg = poses_to_msg(seen, ns_to_stamp(self.stamp_ns), self.frames[kind])
            for pose, half in zip(msg.poses, (values / 2.0).tolist(), strict=True):
                void = not math.isfinite(half)
                pose.orientation.z = half if void else math.sin(half)
                pose.orientation.w = half if void else math.cos(half)
            publisher.publish(msg)

    def see_until(self, bearings: Mapping[str, Any], is_done: Callable[[], bool]) -> None:
        for _ in range(400):
            self.see(bearings)
            if self.peer.spin_until(is_done, 0.15, must=False):
                return
        said = [(s.level, s.message) for a in self.states[-5:] for s in a.status]
        pytest.fail(f"not so after 400 moments; last said: {said}")

    def says(self, level: bytes, words: str, part: str = "landmark pose") -> Callable[[], bool]:
        def is_so() -> bool:
            said = statuses(self.states, part)
            return bool(said) and said[-1].level == level and words in said[-1].message

        return is_so


def test_bearings_become_a_pose_or_a_reason_why_not(start: Any, peer: Any) -> None:
    """One node lives through all of it."""
    node = start(*NODE)
    node.wait_for("ready", START_S)
    robot = LandmarkRobot(peer, node)
    seen = bearings_from(HERE)
    waiting = "transforms of /bearings/goal_blue_left"
    robot.see_until(seen, robot.says(WARN, "no transform", waiting))
    assert not robot.poses  # nobody has said where the camera is

    robot.stand()
    robot.see_until(seen, lambda: bool(robot.poses) and robot.says(OK, "known")())
    msg = robot.poses[-1]
    estimate = estimate_from_msg(msg)
    assert np.abs(difference(estimate.pose, HERE)).max() < NEAR_M
    assert msg.header.frame_id == "map" and stamp_to_ns(msg.header.stamp) % 100_000_000 == 0
    assert 0.001 < math.sqrt(estimate.cov[0, 0]) < 0.1

    turned = SE2(T_BASE_FLOOR.x, T_BASE_FLOOR.y, 1.0)
    robot.stand_beside("goal_blue_left", "turned_camera", turned)
    moved = {**seen, "goal_blue_left": seen["goal_blue_left"] - 1.0}
    robot.poses.clear()
    robot.see_until(moved, lambda: len(robot.poses) > 3 and robot.says(OK, "known")())
    assert np.abs(difference(pose_to_se2(robot.poses[-1].pose.pose), HERE)).max() < NEAR_M
    robot.stand_beside("goal_blue_left", "other_camera", SE2(0.5, 0.0, 0.0))
    robot.see_until(seen, robot.says(ERROR, "goal_blue_left are seen from 0.40 m beside"))
    robot.frames["goal_blue_left"] = FRAME

    two = {kind: seen[kind] for kind in ("goal_blue_left", "goal_yellow_left")}
    bad = [
        ({}, "no landmark is seen"), (two, "two landmarks leave a circle open"),
        (dict.fromkeys(seen, math.nan), "no landmark is seen"),
        ({kind: 0.3 * k for k, kind in enumerate(sorted(seen))}, "no pose is sent"),
    ]  # fmt: skip
    for bearings, words in bad:
        robot.see_until(bearings, robot.says(ERROR, words))
        num = len(robot.poses)
        robot.see_until(bearings, robot.says(ERROR, words))
        assert len(robot.poses) == num

    three = {**seen, "goal_blue_left": math.nan}
    robot.see_until(three, robot.says(ERROR, "1 more to confirm them"))
    one_void = {**seen, "goal_blue_left": (seen["goal_blue_left"], math.nan)}
    robot.see_until(one_void, robot.says(WARN, "1 bearings are not numbers"))
    assert np.abs(difference(pose_to_se2(robot.poses[-1].pose.pose), HERE)).max() < NEAR_M

    robot.stamp_ns = 1_000_000_000  # set back, and no /clock that says so
    again = lambda: stamp_to_ns(robot.poses[-1].header.stamp) < 4_000_000_000  # noqa: E731
    robot.see_until(seen, lambda: again() and robot.says(OK, "known")())
    assert node.stop() == 0


def test_map_to_odom_is_sent_while_the_pose_is_known_and_nobody_else_does(
    start: Any, peer: Any
) -> None:
    node = start(*NODE, "--ros-args", "-p", "publish_tf:=true")
    node.wait_for("ready", START_S)
    robot, seen = LandmarkRobot(peer, node, has_odometry=True), bearings_from(HERE)
    heard: list[TFMessage] = peer.collect(TFMessage, "/tf", 100)
    robot.stand()

    def sent() -> list[SE2]:
        return [
            transform_from_msg(each.transform).to_se2()
            for msg in heard
            for each in msg.transforms
            if (each.header.frame_id, each.child_frame_id) == ("map", "odom")
        ]

    robot.see_until(seen, lambda: len(sent()) >= 3)
    assert np.abs(difference(sent()[-1], HERE @ ODOM.inverse())).max() < 0.01

    robot.see_until({}, robot.says(ERROR, "no landmark is seen"))
    peer.spin(0.5)
    heard.clear()
    robot.see_until({}, robot.says(ERROR, "no landmark is seen"))
    peer.spin(0.5)
    assert not sent()

    other, foreign = TransformBroadcaster(peer.node), Transform3.from_se2(SE2(9.0, 9.0, 0.0))
    robot.see_until(seen, lambda: len(sent()) >= 3)
    other.send("map", "odom", robot.stamp_ns, foreign)
    contested = robot.says(ERROR, "also published by", "transform map to odom")
    robot.see_until(seen, contested)
    heard.clear()
    robot.poses.clear()
    robot.see_until(seen, lambda: len(robot.poses) >= 5)
    assert contested() and not sent()  # its pose goes on, the transform is the other's
    assert node.stop() == 0


def test_method_floor_without_masks_says_at_once_what_it_waits_for(start: Any, peer: Any) -> None:
    node = start(*NODE, "--ros-args", "-p", "method:=floor")
    node.wait_for("ready", START_S)
    node.wait_for("floor/mask: never arrived; published by nobody")
    robot, seen = LandmarkRobot(peer, node), bearings_from(HERE)
    robot.stand()
    alone = robot.says(WARN, "by bearings alone; no distances without floor/mask: never arrived")
    robot.see_until(seen, lambda: bool(robot.poses) and alone())
    two = {kind: seen[kind] for kind in ("goal_blue_left", "goal_yellow_left")}
    robot.see_until(two, robot.says(ERROR, "no distances without floor/mask"))
    assert node.stop() == 0


def test_a_pose_is_given_once_as_many_views_as_asked_for_have_shown_it(
    start: Any, peer: Any
) -> None:
    node = start(*NODE, "--ros-args", "-p", "track.settle_views:=4")
    node.wait_for("ready", START_S)
    robot, seen = LandmarkRobot(peer, node), bearings_from(HERE)
    robot.stand()
    robot.see_until(seen, lambda: bool(robot.poses))
    first = stamp_to_ns(robot.poses[0].header.stamp)
    assert first >= 5_000_000_000 + 4 * 100_000_000  # the fourth view's at the earliest
    assert node.stop() == 0


def test_files_that_are_none_are_one_line_and_exit_code_2(start: Any, tmp_path: Path) -> None:
    path = tmp_path / "twice.yaml"
    path.write_text("pole: {positions_m: [[1, 2], [1, 2]]}\n")
    process = start(*NODE, "--ros-args", "-p", f"landmarks:={path}")
    assert process.wait_for_exit(START_S) == 2
    assert "two landmarks at one place" in process.text and "Traceback" not in process.text


def test_in_the_simulated_field_a_robot_knows_its_pose_by_the_goals(start: Any, peer: Any) -> None:
    """sim_bridge, floor_detector, marker_detector and landmark_localizer of robot r1, method 2."""
    pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
    truth: dict[int, SE2] = {}
    keep = lambda m: truth.__setitem__(  # noqa: E731
        stamp_to_ns(m.header.stamp), pose_to_se2(m.pose.pose)
    )
    peer.node.create_subscription(Odometry, "/r1/ground_truth/odom", keep, RELIABLE_QOS)
    poses = peer.collect(PoseWithCovarianceStamped, "/r1/landmark_pose", RELIABLE_QOS)
    own = ("-r", "__ns:=/r1", "-p", "frame_prefix:=r1/", "-p", "use_sim_time:=true")
    camera = ("-p", "camera_model:=soccer_middle_size")
    parameters = Path(__file__).parents[2] / "ros_ws/src/floor_perception/parameters"
    mask = ("--params-file", str(parameters / "middle_size.yaml"))
    nodes = [
        start(
            LISTENING, "floor_perception.nodes.marker_detector_node", "--ros-args", *own, *camera
        ),
        start(LISTENING, "floor_perception.nodes.floor_detector_node", "--ros-args", *own, *mask),
        start(*NODE, "--ros-args", *own, *camera, "-p", "method:=floor"),
    ]
    for node in nodes:
        node.wait_for("ready", START_S)
    world = ("-p", "world:=middle_size_field", "-p", "real_time_factor:=0.5")
    start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *world)
    known = lambda: [m for m in poses if stamp_to_ns(m.header.stamp) in truth]  # noqa: E731
    peer.spin_until(lambda: len(known()) >= 3, START_S)
    for msg in known():
        estimate, true = estimate_from_msg(msg), truth[stamp_to_ns(msg.header.stamp)]
        assert msg.header.frame_id == "r1/map"
        assert np.abs(difference(estimate.pose, true)).max() < 0.3
        assert normalized_error(estimate.pose, true, estimate.cov) < FAR_OFF
