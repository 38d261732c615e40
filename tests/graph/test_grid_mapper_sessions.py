"""The mapping node over DDS saves its session, and another process goes on with it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "grid_mapper"))

from floornav_common.grid import OCCUPIED
from floornav_common.ros.messages import grid_from_msg, pose_to_se2
from floornav_common.se2 import SE2

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
pytest.importorskip("gtsam", reason="a session is of a graph, which gtsam solves")
from test_grid_mapper import NODE, READY_S, T0_NS, Robot  # noqa: E402

TOL_M = 0.1
FIRST, MOST = 40, 60


def mapper(start: Callable[..., Any], *parameters: str) -> Any:
    fixed = ("map_period_s:=0.2", "transform_timeout_s:=2.0", "scan_timeout_s:=1000.0")
    given = [word for parameter in (*fixed, *parameters) for word in ("-p", parameter)]
    return start(*NODE, "--ros-args", *given)


def off(robot: Robot, k: int, begin: SE2) -> float:
    """Return how far the newest pose is from the true one of step `k` in the first map."""
    truth = begin.between(robot.poses_driven[k % len(robot.poses_driven)])
    return truth.between(pose_to_se2(robot.poses[-1].pose.pose)).distance


def num_walls(robot: Robot) -> int:
    return int((grid_from_msg(robot.maps[-1]).cells == OCCUPIED).sum())


def test_a_second_node_goes_on_in_the_map_of_the_first(
    start: Callable[..., Any], peer: Any, tmp_path: Path
) -> None:
    path = tmp_path / "floor.session"
    node = mapper(start, f"session_file:={path}")
    node.wait_for("ready", READY_S)
    robot = Robot(peer, node)
    robot.drive(FIRST)
    begin = robot.poses_driven[0]
    peer.spin_until(lambda: bool(robot.maps))
    walls = num_walls(robot)
    robot.maps.clear()
    assert node.stop(signal.SIGINT) == 0
    assert f"session saved: {path}" in node.text and path.stat().st_size > 1000

    again = mapper(start, f"start_session:={path}", f"session_file:={path}")
    again.wait_for("ready", READY_S)
    peer.spin_until(lambda: bool(robot.maps))
    assert num_walls(robot) > 0.8 * walls > 0, "its first map is not the session's"
    for topic, num in (("/tf", 2), ("/tf_static", 1), ("/scan", 1)):
        again.wait_to_hear(topic, num)
    again.wait_for("/pose is sent to 1")
    second = robot
    for _ in range(MOST):
        _, stamp_ns = second.send_step()
        peer.spin(0.1)
        newest = second.poses[-1].header.stamp if second.poses else None
        if newest is not None and newest.sec * 10**9 + newest.nanosec == stamp_ns:
            break
    else:
        pytest.fail(f"not found in the session:\n{again.text}")
    k = (stamp_ns - T0_NS) // 100_000_000
    assert off(second, k, begin) < TOL_M
    second.drive(10)
    assert off(second, second.step - 1, begin) < TOL_M
    assert again.stop() == 0 and again.text.count("session saved") == 1


@pytest.mark.parametrize(
    ("what", "problem"),
    [("missing", "No such file"), ("cut", "is cut off"), ("text", "no session of map_bag")],
)
def test_a_bad_session_ends_the_node_with_one_line(
    start: Callable[..., Any], tmp_path: Path, what: str, problem: str
) -> None:
    path = tmp_path / "bad.session"
    if what != "missing":
        path.write_bytes(b"PK\x03\x04" if what == "cut" else b"hello")
    node = mapper(start, f"start_session:={path}")
    assert node.wait_for_exit() == 2
    said = [line for line in node.lines if "start_session" in line]
    assert len(said) == 1 and problem in said[0] and "Traceback" not in node.text


def test_a_place_that_cannot_be_written_is_said_at_the_start(
    start: Callable[..., Any], tmp_path: Path
) -> None:
    node = mapper(start, f"session_file:={tmp_path}/nowhere/a.session")
    assert node.wait_for_exit() == 2
    assert f"there is no folder {tmp_path}/nowhere" in node.text
