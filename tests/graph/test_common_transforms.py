"""floornav_common over real DDS: messages that wait for transforms, and who owns a transform."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from robot_messages import Robot, S, hear_diagnostics, scan_of, statuses, tf_of

NODES = Path(__file__).parent / "common_nodes.py"
NodeProcess = Peer = Any  # of conftest.py
Start = Callable[..., NodeProcess]


@pytest.fixture
def echo(start: Start) -> NodeProcess:
    node = start(NODES, "scan_echo")
    node.wait_for("ready")
    return node


def test_scans_wait_for_their_late_transforms_and_come_in_stamp_order(
    start: Start, peer: Peer
) -> None:
    echo = start(NODES, "scan_echo", "--ros-args", "-p", "transform_timeout_s:=10.0")
    echo.wait_for("ready")
    robot = Robot(peer, echo)
    robot.tf.publish(tf_of("odom", "base_link", 100 * S, 0.0))
    robot.scans.publish(scan_of(100 * S + S // 2))
    robot.scans.publish(scan_of(100 * S + S // 4))
    peer.spin(0.2)
    assert "scan 100" not in echo.text
    robot.tf.publish(tf_of("odom", "base_link", 101 * S, 1.0))
    echo.wait_for(f"scan {100 * S + S // 2} at x 1.000")
    said = [line for line in echo.lines if line.startswith("scan 100")]
    assert said[0] == f"scan {100 * S + S // 4} at x 0.750"


def test_a_scan_that_comes_after_a_newer_one_is_dropped_and_counted(
    echo: NodeProcess, peer: Peer
) -> None:
    robot = Robot(peer, echo)
    arrays = hear_diagnostics(peer)
    robot.tf.publish(tf_of("odom", "base_link", 100 * S, 0.0))
    robot.tf.publish(tf_of("odom", "base_link", 101 * S, 1.0))
    robot.scans.publish(scan_of(100 * S + S // 2))
    echo.wait_for("at x 1.000")
    robot.scans.publish(scan_of(100 * S + S // 4))
    assert "1 of 2 messages dropped, a message came late" in echo.wait_for("dropped")
    robot.scans.publish(scan_of(101 * S))
    echo.wait_for("at x 1.500")
    assert len([line for line in echo.lines if line.startswith("scan ")]) == 2
    part = "transforms of /scan"
    peer.spin_until(lambda: any(s.level == b"\x01" for s in statuses(arrays, part)))
    bad = next(s for s in statuses(arrays, part) if s.level == b"\x01")
    assert {v.key: v.value for v in bad.values}["dropped, too old"] == "1"


def test_a_scan_without_transform_is_dropped_and_named(echo: NodeProcess, peer: Peer) -> None:
    robot = Robot(peer, echo)
    arrays = hear_diagnostics(peer)
    robot.scans.publish(scan_of(100 * S))
    line = echo.wait_for("dropped")
    assert "/scan" in line and "'laser'" in line and "'odom'" in line
    part = "transforms of /scan"
    peer.spin_until(lambda: any(s.level == b"\x01" for s in statuses(arrays, part)))
    bad = next(s for s in statuses(arrays, part) if s.level == b"\x01")
    assert bad.name == "/scan_echo: transforms of /scan"
    assert {v.key: v.value for v in bad.values}["dropped"] == "1"


def test_a_scan_of_stamp_0_is_dropped_and_named(echo: NodeProcess, peer: Peer) -> None:
    robot = Robot(peer, echo)
    robot.tf.publish(tf_of("odom", "base_link", 100 * S, 0.0))
    robot.scans.publish(scan_of(0))
    assert "1 of 1 messages dropped, a message has stamp 0" in echo.wait_for("dropped")
    robot.scans.publish(scan_of(100 * S))
    echo.wait_for("at x 0.500")
    assert [line for line in echo.lines if line.startswith("scan ")] == [
        f"scan {100 * S} at x 0.500"
    ]


def test_remapped_tf_topics_are_heard(start: Start, peer: Peer) -> None:
    node = start(
        NODES, "scan_echo", "--ros-args", "-r", "__ns:=/r2", "-r", "/tf:=tf",
        "-r", "/tf_static:=tf_static",
    )  # fmt: skip
    node.wait_for("ready")
    robot = Robot(peer, node, "/r2")
    robot.tf.publish(tf_of("odom", "base_link", 100 * S, 2.0))
    robot.scans.publish(scan_of(100 * S))
    node.wait_for("at x 2.500")


def test_transforms_of_a_looping_bag_are_taken_up_without_clock(
    echo: NodeProcess, peer: Peer
) -> None:
    robot = Robot(peer, echo)
    robot.tf.publish(tf_of("odom", "base_link", 1000 * S, 0.0))
    robot.scans.publish(scan_of(1000 * S))
    echo.wait_for("at x 0.500")
    for i in range(60):
        robot.tf.publish(tf_of("odom", "base_link", 10 * S + i, 2.0))
        peer.spin(0.01)
    echo.wait_for("jumped back without /clock")
    robot.scans.publish(scan_of(10 * S + 55))
    echo.wait_for("at x 2.500")


def test_another_frame_that_goes_on_does_not_hide_a_looping_bag(
    echo: NodeProcess, peer: Peer
) -> None:
    """As the mapper's own map->odom, which it hears on /tf as well."""
    robot = Robot(peer, echo)
    robot.tf.publish(tf_of("odom", "base_link", 1000 * S, 0.0))
    for i in range(60):
        robot.tf.publish(tf_of("odom", "base_link", 10 * S + i, 2.0))
        robot.tf.publish(tf_of("map", "odom", 2000 * S + i, 0.0))
        peer.spin(0.01)
    echo.wait_for("jumped back without /clock")


