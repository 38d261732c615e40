"""The mapping node over DDS: what it sends, what it refuses, and what it keeps through trouble."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "grid_mapper"))

from worlds import drive_around, scan_at, square_room

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.map_files import load_map

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402

NODE = (Path(__file__).with_name("listening.py"), "grid_mapper.nodes.grid_mapper_node")
LASER = SE2(0.1, 0.0, 0.2)
T0_NS = 1_000_000_000_000
PERIOD_NS = 100_000_000
TOL_M = 0.03
READY_S = 120.0  # its kernels may have to be compiled first
PATIENT = "scan_timeout_s:=1000.0"  # no silence stops it
OK, STALE = b"\x00", b"\x03"
SILENT = "no scans: pose and map->odom are not sent"


class Robot:
    """Drives through the square room and publishes what a robot would."""

    def __init__(self, peer: Any, node: Any) -> None:
        from geometry_msgs.msg import PoseWithCovarianceStamped
        from nav_msgs.msg import OccupancyGrid
        from sensor_msgs.msg import LaserScan
        from tf2_msgs.msg import TFMessage

        from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, TF_QOS
        from floornav_common.ros.transforms import StaticTransformBroadcaster

        self.peer = peer
        self.maps = peer.collect(OccupancyGrid, "map", LATCHED_QOS)
        self.poses = peer.collect(PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
        self.transforms = peer.collect(TFMessage, "/tf", TF_QOS)
        self._tf_message = TFMessage
        self._statics = StaticTransformBroadcaster(peer.node)
        self._tf = peer.publisher(TFMessage, "/tf", TF_QOS, to=node, num=2)
        self._scan = peer.publisher(LaserScan, "scan", RELIABLE_QOS, to=node)
        self._statics.send("base_link", "laser", 0, Transform3.from_se2(LASER))
        node.wait_to_hear("/tf_static")
        peer.wait_to_hear("map", "pose", "/tf")
        node.wait_for("/pose is sent to 1")
        self.poses_driven = drive_around()
        self.T_odom_start = SE2.identity()
        self.step = 0

    def is_sending(self, seconds: float) -> bool:
        """Return whether the mapper sends its transform in the next while."""
        self.transforms.clear()
        self.peer.spin(seconds)
        return bool(self.sent_by_mapper())

    def stops_sending(self) -> None:
        """Wait until the mapper sends its transform no longer."""
        for _ in range(60):
            if not self.is_sending(0.5):
                return
        pytest.fail("map->odom is still sent")

    def send_odometry(self, odom: SE2, stamp_ns: int) -> None:
        from floornav_common.ros.transforms import _stamped

        msg = self._tf_message()
        msg.transforms = [_stamped("odom", "base_link", stamp_ns, Transform3.from_se2(odom))]
        self._tf.publish(msg)

    def send_scan(self, pose: SE2, stamp_ns: int, frame: str = "laser") -> None:
        rng = np.random.default_rng(self.step)
        self.send(scan_at(pose @ LASER, square_room(), rng=rng), stamp_ns, frame)

    def send(self, scan: Scan, stamp_ns: int, frame: str = "laser") -> None:
        from std_msgs.msg import Header

        from floornav_common.ros.messages import ns_to_stamp, scan_to_msg

        self._scan.publish(scan_to_msg(scan, Header(stamp=ns_to_stamp(stamp_ns), frame_id=frame)))

    def drive(self, num: int) -> SE2:
        """Send scans, each before the odometry that covers it, as real robots do; await poses."""
        pose = SE2.identity()
        for _ in range(num):
            pose, stamp_ns = self.send_step()
            self.wait_for_pose(stamp_ns)
        return self.poses_driven[0].between(pose)

    def send_step(self, pose: SE2 | None = None) -> tuple[SE2, int]:
        """Send a scan and the odometry that covers it; return its pose, and stamp."""
        stamp_ns = T0_NS + self.step * PERIOD_NS
        pose = pose or self.poses_driven[self.step % len(self.poses_driven)]
        self.send_scan(pose, stamp_ns)
        self.send_odometry(self.T_odom_start @ self.poses_driven[0].between(pose), stamp_ns)
        self.step += 1
        return pose, stamp_ns

    def wait_for_pose(self, stamp_ns: int) -> None:
        """Wait for the answer to a scan."""
        stamp = (stamp_ns // 10**9, stamp_ns % 10**9)
        self.peer.spin_until(
            lambda: (
                bool(self.poses)
                and (self.poses[-1].header.stamp.sec, self.poses[-1].header.stamp.nanosec) == stamp
            )
        )

    def sent_by_mapper(self) -> list[Any]:
        return [t for m in self.transforms for t in m.transforms if t.header.frame_id == "map"]


def mapping_status(arrays: list[Any]) -> tuple[bytes, str]:
    """Return level and message of what the mapper said last of its mapping."""
    said = [s for array in arrays for s in array.status if s.name == "/grid_mapper: mapping"]
    return (said[-1].level, said[-1].message) if said else (b"", "")


@pytest.fixture
def make_mapper(start: Callable[..., Any], peer: Any) -> Callable[..., SimpleNamespace]:
    """Return a function that starts the node with further parameters, and the robot."""

    def make(*parameters: str) -> SimpleNamespace:
        fixed = ("map_period_s:=0.2", "lost_after_s:=1.0", "transform_timeout_s:=2.0")
        given = [word for parameter in (*fixed, *parameters) for word in ("-p", parameter)]
        node = start(*NODE, "--ros-args", *given)
        node.wait_for("ready", READY_S)
        return SimpleNamespace(node=node, robot=Robot(peer, node), peer=peer)

    return make


@pytest.fixture
def mapper(make_mapper: Callable[..., SimpleNamespace]) -> SimpleNamespace:
    return make_mapper()


def test_a_drive_gives_poses_a_map_and_map_to_odom(mapper):
    from floornav_common.ros.messages import grid_from_msg, pose_to_se2

    robot = mapper.robot
    expected = robot.drive(30)
    assert len(robot.poses) == 30
    last = robot.poses[-1]
    assert last.header.frame_id == "map"
    assert last.header.stamp.sec * 10**9 + last.header.stamp.nanosec == T0_NS + 29 * PERIOD_NS
    assert expected.between(pose_to_se2(last.pose.pose)).distance < TOL_M
    assert last.pose.covariance[0] > 0.0
    mapper.peer.spin_until(lambda: robot.maps and robot.sent_by_mapper())
    grid = grid_from_msg(robot.maps[-1])
    wall = robot.poses_driven[0].inverse() @ np.array([[4.0, 0.5]])
    assert grid.cells[tuple(grid.to_cells(wall)[0])] == 100
    transform = robot.sent_by_mapper()[-1]
    assert transform.child_frame_id == "odom"
    assert abs(transform.transform.translation.x) < TOL_M


def test_save_map_works_a_hundred_times_while_scans_arrive(mapper, tmp_path):
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    mapper.robot.drive(10)
    mapper.peer.spin_until(lambda: bool(mapper.robot.maps))
    for number in range(100):
        mapper.robot.drive(1)
        name = Parameter("map_file", value=str(tmp_path / f"m{number}")).to_parameter_msg()
        request = SetParameters.Request(parameters=[name])
        mapper.peer.call(SetParameters, "grid_mapper/set_parameters", request, mapper.node)
        answer = mapper.peer.trigger("grid_mapper/save_map", mapper.node)
        assert answer.success, answer.message
        assert (load_map(answer.message).cells == 100).any()
    again = mapper.peer.trigger("grid_mapper/save_map", mapper.node)
    assert not again.success and "another name" in again.message


def test_without_transforms_nothing_is_published_and_the_frame_is_named(mapper):
    for step in range(15):
        mapper.robot.send_scan(SE2.identity(), T0_NS + step * PERIOD_NS, frame="nowhere")
        mapper.peer.spin(0.1)
    assert "nowhere" in mapper.node.wait_for("dropped")
    assert not mapper.robot.poses and not mapper.robot.maps


def test_a_blind_laser_means_lost_and_no_transform(make_mapper):
    mapper = make_mapper(PATIENT)
    robot = mapper.robot
    robot.drive(15)
    blind = Scan(np.full(360, np.nan), -np.pi, 2.0 * np.pi / 360, 0.05, 30.0)
    for _ in range(15):
        stamp_ns = T0_NS + robot.step * PERIOD_NS
        robot.send(blind, stamp_ns)
        robot.send_odometry(SE2.identity(), stamp_ns)
        mapper.peer.spin(0.05)
        robot.step += 1
    mapper.node.wait_for("scan not trusted")
    # 15 of the drive, and the blind ones up to lost_after_s (1.0 s) behind the last trusted scan
    mapper.peer.spin_until(lambda: len(robot.poses) == 15 + 10)
    robot.stops_sending()
    assert len(robot.poses) == 15 + 10


def test_map_to_odom_stops_when_scans_stop_and_comes_back_with_a_trusted_one(mapper):
    robot = mapper.robot
    arrays = mapper.peer.collect(DiagnosticArray, "/diagnostics", 10)
    robot.drive(15)
    mapper.peer.spin_until(lambda: bool(robot.sent_by_mapper()))
    mapper.peer.spin_until(lambda: mapping_status(arrays) == (STALE, SILENT))
    robot.stops_sending()
    num_poses = len(robot.poses)
    blind = Scan(np.full(360, np.nan), -np.pi, 2.0 * np.pi / 360, 0.05, 30.0)
    robot.send(blind, T0_NS + robot.step * PERIOD_NS)
    robot.send_odometry(SE2.identity(), T0_NS + robot.step * PERIOD_NS)
    mapper.node.wait_for("scan not trusted")
    assert not robot.is_sending(0.5) and len(robot.poses) == num_poses
    robot.step += 1
    robot.drive(1)
    mapper.peer.spin_until(lambda: bool(robot.sent_by_mapper()))
    mapper.peer.spin_until(lambda: mapping_status(arrays)[0] == OK)


def test_map_to_odom_stops_when_no_scan_finds_its_transform(mapper):
    robot = mapper.robot
    arrays = mapper.peer.collect(DiagnosticArray, "/diagnostics", 10)
    robot.drive(15)
    mapper.peer.spin_until(lambda: bool(robot.sent_by_mapper()))
    for step in range(30):
        robot.send_scan(SE2.identity(), T0_NS + (20 + step) * PERIOD_NS, frame="nowhere")
        mapper.peer.spin(0.1)
    mapper.peer.spin_until(lambda: mapping_status(arrays) == (STALE, SILENT))
    robot.stops_sending()


def test_transforms_that_jump_back_stop_map_to_odom(make_mapper):
    mapper = make_mapper(PATIENT)
    robot = mapper.robot
    robot.drive(15)
    mapper.peer.spin_until(lambda: bool(robot.sent_by_mapper()))
    robot.drive(1)
    for number in range(60):
        robot.send_odometry(SE2.identity(), T0_NS // 2 + number)
        mapper.peer.spin(0.005)
    mapper.node.wait_for("jumped back without /clock")
    robot.stops_sending()


class ClockedRobot(Robot):
    """Drives beside a clock, which jumps back."""

    def __init__(self, peer: Any, node: Any) -> None:
        from rosgraph_msgs.msg import Clock

        super().__init__(peer, node)
        self._clock = peer.publisher(Clock, "/clock", 1, to=node)

    def tick(self, first_ns: int, num: int) -> None:
        """Send times, half a period apart."""
        from rosgraph_msgs.msg import Clock

        from floornav_common.ros.messages import ns_to_stamp

        for number in range(num):
            self._clock.publish(Clock(clock=ns_to_stamp(first_ns + number * PERIOD_NS // 2)))
            self.peer.spin(0.02)

    def jump_back(self, node: Any) -> None:
        """Drive five steps, and let the clock jump back to where it began."""
        self.tick(T0_NS, 10)
        self.drive(5)
        self.tick(T0_NS + 5 * PERIOD_NS, 30)
        self.peer.spin_until(lambda: bool(self.sent_by_mapper()))
        self.tick(T0_NS, 3)
        node.wait_for("the clock jumped back")
        self.stops_sending()


def test_a_clock_that_jumps_back_stops_map_to_odom_until_a_scan_is_trusted(start, peer):
    node = start(*NODE, "--ros-args", "-p", "use_sim_time:=true")
    node.wait_for("ready", READY_S)
    robot = ClockedRobot(peer, node)
    robot.jump_back(node)
    robot.tick(T0_NS + PERIOD_NS, 20)
    assert not robot.sent_by_mapper()
    robot.step = 0
    for step in range(50):  # it stands where it was, as odometry says
        robot.send_step(robot.poses_driven[4])
        robot.tick(T0_NS + (15 + step) * PERIOD_NS, 2)
        if robot.sent_by_mapper():
            break
    assert robot.sent_by_mapper()


def test_where_odometry_jumped_with_the_clock_the_robot_has_to_drive_to_be_found(start, peer):
    node = start(*NODE, "--ros-args", "-p", "use_sim_time:=true")
    node.wait_for("ready", READY_S)
    robot = ClockedRobot(peer, node)
    robot.jump_back(node)
    robot.T_odom_start = SE2(3.0, 0.0, 1.0)
    robot.step = 0
    for step in range(1000):  # it is looked for in the whole map, and has to drive for that
        if step < len(robot.poses_driven):
            robot.send_step()
        robot.tick(T0_NS + (15 + step) * PERIOD_NS, 2)
        if step == 4:
            assert not robot.sent_by_mapper()
        if robot.sent_by_mapper():
            break
    assert robot.sent_by_mapper()


def test_a_coarse_scan_is_refused_and_the_node_lives(mapper):
    robot = mapper.robot
    for step in range(3):
        stamp_ns = T0_NS - (10 - step) * PERIOD_NS
        robot.send(Scan(np.full(40, 2.0), 0.0, 0.3, 0.05, 30.0), stamp_ns)
        robot.send_odometry(SE2.identity(), stamp_ns)
    assert "40 beams" in mapper.node.wait_for("at most 6.91 rad")
    robot.drive(3)
    assert len(robot.poses) == 3


def test_another_source_of_map_to_odom_is_named_and_left_alone(mapper):
    from floornav_common.ros.transforms import _stamped

    robot = mapper.robot
    for _ in range(15):
        msg = robot._tf_message()
        other = Transform3.from_se2(SE2(5.0, 5.0, 0.0))
        msg.transforms = [_stamped("map", "odom", T0_NS, other)]
        robot._tf.publish(msg)
        robot.drive(1)
    assert "test_peer" in mapper.node.wait_for("also published by")
    assert all(t.transform.translation.x == 5.0 for t in robot.sent_by_mapper())


def test_reset_empties_the_map(mapper):
    mapper.robot.drive(10)
    mapper.peer.spin_until(lambda: bool(mapper.robot.maps))
    assert mapper.peer.trigger("grid_mapper/reset", mapper.node).success
    answer = mapper.peer.trigger("grid_mapper/save_map", mapper.node)
    assert not answer.success and "no cells" in answer.message


def test_reset_replaces_the_latched_map_by_one_unknown_cell(mapper, make_peer):
    from nav_msgs.msg import OccupancyGrid

    from floornav_common.ros.qos import LATCHED_QOS

    mapper.robot.drive(10)
    mapper.peer.spin_until(lambda: bool(mapper.robot.maps))
    assert mapper.peer.trigger("grid_mapper/reset", mapper.node).success
    late = make_peer("late_reader")
    maps = late.collect(OccupancyGrid, "map", LATCHED_QOS)
    late.spin_until(lambda: bool(maps))
    assert list(maps[-1].data) == [-1] and maps[-1].header.frame_id == "map"
    mapper.robot.drive(1)
    mapper.peer.spin_until(lambda: mapper.robot.maps[-1].info.width > 1)


def test_a_wrong_parameter_ends_the_node_with_one_line(start):
    node = start(*NODE, "--ros-args", "-p", "matcher.cell_m:=-1.0")
    assert node.wait_for_exit() == 2
    assert "matcher.cell_m must be > 0" in node.text and "Traceback" not in node.text


def test_it_runs_with_nothing_but_paths_in_its_environment(start, peer, monkeypatch):
    kept = ("AMENT_PREFIX_PATH", "PYTHONPATH", "PATH", "HOME", "LD_LIBRARY_PATH", "ROS_DOMAIN_ID")
    own = ("PYTHONUNBUFFERED", "ROS_AUTOMATIC_DISCOVERY_RANGE", "NUMBA_CACHE_DIR")
    for name in os.environ:
        if name not in (*kept, *own, "_ROS_WHEELS_BOOTSTRAP_COMPLETE"):
            monkeypatch.delenv(name)
    node = start(*NODE)
    node.wait_for("ready", READY_S)
    robot = Robot(peer, node)
    robot.drive(5)
    assert len(robot.poses) == 5
    assert node.stop() == 0 and "Traceback" not in node.text


def test_odometry_without_transforms_is_taken_from_its_topic(mapper):
    from nav_msgs.msg import Odometry

    from floornav_common.ros.messages import ns_to_stamp, se2_to_pose
    from floornav_common.ros.qos import RELIABLE_QOS

    odom_pub = mapper.peer.publisher(Odometry, "odom", RELIABLE_QOS, to=mapper.node)
    robot = mapper.robot
    for step in range(10):
        stamp_ns = T0_NS + step * PERIOD_NS
        pose = robot.poses_driven[step]
        robot.send_scan(pose, stamp_ns)
        msg = Odometry(child_frame_id="base_link")
        msg.header.frame_id, msg.header.stamp = "odom", ns_to_stamp(stamp_ns)
        msg.pose.pose = se2_to_pose(robot.poses_driven[0].between(pose))
        odom_pub.publish(msg)
        robot.wait_for_pose(stamp_ns)
    assert len(robot.poses) == 10
