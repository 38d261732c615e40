"""floornav_common over real DDS: QoS, parameters, clocks and exit codes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from robot_messages import Robot, S, hear_diagnostics, scan_of, statuses, tf_of, time_of
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

NODES = Path(__file__).parent / "common_nodes.py"
NodeProcess = Peer = Any  # of conftest.py
Start = Callable[..., NodeProcess]
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def test_qos_mismatch_names_the_publisher_and_the_cure(start: Start, make_peer: Any) -> None:
    node = start(NODES, "picky")
    node.wait_for("ready")
    driver = make_peer("old_driver")
    driver.node.create_publisher(LaserScan, "/scan", BEST_EFFORT)
    line = node.wait_for("/old_driver")
    assert "/scan" in line and "reliability" in line
    assert "-p qos_overrides./scan.subscription.reliability:=best_effort" in line


def test_a_topic_of_another_type_is_named_with_its_publisher(start: Start, make_peer: Any) -> None:
    node = start(NODES, "picky")
    node.wait_for("ready")
    driver = make_peer("other_driver")
    arrays = hear_diagnostics(driver)
    publisher = driver.node.create_publisher(Clock, "/scan", 10)
    driver.spin_until(lambda: any(s.level == b"\x02" for s in statuses(arrays, "topic types")))
    line = node.wait_for("/other_driver publishes")
    assert "/scan: no messages pass" in line
    assert "rosgraph_msgs/msg/Clock, this node sensor_msgs/msg/LaserScan" in line
    driver.node.destroy_publisher(publisher)
    driver.spin_until(lambda: statuses(arrays, "topic types")[-1].level == b"\x00")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["gain:=1.0"], "unknown ROS argument ['gain:=1.0']: put -p before each"),
        (["-p", "gain:="], "'-p gain:='"),
    ],
)
def test_ros_arguments_that_cannot_be_read_are_one_line(
    start: Start, given: list[str], said: str
) -> None:
    code = "import sys; from rclpy.node import Node; from floornav_common.ros.main import run_node;"
    node = start("-c", code + " sys.exit(run_node(Node))", "--ros-args", *given)
    assert node.wait_for_exit() == 2
    assert len(node.lines) == 1 and said in node.text


def test_the_cure_for_a_qos_mismatch_works(start: Start, peer: Peer) -> None:
    key = "qos_overrides./scan.subscription.reliability"
    node = start(NODES, "picky", "--ros-args", "-p", f"{key}:=best_effort")
    node.wait_for("ready")
    scans = peer.publisher(LaserScan, "/scan", BEST_EFFORT, to=node)
    peer.publish_until(scans, scan_of(1), lambda: "scan" in node.lines)


def test_silent_input_is_stale_on_diagnostics(start: Start, peer: Peer) -> None:
    node = start(NODES, "picky")
    node.wait_for("ready")
    arrays = hear_diagnostics(peer)
    peer.spin_until(lambda: any(s.level == b"\x03" for s in statuses(arrays, "input /scan")))
    assert "nobody" in statuses(arrays, "input /scan")[-1].message
    scans = peer.publisher(LaserScan, "/scan", 10, to=node)
    peer.publish_until(
        scans, scan_of(1),
        lambda: any(s.level == b"\x00" for s in statuses(arrays, "input /scan")),
    )  # fmt: skip
    peer.spin_until(lambda: "/test_peer" in statuses(arrays, "input /scan")[-1].message)
    assert statuses(arrays, "input /scan")[-1].level == b"\x03"


def test_an_input_that_comes_and_goes_is_said_in_the_log_once_in_ten_seconds(
    start: Start, peer: Peer
) -> None:
    node = start(NODES, "picky")
    node.wait_for("ready")
    arrays = hear_diagnostics(peer)
    began_s = time.monotonic()
    scans = peer.publisher(LaserScan, "/scan", 10, to=node)

    def is_now(level: bytes) -> bool:
        said = statuses(arrays, "input /scan")
        return bool(said) and said[-1].level == level

    for _ in range(4):
        peer.publish_until(scans, scan_of(1), lambda: is_now(b"\x00"))
        peer.spin_until(lambda: is_now(b"\x03"))
    num_said = node.text.count("; published by")
    assert 1 <= num_said <= 2 + int((time.monotonic() - began_s) / 10.0)  # one before it began
    assert node.text.count("/scan: arriving") <= num_said


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("gian:=1.0", "unknown parameter 'gian' (did you mean 'gain'?)"),
        ("gain:=2", "parameter gain must be > 0, <= 1, got 2.0"),
        ("count:=many", "parameter count must be an integer, got 'many'"),
    ],
)
def test_bad_parameters_end_the_node_with_one_line(start: Start, given: str, said: str) -> None:
    node = start(NODES, "tuned", "--ros-args", "-p", given)
    assert node.wait_for_exit() == 2
    assert [line for line in node.lines if not line.startswith("TunedConfig")] == [
        f"/tuned: {said}"
    ]


def test_a_parameter_for_one_node_of_several_is_refused_with_the_way_to_write_it(
    start: Start,
) -> None:
    node = start(NODES, "tuned_and_picky", "--ros-args", "-p", "gain:=0.7")
    assert node.wait_for_exit() == 2
    assert "/picky: unknown parameter 'gain'" in node.text
    assert "-p NODE:NAME:=VALUE" in node.text
    node = start(NODES, "tuned_and_picky", "--ros-args", "-p", "tuned:gain:=0.7")
    assert "gain=0.7" in node.wait_for("TunedConfig")
    assert node.stop() == 0


def test_a_value_that_the_warm_up_cannot_work_with_is_one_line(start: Start) -> None:
    node = start(NODES, "unusable")
    assert node.wait_for_exit() == 2
    assert node.lines == ["/unusable: the camera must see floor"]


def test_echo_finds_types_and_shows_poses_and_what_changed_of_diagnostics(
    start: Start, peer: Peer
) -> None:
    echo = start("-m", "floornav_common.ros.echo", "/pose", "/diagnostics")
    poses = peer.node.create_publisher(PoseWithCovarianceStamped, "/pose", 5)
    statuses_out = peer.node.create_publisher(DiagnosticArray, "/diagnostics", 5)
    pose = PoseWithCovarianceStamped()
    pose.header.frame_id, pose.pose.pose.position.x = "map", 1.25
    said = DiagnosticArray(status=[DiagnosticStatus(name="a: b", level=b"\x01", message="hm")])

    def is_shown() -> bool:
        poses.publish(pose)
        statuses_out.publish(said)
        return echo.text.count("x 1.250") >= 3 and "hm" in echo.text

    peer.spin_until(is_shown)
    assert "/pose 0.000 s in 'map': x 1.250 y 0.000 m yaw 0.0 deg, deviations" in echo.text
    assert echo.text.count("/diagnostics WARN  a: b: hm") == 1
    assert echo.stop() == 0


def test_echo_ends_quietly_where_nobody_reads_any_more(peer: Peer) -> None:
    command = [sys.executable, "-m", "floornav_common.ros.echo", "/pose"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    echo = subprocess.Popen(command, env=dict(os.environ), **pipes)
    try:
        assert echo.stdout is not None and echo.stderr is not None
        pose = peer.node.create_publisher(PoseWithCovarianceStamped, "/pose", 5)
        lines: list[str] = []
        reader = threading.Thread(target=lambda: lines.append(echo.stdout.readline()))
        reader.start()

        def shows(is_done: Callable[[], bool]) -> None:
            def sent() -> bool:
                pose.publish(PoseWithCovarianceStamped())
                return is_done()

            peer.spin_until(sent, 60.0)

        shows(lambda: bool(lines))
        echo.stdout.close()
        shows(lambda: echo.poll() is not None)
        reader.join()
        assert echo.returncode == 0 and echo.stderr.read() == ""
    finally:
        if echo.poll() is None:
            echo.kill()
        echo.wait(60.0)
        echo.stderr.close()


def test_echo_ends_after_so_many_and_names_what_it_does_not_take(start: Start, peer: Peer) -> None:
    scans = peer.node.create_publisher(LaserScan, "/scan", 5)
    echo = start("-m", "floornav_common.ros.echo", "scan", "--count", "2")

    def has_ended() -> bool:
        scans.publish(scan_of(S))
        return bool(echo.has_ended)

    peer.spin_until(has_ended)
    assert echo.wait_for_exit() == 0
    assert len([line for line in echo.lines if line.startswith("/scan 1.000 s")]) == 2
    assert start("-m", "floornav_common.ros.echo").wait_for_exit() == 2


def test_unknown_key_in_a_parameter_file_is_refused(start: Start, tmp_path: Path) -> None:
    path = tmp_path / "tuned.yaml"
    path.write_text("tuned:\n  ros__parameters:\n    gain: 1\n    tems: [a]\n")
    node = start(NODES, "tuned", "--ros-args", "--params-file", path)
    assert node.wait_for_exit() == 2
    assert "unknown parameter 'tems'" in node.text


def test_parameters_set_at_run_time_are_checked(start: Start, peer: Peer) -> None:
    node = start(NODES, "tuned", "--ros-args", "-p", "gain:=1", "-p", "use_sim_time:=false")
    node.wait_for("gain=1.0")

    def set_to(name: str, value: Any) -> Any:
        request = SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()]
        )
        return peer.call(SetParameters, "/tuned/set_parameters", request, node).results[0]

    assert set_to("gain", 0.25).successful
    node.wait_for("changed to TunedConfig(gain=0.25")
    assert "gain must be > 0, <= 1, got 0.0" in set_to("gain", 0).reason
    assert not set_to("size", 11).successful
    assert "filter.window must be >= 1, got 0" in set_to("filter.window", 0).reason
    assert set_to("filter.window", 7).successful
    node.wait_for("window=7")
    assert not set_to("name", "c").successful
    assert set_to("team", ["/r1", "/r2"]).successful
    node.wait_for("team=('/r1', '/r2')")
    assert set_to("gain", 1).successful
    node.wait_for("changed to TunedConfig(gain=1.0")


def test_a_clock_that_stops_is_an_error_and_one_that_jumps_back_clears(
    start: Start, peer: Peer
) -> None:
    node = start(NODES, "scan_echo", "--ros-args", "-p", "use_sim_time:=true")
    node.wait_for("ready")
    robot = Robot(peer, node)
    arrays = hear_diagnostics(peer)
    clock = peer.publisher(Clock, "/clock", 10, to=node)
    for _ in range(5):
        clock.publish(Clock(clock=time_of(100 * S)))
        peer.spin(0.1)
    robot.tf.publish(tf_of("odom", "base_link", 100 * S, 1.0))
    peer.spin(0.1)
    robot.scans.publish(scan_of(100 * S))
    node.wait_for("at x 1.500")
    peer.spin_until(lambda: any(s.level == b"\x02" for s in statuses(arrays, "clock")))
    clock.publish(Clock(clock=time_of(10 * S)))
    node.wait_for("jumped back")
    robot.tf.publish(tf_of("odom", "base_link", 10 * S, 2.0))
    robot.scans.publish(scan_of(10 * S))
    node.wait_for("at x 2.500")


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_a_process_of_two_nodes_with_0(start: Start, sign: signal.Signals) -> None:
    node = start(NODES, "both")
    node.wait_for("[picky]: ready")
    assert node.stop(sign) == 0
    assert "Traceback" not in node.text


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_a_node_is_built_ends_it_with_0(start: Start, sign: signal.Signals) -> None:
    node = start(NODES, "building")
    node.wait_for("building")
    assert node.stop(sign) == 0
    assert "Traceback" not in node.text


def test_an_error_in_a_callback_ends_the_node_with_1(start: Start) -> None:
    node = start(NODES, "broken")
    assert node.wait_for_exit() == 1
    assert "broken on purpose" in node.text


def test_compose_runs_nodes_of_installed_packages_in_one_process(
    start: Start, peer: Peer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nodes = tmp_path / "two_robots" / "nodes"
    nodes.mkdir(parents=True)
    for name in ("left", "right"):
        (nodes / f"{name}_node.py").write_text(
            "from floornav_common.ros.node import FloornavNode\n\n\n"
            f"class Side(FloornavNode):\n    def __init__(self):\n"
            f"        super().__init__('{name}')\n        self.ready()\n"
        )
    info = tmp_path / "two_robots-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: two_robots\nVersion: 1\n")
    (info / "entry_points.txt").write_text(
        "[console_scripts]\nleft = two_robots.nodes.left_node:main\n"
        "right = two_robots.nodes.right_node:main\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    words = ["two_robots/left", "two_robots/right", "--ros-args", "-r", "__ns:=/r2"]
    node = start("-m", "floornav_common.compose", *words)
    node.wait_for("[r2.left]: ready")
    node.wait_for("[r2.right]: ready")
    peer.spin_until(
        lambda: (
            {("left", "/r2"), ("right", "/r2")} <= set(peer.node.get_node_names_and_namespaces())
        )
    )
    assert node.stop() == 0


def test_compose_names_what_there_is(start: Start) -> None:
    node = start("-m", "floornav_common.compose", "grid_mapper/nix")
    assert node.wait_for_exit() == 2
    assert len(node.lines) == 1 and "no node 'grid_mapper/nix' is installed" in node.text
