"""What the demo hears while it runs: one node of its own, beside the processes it started."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from std_msgs.msg import Bool

from _processes import ChildDiedError
from floornav_common.grid import OccupancyMap
from floornav_common.ros.messages import grid_from_msg, pose_to_se2, stamp_to_ns
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS
from floornav_common.se2 import SE2

_STALL_S = 20.0
Track = list[tuple[int, SE2]]


@dataclass
class Heard:
    """All that came so far.

    Attributes:
        truth: True poses in the world.
        odometry: Dead reckoning in the odom frame.
        estimate: The mapper's poses in the map frame.
        has_touched: True once the robot touched something.
        touched_at: Where it was then.
        grid: The newest map.
        grid_ns: Its stamp.
        path: Distance driven in truth, m.
    """

    truth: Track = field(default_factory=list)
    odometry: Track = field(default_factory=list)
    estimate: Track = field(default_factory=list)
    has_touched: bool = False
    touched_at: SE2 | None = None
    grid: OccupancyMap | None = None
    grid_ns: int = 0
    path: float = 0.0

    def cut_off(self, end_ns: int) -> None:
        """Forget the poses of later stamps."""
        for track in (self.truth, self.odometry, self.estimate):
            track[:] = [(stamp, pose) for stamp, pose in track if stamp <= end_ns]

    @property
    def sim_s(self) -> float:
        """Simulated time so far."""
        return self.truth[-1][0] * 1e-9 if self.truth else 0.0


class DemoWatch(Node):
    """Fills a `Heard`."""

    def __init__(self) -> None:
        super().__init__("demo_watch")
        self.heard = Heard()
        deep = RELIABLE_QOS.__class__(depth=100, reliability=RELIABLE_QOS.reliability)
        for msg_type, topic, callback, qos in (
            (Odometry, "ground_truth/odom", self._on_truth, deep),
            (Odometry, "odom", self._on_odom, deep),
            (PoseWithCovarianceStamped, "pose", self._on_pose, deep),
            (OccupancyGrid, "map", self._on_map, LATCHED_QOS),
            (Bool, "ground_truth/contact", self._on_contact, LATCHED_QOS),
        ):
            self.create_subscription(msg_type, topic, callback, qos)

    def _on_truth(self, msg: Any) -> None:
        truth, pose = self.heard.truth, pose_to_se2(msg.pose.pose)
        if truth:
            last = truth[-1][1]
            self.heard.path += math.hypot(pose.x - last.x, pose.y - last.y)
        truth.append((stamp_to_ns(msg.header.stamp), pose))

    def _on_odom(self, msg: Any) -> None:
        self.heard.odometry.append((stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)))

    def _on_pose(self, msg: Any) -> None:
        self.heard.estimate.append((stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)))

    def _on_map(self, msg: Any) -> None:
        grid = grid_from_msg(msg)
        self.heard.grid = OccupancyMap(grid.cells.copy(), grid.resolution, grid.origin)
        self.heard.grid_ns = stamp_to_ns(msg.header.stamp)

    def _on_contact(self, msg: Any) -> None:
        if msg.data and not self.heard.has_touched:
            self.heard.has_touched = True
            self.heard.touched_at = self.heard.truth[-1][1] if self.heard.truth else None


class Liveness:
    """Raises once a number that should grow has stood still for too long.

    Args:
        what: Name of what should go on, for the error.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._value: float | None = None
        self._since = 0.0

    def look(self, now: float, value: float) -> None:
        """Take in the number at a time (s).

        Raises:
            ChildDiedError: It stood still for `_STALL_S`.
        """
        if value != self._value:
            self._value, self._since = value, now
        elif now - self._since > _STALL_S:
            raise ChildDiedError(f"{self._what} stood still for {_STALL_S:.0f} s; see logs/")
