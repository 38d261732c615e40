"""What speaks against the pose that TF gives: two sources of one transform that disagree."""

from __future__ import annotations

import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray

from floornav_common.ros.diagnostics import ERROR
from floornav_common.ros.messages import stamp_to_ns, transform_from_msg
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_subscription
from floornav_common.ros.transform_owner import owned_part
from floornav_common.transform_errors import TransformUnavailable
from floornav_common.transform_rivals import BackAndForth

_SAID_NS = 3_000_000_000  # a status is said once a second


class PoseDisputes:
    """Watches map->odom and odom->base, on TF itself and by what localizers of ours say of it.

    TF shows two sources that both go on sending. A localizer of ours falls silent for the other's
    sake and says so as an ERROR on /diagnostics; what it maps is then not in the other's frame, so
    while it says so nobody knows where the robot is.
    """

    def __init__(self, node: FloornavNode) -> None:
        """Start listening."""
        self._node, frames = node, node.frames
        self._samples = {frames.odom: BackAndForth(), frames.base: BackAndForth()}
        self._part = owned_part(frames.map, frames.odom)
        self._said: dict[str, tuple[int, str]] = {}
        node.transforms.on_sample(self._on_sample)
        node.transforms.on_restart(self._clear)
        create_subscription(
            node, DiagnosticArray, "/diagnostics", self._on_diagnostics, RELIABLE_QOS
        )

    def reason(self, frame: str) -> str:
        """Return why the robot's pose in a frame cannot be believed; "" for nothing."""
        chain = self._chain(frame)
        for parent, child in chain:
            samples = self._samples.get(child)
            width = samples.width(self._robot_in(child)) if samples is not None else 0.0
            if width:
                what = f"'{parent}' to '{child}' jumps to and fro by {width:.1f} m or rad"
                return f"{what}: two owners of it?"
        since_ns = self._node.time.steady_ns() - _SAID_NS
        said = [text for at_ns, text in self._said.values() if at_ns > since_ns]
        is_by_map = any(child == self._node.frames.odom for _, child in chain)
        return said[0] if said and is_by_map else ""

    def _chain(self, frame: str) -> list[tuple[str, str]]:
        """Return the transforms (parent, child) from the robot up to a frame."""
        chain: list[tuple[str, str]] = []
        child = self._node.frames.base
        while child != frame and (parent := self._node.transforms.buffer.parent_of(child)):
            chain.append((parent, child))
            child = parent
        return chain

    def _robot_in(self, frame: str) -> tuple[float, float]:
        """Return where the robot is in a frame above it; its origin where that is not known."""
        buffer, base = self._node.transforms.buffer, self._node.frames.base
        try:
            place = buffer.lookup(frame, base).to_se2()
        except (TransformUnavailable, ValueError):
            return 0.0, 0.0
        return place.x, place.y

    def _clear(self) -> None:
        for samples in self._samples.values():
            samples.clear()

    def _on_sample(self, stamped: Any) -> None:
        samples = self._samples.get(stamped.child_frame_id.lstrip("/"))
        t, q = stamped.transform.translation, stamped.transform.rotation
        if samples is None or not math.isfinite(t.x + t.y + q.x + q.y + q.z + q.w):
            return
        try:
            pose = transform_from_msg(stamped.transform).to_se2()
        except ValueError:  # the buffer refuses it too, and says so
            return
        samples.take(stamp_to_ns(stamped.header.stamp), pose)

    def _on_diagnostics(self, msg: Any) -> None:
        for status in msg.status:
            who, _, part = status.name.partition(": ")
            space = who.rpartition("/")[0] or "/"
            if part != self._part or space != self._node.get_namespace():
                continue
            self._said.pop(who, None)
            if status.level == ERROR:
                self._said[who] = self._node.time.steady_ns(), f"{who}: {status.message}"
