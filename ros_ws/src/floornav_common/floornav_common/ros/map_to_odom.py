"""TF map->odom: sent again and again while the pose is valid, as AMCL does."""

from __future__ import annotations

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.transform_owner import TransformOwner
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3


class MapToOdom:
    """Sends the newest `T_map_odom`, stamped `transform_tolerance_s` ahead of the clock."""

    def __init__(self, node: FloornavNode) -> None:
        """Listen for others who send it, and begin to send."""
        self._node = node
        self._owner = TransformOwner(node, node.frames.map, node.frames.odom)
        self._transform: Transform3 | None = None
        node.create_timer(node.frames.tf_period_s, self._send)

    def set(self, T_map_odom: SE2 | None) -> None:
        """Take the newest transform; None stops sending."""
        self._transform = None if T_map_odom is None else Transform3.from_se2(T_map_odom)

    def _send(self) -> None:
        if self._transform is not None:
            now_ns = self._node.get_clock().now().nanoseconds
            ahead_ns = round(self._node.frames.transform_tolerance_s * 1e9)
            self._owner.send(now_ns + ahead_ns, self._transform)
