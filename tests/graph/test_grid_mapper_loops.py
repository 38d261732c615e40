"""The mapping node over DDS closes a loop: pose, way and map before and after."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "grid_mapper"))

from loop_builders import drifted, ring, round_the_ring
from scipy.spatial import KDTree
from worlds import scan_at

from floornav_common.grid import OCCUPIED
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
pytest.importorskip("gtsam", reason="loops are closed by gtsam")
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import PoseWithCovarianceStamped  # noqa: E402
from nav_msgs.msg import OccupancyGrid  # noqa: E402
from nav_msgs.msg import Path as PathMsg
from robot_messages import statuses  # noqa: E402
from test_grid_mapper import NODE, PERIOD_NS, READY_S, T0_NS, Robot  # noqa: E402

from floornav_common.ros.messages import (  # noqa: E402
    grid_from_msg,
    pose_to_se2,
    se2_cov_to_ros,
    se2_to_pose,
)
from floornav_common.ros.qos import RELIABLE_QOS  # noqa: E402
from grid_mapper.nodes import mapper_choice  # noqa: E402

LAPS, NUM = 1.3, 150
STANDING = 400
SHORT_SIGHTED, GOOD = (90, 0.03, 4.0), (180, 0.01, 8.0)
"""Lasers: beams, noise (m), range (m)."""
ONE_LAP = round(NUM / LAPS)
LASER = SE2(0.1, 0.0, 0.2)
OK, WARN = b"\x00", b"\x01"


class RingRobot(Robot):
    """Drives round the ring; its wheels turn and stretch, its laser is short-sighted."""

    def __init__(self, peer: Any, node: Any) -> None:
        super().__init__(peer, node)
        self.node_pid = node.process.pid
        self.laser = SHORT_SIGHTED
        self.truth = round_the_ring(NUM, LAPS)
        self.odometry = drifted(self.truth, 0.01, 1.05)
        self.paths = peer.collect(PathMsg, "trajectory", RELIABLE_QOS)
        self.said = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
        self._initialpose = peer.publisher(
            PoseWithCovarianceStamped, "initialpose", RELIABLE_QOS, to=node
        )
        peer.wait_to_hear("trajectory", "/diagnostics")
        node.wait_for("/trajectory is sent to 1")

    def go_on(self, num: int) -> None:
        """Send so many scans with their odometry, and wait for each pose."""
        for _ in range(num):
            self.wait_for_pose(self.go())

    def go(self) -> int:
        """Send a scan with its odometry, and return its stamp."""
        k, stamp_ns = self.step, T0_NS + self.step * PERIOD_NS
        self.send(self.scan(k), stamp_ns)
        self.send_odometry(self.truth[0].between(self.odometry[k]), stamp_ns)
        self.step += 1
        return stamp_ns

    def carry_to(self, place: int) -> None:
        """Let the robot be carried to an earlier place of its way; its wheels feel nothing."""
        truth, odometry, now = self.truth, self.odometry, self.step
        moved = [odometry[place].between(odom) for odom in odometry[place:]]
        self.truth = truth[:now] + truth[place:]
        self.odometry = odometry[:now] + [odometry[now - 1] @ T for T in moved]

    def say_where(self, pose: SE2) -> None:
        """Send `initialpose`, as RViz does."""
        msg = PoseWithCovarianceStamped()
        msg.header.frame_id, msg.pose.pose = "map", se2_to_pose(pose)
        msg.pose.covariance = se2_cov_to_ros(np.diag([0.25, 0.25, 0.07]))
        self._initialpose.publish(msg)

    def mapping(self) -> tuple[bytes, int]:
        """Return the newest level that the node said of its mapping, and how often it was found."""
        said = statuses(self.said, "mapping")
        values = {v.key: v.value for v in said[-1].values} if said else {}
        return (said[-1].level if said else b""), int(values.get("found again", 0))

    def error(self) -> float:
        """Return how far the newest pose is from the true one of its scan."""
        header = self.poses[-1].header.stamp
        k = round((header.sec * 10**9 + header.nanosec - T0_NS) / PERIOD_NS)
        truth = self.truth[0].between(self.truth[k])
        return truth.between(pose_to_se2(self.poses[-1].pose.pose)).distance

    def loops(self) -> dict[str, float]:
        """Return the newest counts that the node said of its loops."""
        said = statuses(self.said, "loops")
        newest = {v.key: float(v.value) for v in said[-1].values} if said else {}
        return {"loops closed": 0, "maps made anew": 0, **newest}

    def way(self) -> dict[int, SE2]:
        """Return the newest trajectory, by number of the scan."""
        rows = self.paths[-1].poses
        msgs = {p.header.stamp.sec * 10**9 + p.header.stamp.nanosec: p for p in rows}
        return {round((ns - T0_NS) / PERIOD_NS): pose_to_se2(p.pose) for ns, p in msgs.items()}

    def seen_on_the_way(self) -> np.ndarray:
        """Return what all scans show at the poses of the newest trajectory, shape (N, 2)."""
        seen = [pose @ (LASER @ self.scan(k).points()) for k, pose in self.way().items()]
        return np.vstack(seen)

    def scan(self, k: int) -> Scan:
        """Return a scan of the way."""
        num_beams, sigma, reach = self.laser
        pose, rng = self.truth[k] @ LASER, np.random.default_rng(k)
        return scan_at(pose, ring(), num_beams, rng, sigma, range_max=reach)

    def revisit_error(self) -> float:
        """Return the mean error of the newest trajectory's motions from lap to lap."""
        poses = self.way()
        pairs = [(k, k + ONE_LAP) for k in poses if k + ONE_LAP in poses]
        off = [
            self.truth[i].between(self.truth[j]).between(poses[i].between(poses[j])).distance
            for i, j in pairs
        ]
        assert len(off) > 10
        return float(np.mean(off))


