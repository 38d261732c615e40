"""The node sim_bridge over DDS: what it sends, what it refuses, its services."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import CLOCK_QOS, LATCHED_QOS, RELIABLE_QOS, SENSOR_QOS

LISTENING = Path(__file__).with_name("listening.py")
START_S = 60.0


def _node(*parameters: str) -> list[str | Path]:
    given = [word for parameter in parameters for word in ("-p", parameter)]
    return [LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *given]


@pytest.fixture
def sim(start: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that starts the node and waits until it is ready."""

    def begin(*parameters: str) -> Any:
        process = start(*_node(*parameters))
        process.wait_for("ready", START_S)
        return process

    return begin


def test_it_sends_scan_odometry_clock_and_description(sim, peer) -> None:
    scans = peer.collect(LaserScan, "scan", SENSOR_QOS)
    odometry = peer.collect(Odometry, "odom", RELIABLE_QOS)
    truth = peer.collect(Odometry, "ground_truth/odom", RELIABLE_QOS)
    clock = peer.collect(Clock, "/clock", CLOCK_QOS)
    urdf = peer.collect(String, "robot_description", LATCHED_QOS)
    sim("real_time_factor:=2.0")
    peer.spin_until(lambda: len(scans) > 3 and len(odometry) > 3 and truth and clock and urdf)
    scan = scans[-1]
    assert (scan.header.frame_id, len(scan.ranges)) == ("laser", 541)
    assert stamp_to_ns(scan.header.stamp) % 100_000_000 == 0
    assert (odometry[0].header.frame_id, odometry[0].child_frame_id) == ("odom", "base_link")
    assert truth[0].header.frame_id == "ground_truth"
    assert "<robot" in urdf[0].data


def test_odometry_transform_and_sensor_place_are_on_tf(sim, peer) -> None:
    tf2 = pytest.importorskip("tf2_msgs.msg", reason="no tf2_msgs")
    moving = peer.collect(tf2.TFMessage, "/tf", RELIABLE_QOS)
    static = peer.collect(tf2.TFMessage, "/tf_static", LATCHED_QOS)
    sim()
    peer.spin_until(lambda: moving and static)
    first = moving[0].transforms[0]
    assert (first.header.frame_id, first.child_frame_id) == ("odom", "base_link")
    place = static[-1].transforms[0]
    assert (place.header.frame_id, place.child_frame_id) == ("base_link", "laser")
    assert place.transform.translation.x == pytest.approx(0.14)
    frames = {t.header.frame_id for msg in moving for t in msg.transforms}
    assert frames == {"odom"}


def test_it_drives_as_told(sim, peer) -> None:
    truth = peer.collect(Odometry, "ground_truth/odom", RELIABLE_QOS)
    sim()
    msg = Twist()
    msg.linear.x = 0.5
    commands = peer.publisher(Twist, "cmd_vel", RELIABLE_QOS)
    peer.publish_until(commands, msg, lambda: truth and truth[-1].twist.twist.linear.x > 0.4)


def test_stamped_commands_by_parameter(sim, peer) -> None:
    truth = peer.collect(Odometry, "ground_truth/odom", RELIABLE_QOS)
    sim("enable_stamped_cmd_vel:=true")
    msg = TwistStamped()
    msg.twist.angular.z = 0.5
    commands = peer.publisher(TwistStamped, "cmd_vel", RELIABLE_QOS)
    peer.publish_until(commands, msg, lambda: truth and truth[-1].twist.twist.angular.z > 0.4)


def test_a_nan_command_is_named_and_survived(sim, peer) -> None:
    odometry = peer.collect(Odometry, "odom", RELIABLE_QOS)
    process = sim()
    msg = Twist()
    msg.linear.x = math.nan
    commands = peer.publisher(Twist, "cmd_vel", RELIABLE_QOS)
    peer.publish_until(commands, msg, lambda: "refused" in process.text)
    assert "linear.x is nan" in process.wait_for("refused")
    count = len(odometry)
    peer.spin_until(lambda: len(odometry) > count + 5)
    assert math.isfinite(odometry[-1].pose.pose.position.x)


def test_in_lockstep_time_goes_on_only_when_asked(sim, peer) -> None:
    odometry = peer.collect(Odometry, "odom", RELIABLE_QOS)
    process = sim("lockstep:=true", "step_s:=0.2")
    peer.spin(0.5)
    assert not odometry
    assert peer.trigger("sim_bridge/step", process).message == "at 0.20 s"
    assert peer.trigger("sim_bridge/step", process).message == "at 0.40 s"
    assert peer.trigger("sim_bridge/reset", process).success
    assert peer.trigger("sim_bridge/step", process).message == "at 0.20 s"


def test_the_clock_keeps_a_period_that_is_no_whole_number_of_steps(sim, peer) -> None:
    clock = peer.collect(Clock, "/clock", CLOCK_QOS)
    sim("clock_period_s:=0.033", "real_time_factor:=1.0")
    peer.spin_until(lambda: len(clock) > 30)
    gaps = [
        stamp_to_ns(b.clock) - stamp_to_ns(a.clock) for a, b in zip(clock, clock[1:], strict=False)
    ]
    # Best effort: a message may be lost, but not most.
    assert sorted(gaps)[len(gaps) // 2] in (30_000_000, 40_000_000)
    assert min(gaps) >= 30_000_000


@pytest.mark.parametrize("parameter", ["step_s:=0.015", "step_s:=60.0"])
def test_a_step_that_would_be_rounded_or_block_is_refused(start, parameter: str) -> None:
    process = start(*_node(parameter))
    assert process.wait_for_exit(START_S) == 2
    assert "step_s" in process.text and "Traceback" not in process.text


def test_an_unknown_world_is_one_line_and_exit_code_2(start) -> None:
    process = start(*_node("world:=nowhere"))
    assert process.wait_for_exit(START_S) == 2
    assert "furnished_floor" in process.text and "Traceback" not in process.text


def test_sigint_ends_it_cleanly(sim) -> None:
    import signal

    process = sim("real_time_factor:=0.0")
    assert process.stop(signal.SIGINT) == 0
    assert "Traceback" not in process.text


def test_no_odometry_claims_to_be_certain(sim, peer) -> None:
    odometry = peer.collect(Odometry, "odom", RELIABLE_QOS)
    sim()
    peer.spin_until(lambda: bool(odometry))
    variances = np.diag(np.reshape(odometry[0].pose.covariance, (6, 6)))
    assert np.all(variances[[0, 1, 5]] > 0.0)
