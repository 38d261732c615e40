"""The scan topic of the mapping node: leveled scans with where the robot was in some frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sensor_msgs.msg import LaserScan

from floornav_common.ros import messages
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.stuck_scan import StuckScan
from floornav_common.transform3 import Transform3
from floornav_common.transform_errors import TransformUnavailable
from grid_mapper.laser_mount import level_scan

OnScan = Callable[[Any, Scan, SE2, SE2], None]


class ScanInput:
    """Calls back with `(stamp, scan, T_base_laser, T_target_base)` once TF covers the stamp.

    A laser that repeats itself while the robot moves counts as silent.

    Args:
        node: The node.
        target_frame: Frame to place the robot in; its own makes `T_target_base` no motion.
        timeout_s: Silence after which scans are missed.
        on_scan: Called for each scan; a ValueError of it is said, and the scan left out.
        warn: Called with what to say, throttled.
    """

    def __init__(
        self,
        node: FloornavNode,
        target_frame: str,
        timeout_s: float,
        on_scan: OnScan,
        warn: Callable[[str], None],
    ) -> None:
        """Subscribe."""
        self._node = node
        self._on_scan = on_scan
        self._warn = warn
        self._scans = TransformedSubscription(
            node, LaserScan, "scan", SENSOR_QOS, target_frame, self._on_message
        )
        self._stuck = StuckScan()
        self._watchdog = Watchdog(node, self._scans.topic, timeout_s)

    @property
    def is_fresh(self) -> bool:
        """Whether scans that could be used keep coming."""
        return self._watchdog.is_fresh

    def set_timeout(self, timeout_s: float) -> None:
        """Change the silence allowed, s."""
        self._watchdog.set_timeout(timeout_s)

    def _on_message(self, msg: Any, T_target_laser: Transform3) -> None:
        try:
            T_base_laser = self._node.transforms.buffer.lookup(
                self._node.frames.base, msg.header.frame_id, messages.stamp_to_ns(msg.header.stamp)
            )
            scan, pose = level_scan(messages.scan_from_msg(msg), T_base_laser)
            T_target_base = (T_target_laser @ T_base_laser.inverse()).to_se2()
            self._stuck.take(scan.ranges, T_target_base)
            if self._stuck.fault:
                raise ValueError(self._stuck.fault)
            self._on_scan(msg.header.stamp, scan, pose, T_target_base)
        except (ValueError, TransformUnavailable) as error:
            self._warn(f"{self._scans.topic}: {error}")
            return
        self._watchdog.feed()
