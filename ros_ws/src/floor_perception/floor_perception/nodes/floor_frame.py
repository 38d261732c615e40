"""The static transform to the frame below the camera, unless someone else sends it."""

from __future__ import annotations

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.transform3 import Transform3

_SAME_M = 1e-3


class FloorFrame:
    """Sends base_frame -> floor_frame once /tf_static has been quiet about it for a while.

    A robot description that has the frame is listened to; where there is none, the camera's YAML
    says where the camera is. Quiet is counted anew from each sender that comes: its latched message
    comes later than itself. On a busy machine both may take 3 s, the time after which DDS says
    again what was lost.

    Args:
        node: The node.
        name: Full name of the frame.
        camera: Where the camera is over the robot.
        wait_s: How long to listen.
    """

    def __init__(self, node: FloornavNode, name: str, camera: FloorCamera, wait_s: float) -> None:
        """Begin to listen."""
        self._node, self._name, self._position = node, name, camera.position_m
        self._wait_ns = int(1e9 * wait_s)
        self._buffer = node.transforms.buffer
        self._since_ns: int | None = None
        self._num_senders = 0
        self._is_settled = False
        self._sent: Transform3 | None = None
        node.time.on_look(self._look)

    def _look(self) -> None:
        if self._is_settled:
            self._look_for_another()
            return
        now = self._node.time.steady_ns()
        num_senders = self._node.count_publishers("/tf_static")
        if self._since_ns is None or num_senders > self._num_senders:
            self._since_ns = now
        self._num_senders = num_senders
        if self._buffer.can_transform(self._node.frames.base, self._name):
            self._is_settled = True
            self._say("is sent by the robot's description: the camera's YAML does not place it")
        elif now - self._since_ns >= self._wait_ns:
            self._send()

    def _send(self) -> None:
        self._is_settled = True
        place = Transform3.from_parts((*self._position, 0.0), (0.0, 0.0, 0.0, 1.0))
        stamp_ns = stamp_to_ns(self._node.get_clock().now().to_msg())
        self._broadcaster = StaticTransformBroadcaster(self._node)
        self._broadcaster.send(self._node.frames.base, self._name, stamp_ns, place)
        self._sent = place
        at = ", ".join(f"{v:g}" for v in np.asarray(self._position))
        self._say(f"is sent by nobody: now from the camera's YAML, at ({at}) m")

    def _look_for_another(self) -> None:
        """Warn once if the frame that was sent has been put elsewhere: two senders, last wins."""
        base = self._node.frames.base
        if self._sent is None or not self._buffer.can_transform(base, self._name):
            return
        place = self._buffer.lookup(base, self._name).translation
        if np.abs(place - self._sent.translation).max() <= _SAME_M:
            return
        self._sent = None
        at = ", ".join(f"{v:g}" for v in place)
        self._node.get_logger().warning(
            f"{base} -> {self._name} is also sent by somebody else, at ({at}) m: which one a node "
            "believes is chance; start the robot's description before this node"
        )

    def _say(self, what: str) -> None:
        self._node.get_logger().info(f"{self._node.frames.base} -> {self._name} {what}")
