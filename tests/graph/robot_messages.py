"""What a robot publishes, as the graph tests need it: stamps, scans, transforms."""

from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import LaserScan

NodeProcess = Peer = Any  # of conftest.py
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
S = 1_000_000_000


def time_of(stamp_ns: int) -> Time:
    return Time(sec=stamp_ns // S, nanosec=stamp_ns % S)


def scan_of(stamp_ns: int) -> LaserScan:
    msg = LaserScan(angle_increment=0.1, ranges=[1.0, 2.0])
    msg.header.stamp, msg.header.frame_id = time_of(stamp_ns), "laser"
    return msg


def tf_of(parent: str, child: str, stamp_ns: int, x: float) -> Any:
    from tf2_msgs.msg import TFMessage

    stamped = TransformStamped(child_frame_id=child)
    stamped.header.stamp, stamped.header.frame_id = time_of(stamp_ns), parent
    stamped.transform.translation.x = x
    return TFMessage(transforms=[stamped])


def statuses(arrays: list[DiagnosticArray], part: str) -> list[DiagnosticStatus]:
    return [s for array in arrays for s in array.status if s.name.endswith(f": {part}")]


def hear_diagnostics(peer: Peer) -> list[DiagnosticArray]:
    """Return a list that fills with the diagnostics of the nodes; the first have come."""
    arrays: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
    peer.spin_until(lambda: bool(arrays))
    return arrays


class Robot:
    """Driver and robot_state_publisher of a test: scans, odometry and the laser's place."""

    def __init__(self, peer: Peer, node: NodeProcess, namespace: str = "") -> None:
        tf2_msgs = pytest.importorskip("tf2_msgs.msg")
        self.peer = peer
        static = f"{namespace}/tf_static"
        self.statics = peer.publisher(tf2_msgs.TFMessage, static, LATCHED, to=node)
        self.tf = peer.publisher(tf2_msgs.TFMessage, f"{namespace}/tf", 10, to=node)
        self.scans = peer.publisher(LaserScan, f"{namespace}/scan", 10, to=node)
        self.statics.publish(tf_of("base_link", "laser", 0, 0.5))