@pytest.fixture
def robot(start: Any, peer: Any) -> RingRobot:
    parameters = (
        "loop.recent_scans:=20", "map_period_s:=0.3", "transform_timeout_s:=2.0",
        "scan_timeout_s:=1000.0", "lost_after_s:=1000.0",
    )  # fmt: skip
    words = [word for parameter in parameters for word in ("-p", parameter)]
    node = start(*NODE, "--ros-args", *words)
    node.wait_for("ready", READY_S)
    return RingRobot(peer, node)


def off_the_way(msg: OccupancyGrid, seen: np.ndarray) -> float:
    """Return how far on average the occupied cells of a map are from points, m."""
    grid = grid_from_msg(msg)
    rows, cols = np.nonzero(grid.cells == OCCUPIED)
    cells = grid.origin @ ((np.column_stack((cols, rows)) + 0.5) * grid.resolution)
    distance, _ = KDTree(seen).query(cells)
    return float(distance.mean())


def test_a_lap_is_closed_and_the_way_and_the_map_are_corrected(robot: RingRobot) -> None:
    robot.go_on(ONE_LAP - 6)
    assert robot.loops()["loops closed"] == 0
    robot.go_on(NUM - ONE_LAP + 6)
    # news of the background come in with the next scans; the robot stands
    robot.truth += STANDING * robot.truth[-1:]
    robot.odometry += STANDING * robot.odometry[-1:]
    for _ in range(STANDING):
        robot.go_on(1)
        robot.peer.spin(1.0)
        if robot.loops()["maps made anew"] > 0 and robot.revisit_error() < 0.12:
            break
    else:
        pytest.fail(f"not corrected: {robot.loops()}, revisits {robot.revisit_error():.2f} m off")
    assert robot.loops()["loops closed"] >= 1
    assert statuses(robot.said, "loops")[-1].level == OK
    maps: list[OccupancyGrid] = robot.maps
    seen = robot.seen_on_the_way()
    robot.peer.spin_until(lambda: off_the_way(maps[-1], seen) < 0.07, must=False)
    off = [off_the_way(msg, seen) for msg in maps]
    assert off[-1] < 0.07, f"the newest map is {off[-1]:.3f} m off the newest way"
    assert max(off) > 1.3 * off[-1], f"no map was further off than the newest: {max(off):.3f} m"
    gaps = np.diff([m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in maps])
    assert (gaps >= 0.0).all()


def test_said_where_it_is_it_goes_on_at_a_place_seen_long_ago(robot: RingRobot) -> None:
    place, robot.laser = 6, GOOD
    robot.go_on(45)  # of which the last 20 are recent
    robot.peer.spin_until(lambda: bool(robot.maps))
    robot.carry_to(place)
    robot.say_where(robot.truth[0].between(robot.truth[place]) @ SE2(0.2, -0.2, 0.1))
    for _ in range(30):
        robot.go()
        if robot.peer.spin_until(lambda: robot.mapping() == (OK, 1), 4.0, must=False):
            break
    assert robot.mapping() == (OK, 1), statuses(robot.said, "mapping")[-1].message
    robot.go_on(5)
    assert robot.error() < 0.15


def test_a_background_that_dies_is_said_and_the_robot_goes_on(robot: RingRobot) -> None:
    robot.go_on(5)
    found = subprocess.run(
        ["pgrep", "-P", str(robot.node_pid), "-f", "grid_mapper.background"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    os.kill(int(found.stdout.split()[0]), signal.SIGKILL)
    robot.peer.spin_until(lambda: any(s.level == WARN for s in statuses(robot.said, "loops")[-1:]))
    robot.go_on(5)
    assert "no longer" in statuses(robot.said, "loops")[-1].message


def test_without_the_solver_the_node_maps_on_and_says_so_once(monkeypatch: Any) -> None:
    said: list[str] = []
    parts: dict[str, Any] = {}
    node = SimpleNamespace(
        get_logger=lambda: SimpleNamespace(warning=said.append),
        diagnostics=SimpleNamespace(set=parts.__setitem__),
    )
    monkeypatch.setattr(mapper_choice, "find_spec", lambda name: None)
    mapper = mapper_choice.make_mapper(node, GridMapperConfig(), True, None, False)
    assert isinstance(mapper, LayeredMapper) and len(said) == 1
    assert parts["loops"].level == WARN and "gtsam" in parts["loops"].message
