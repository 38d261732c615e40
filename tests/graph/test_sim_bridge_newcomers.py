"""The node sim_bridge over DDS: what it says of a start or a graph that is not as it should be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from geometry_msgs.msg import Twist, TwistStamped
from robot_messages import hear_diagnostics, statuses
from rosgraph_msgs.msg import Clock

from floornav_common.ros.qos import CLOCK_QOS, RELIABLE_QOS

LISTENING = Path(__file__).with_name("listening.py")
START_S = 60.0


@pytest.fixture
def begin(start: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that starts the node with parameters."""

    def _begin(*parameters: str) -> Any:
        given = [word for parameter in parameters for word in ("-p", parameter)]
        return start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *given)

    return _begin


def test_a_window_without_a_display_is_one_line_and_exit_code_2(begin, monkeypatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    node = begin("view:=true")
    assert node.wait_for_exit() == 2
    assert len(node.lines) == 1 and "needs a display" in node.text


def test_wrong_names_of_those_to_wait_for_are_said_with_who_is_there(begin, peer) -> None:
    node = begin("start_nodes:=[grid_maper]", "pace_topics:=[posee]")
    line = node.wait_for("nodes there are: ", START_S)
    assert "WARN" in line and "/grid_maper" in line and "/test_peer" in line
    assert "nobody publishes posee" in node.wait_for("time does not wait for", START_S)


def test_a_second_clock_is_an_error_in_log_and_diagnostics(begin, peer) -> None:
    node = begin()
    arrays = hear_diagnostics(peer)
    peer.node.create_publisher(Clock, "/clock", CLOCK_QOS)
    peer.spin_until(lambda: any(s.level == b"\x02" for s in statuses(arrays, "clock topic")))
    line = node.wait_for("/clock is also published by")
    assert "ERROR" in line and "/test_peer" in line


def test_time_that_cannot_keep_up_is_said_with_both_factors(begin, peer) -> None:
    node = begin("real_time_factor:=1000.0")
    arrays = hear_diagnostics(peer)
    peer.spin_until(lambda: any(s.level == b"\x01" for s in statuses(arrays, "real time")))
    assert "of real time, 1000.00 asked" in node.wait_for("runs at")


def test_what_is_not_done_as_told_is_said_once(begin, peer) -> None:
    node = begin()
    node.wait_for("ready", START_S)
    msg = Twist()
    msg.linear.x, msg.linear.y = 2.0, 0.1
    commands = peer.publisher(Twist, "cmd_vel", RELIABLE_QOS, to=node)
    peer.publish_until(commands, msg, lambda: "linear.y is ignored" in node.text)
    for _ in range(5):
        commands.publish(msg)
        peer.spin(0.1)
    assert node.text.count("cmd_vel: linear.y is ignored") == 1
    assert "travel is clipped to max_speed_m_s, 1.667 m/s" in node.text


def test_stamped_commands_without_the_parameter_are_named(begin, peer) -> None:
    node = begin()
    node.wait_for("ready", START_S)
    peer.node.create_publisher(TwistStamped, "cmd_vel", RELIABLE_QOS)
    line = node.wait_for("/cmd_vel: no messages pass, /test_peer publishes")
    assert "set enable_stamped_cmd_vel the same" in line