def test_without_tf2_msgs_one_line_says_so_and_the_node_lives(start: Start) -> None:
    code = (
        "import runpy, sys; sys.modules['tf2_msgs'] = None; "
        f"sys.path.insert(0, {str(NODES.parent)!r}); "
        f"sys.argv = ['x', 'scan_echo']; runpy.run_path({str(NODES)!r}, run_name='__main__')"
    )
    node = start("-c", code)
    node.wait_for("tf2_msgs is not installed")
    node.wait_for("ready")
    assert node.stop() == 0 and node.text.count("tf2_msgs") == 1


def owner_beside_amcl(start: Start, make_peer: Any) -> tuple[Any, Any, Any]:
    """Return a node that sends map to odom, another one, and that one's publisher on /tf."""
    tf2_msgs = pytest.importorskip("tf2_msgs.msg")
    node = start(NODES, "owner")
    node.wait_for("sending")
    amcl = make_peer("amcl")
    return node, amcl, amcl.publisher(tf2_msgs.TFMessage, "/tf", 10, to=node, num=2)


def test_another_source_of_the_owned_transform_is_named_and_left_alone(
    start: Start, make_peer: Any
) -> None:
    node, amcl, tf = owner_beside_amcl(start, make_peer)
    tf.publish(tf_of("map", "odom", 5 * S, 1.0))
    line = node.wait_for("also published by")
    assert "/amcl" in line and "'map' to 'odom'" in line
    node.wait_for("silent")
    num_lines = len(node.lines)
    amcl.node.destroy_publisher(tf)
    amcl.spin_until(lambda: "sending" in node.lines[num_lines:])


def test_another_source_that_falls_silent_is_gone_though_its_publisher_stays(
    start: Start, make_peer: Any
) -> None:
    node, amcl, tf = owner_beside_amcl(start, make_peer)
    for k in range(20):
        tf.publish(tf_of("map", "odom", 5 * S + k, 1.0))
        amcl.spin(0.2)
    node.wait_for("silent")
    num_lines = len(node.lines)
    assert [line for line in node.lines if line in ("sending", "silent")][-1] == "silent"
    amcl.spin_until(lambda: "sending" in node.lines[num_lines:])
