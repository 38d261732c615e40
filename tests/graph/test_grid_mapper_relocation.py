"""The mapping node over DDS in a map made before: lost, found, carried off, found again."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "grid_mapper"))

from loop_builders import ring, round_the_ring
from test_relocalizer import map_of
from worlds import scan_at

from floornav_common.se2 import SE2
from grid_mapper.map_files import save_map

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import PoseWithCovarianceStamped  # noqa: E402
from robot_messages import statuses  # noqa: E402
from test_grid_mapper import LASER, NODE, PERIOD_NS, READY_S, T0_NS, Robot  # noqa: E402

from floornav_common.ros.messages import (  # noqa: E402
    grid_from_msg,
    pose_to_se2,
    se2_cov_to_ros,
    se2_to_pose,
)
from floornav_common.ros.qos import RELIABLE_QOS  # noqa: E402

WAY = round_the_ring(360)
TOL_M, TOL_RAD = 0.08, 0.05
OK, ERROR = b"\x00", b"\x02"


class LostRobot(Robot):
    """Drives round the ring with good wheels, heard or not."""

    def __init__(self, peer: Any, node: Any) -> None:
        super().__init__(peer, node)
        self.said = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
        self.initialpose = peer.publisher(
            PoseWithCovarianceStamped, "initialpose", RELIABLE_QOS, to=node
        )
        self.place, self.odometry, self.step = 60, SE2(3.0, -2.0, 1.0), 0

    def scan(self, moved: int) -> SE2:
        """Go on so many poses, send a scan, and return where it was taken."""
        before = WAY[self.place % len(WAY)]
        self.place += moved
        pose = WAY[self.place % len(WAY)]
        self.odometry @= before.between(pose)
        stamp_ns = T0_NS + self.step * PERIOD_NS
        rng = np.random.default_rng(self.step)
        self.send(scan_at(pose @ LASER, ring(), rng=rng, range_max=8.0), stamp_ns)
        self.send_odometry(self.odometry, stamp_ns)
        self.step += 1
        return pose

    def drive_until(self, is_done: Callable[[SE2], bool], moved: int = 1) -> SE2:
        """Drive on, a scan a while, until something is so; return where."""
        for _ in range(250):
            pose = self.scan(moved)
            if self.peer.spin_until(lambda: is_done(pose), 0.3, must=False):  # noqa: B023
                return pose
        pytest.fail(f"not so: {self.mapping()}, {len(self.poses)} poses")

    def is_at(self, truth: SE2) -> bool:
        """Tell whether the newest scan was answered by its true pose."""
        if not self.poses:
            return False
        header = self.poses[-1].header.stamp
        stamp_ns = T0_NS + (self.step - 1) * PERIOD_NS
        off = truth.between(pose_to_se2(self.poses[-1].pose.pose))
        is_newest = header.sec * 10**9 + header.nanosec == stamp_ns
        return is_newest and off.distance < TOL_M and abs(off.yaw) < TOL_RAD

    def mapping(self) -> tuple[bytes, str]:
        said = statuses(self.said, "mapping")
        return (said[-1].level, said[-1].message) if said else (b"", "")

    def is_said_lost(self) -> bool:
        level, words = self.mapping()
        return level == ERROR and "lost" in words

    def say_where(self, pose: SE2, sigma: float) -> None:
        msg = PoseWithCovarianceStamped()
        msg.header.frame_id, msg.pose.pose = "map", se2_to_pose(pose)
        msg.pose.covariance = se2_cov_to_ros(np.diag([sigma, sigma, 0.3]) ** 2)
        self.initialpose.publish(msg)


@pytest.fixture(scope="module")
def saved_map(tmp_path_factory: Any) -> Path:
    return save_map(tmp_path_factory.mktemp("map") / "ring", map_of(ring(), WAY[::6]))


@pytest.fixture
def robot(start: Any, peer: Any, saved_map: Path) -> LostRobot:
    parameters = (
        f"start_map:={saved_map}", "keep_start_map:=true", "map_period_s:=0.3",
        "lost_after_s:=1.0", "transform_timeout_s:=2.0", "scan_timeout_s:=1000.0",
    )  # fmt: skip
    words = [word for parameter in parameters for word in ("-p", parameter)]
    node = start(*NODE, "--ros-args", *words)
    node.wait_for("ready", READY_S)
    return LostRobot(peer, node)


def test_it_is_found_from_anywhere_and_again_when_carried_off(robot: LostRobot) -> None:
    robot.drive_until(lambda _: robot.is_said_lost(), moved=0)
    assert not robot.poses and not robot.sent_by_mapper()
    robot.drive_until(robot.is_at)
    robot.peer.spin_until(lambda: bool(robot.sent_by_mapper()))
    robot.peer.spin_until(lambda: robot.mapping()[0] == OK)
    robot.place += 150  # carried there: odometry feels nothing
    robot.drive_until(lambda _: robot.is_said_lost())
    robot.drive_until(robot.is_at)
    robot.peer.spin_until(lambda: len(robot.maps) > 0)
    assert len({bytes(grid_from_msg(msg).cells) for msg in robot.maps}) == 1


def test_said_about_where_it_is_it_is_found_where_it_stands(robot: LostRobot) -> None:
    robot.drive_until(lambda _: robot.is_said_lost(), moved=0)
    robot.say_where(WAY[robot.place] @ SE2(0.4, 0.3, 0.2), 0.4)
    robot.drive_until(robot.is_at, moved=0)


def test_a_map_that_cannot_be_read_is_named_at_the_start(start: Any, tmp_path: Path) -> None:
    node = start(*NODE, "--ros-args", "-p", f"start_map:={tmp_path / 'nowhere.yaml'}")
    assert node.wait_for_exit(READY_S) == 2
    assert "nowhere.yaml" in node.text
