"""The static transform to the frame below the camera, unless someone else sends it."""

from __future__ import annotations

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.transform3 import Transform3

_WAIT_NS = 2_000_000_000


class FloorFrame:
    """Sends base_frame -> floor_frame once /tf_static has been quiet about it for two seconds.

    A robot description that has the frame is listened to; where there is none, the camera's YAML
    says where the camera is.

    Args:
        node: The node.
        name: Full name of the frame.
        camera: Where the camera is over the robot.
    """

    def __init__(self, node: FloornavNode, name: str, camera: FloorCamera) -> None:
        """Begin to listen."""
        self._node, self._name, self._position = node, name, camera.position_m
        self._buffer = node.transforms.buffer
        self._since_ns: int | None = None
        self._num_senders = 0
        self._is_settled = False
        node.time.on_look(self._look)

    def _look(self) -> None:
        if self._is_settled:
            return
        now = self._node.time.steady_ns()
        num_senders = self._node.count_publishers("/tf_static")
        if self._since_ns is None or num_senders != self._num_senders:
            self._since_ns, self._num_senders = now, num_senders  # its latched message is coming
        if self._buffer.can_transform(self._node.frames.base, self._name):
            self._is_settled = True
        elif now - self._since_ns >= _WAIT_NS:
            self._send()

    def _send(self) -> None:
        self._is_settled = True
        place = Transform3.from_parts((*self._position, 0.0), (0.0, 0.0, 0.0, 1.0))
        stamp_ns = stamp_to_ns(self._node.get_clock().now().to_msg())
        self._broadcaster = StaticTransformBroadcaster(self._node)
        self._broadcaster.send(self._node.frames.base, self._name, stamp_ns, place)
        at = ", ".join(f"{v:g}" for v in np.asarray(self._position))
        self._node.get_logger().info(
            f"nobody sends {self._node.frames.base} -> {self._name}: sent from the camera's YAML, "
            f"at ({at}) m"
        )
