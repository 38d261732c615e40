"""The one transform a localizer owns: sent only while nobody else sends it (DESIGN.md).

TF messages carry no author and rclpy on Jazzy hands out no publisher id, so samples that come back
are compared with those we sent; who the others may be is read from the list of /tf publishers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from floornav_common.ros.diagnostics import ERROR, OK, Status
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import publisher_names
from floornav_common.ros.transforms import TransformBroadcaster
from floornav_common.transform3 import Transform3
from floornav_common.transform_buffer import clean_frame
from floornav_common.transform_owner import SentTransforms

if TYPE_CHECKING:
    from floornav_common.ros.node import FloornavNode

_LISTEN_FIRST_NS = 1_000_000_000
_LEARN_NAMES_NS = 2_000_000_000  # the graph hears names a moment after the first message
_SILENT_NS = 10_000_000_000  # who sends nothing for so long is gone, whatever its name was


def owned_part(parent: str, child: str) -> str:
    """Return the part of the diagnostics that says whether a transform has another source."""
    return f"transform {parent} to {child}"


class TransformOwner:
    """Sends `parent -> child` unless somebody else does; part `transform <child>` on diagnostics.

    It listens for a second before the first send. Once another source was heard nothing is sent
    until nothing came for ten seconds, or for one if one of those who may be it has left, and then
    again after a second of listening.

    Args:
        node: The node.
        parent: Parent frame, full name.
        child: Child frame, full name.
    """

    def __init__(self, node: FloornavNode, parent: str, child: str) -> None:
        """Start listening."""
        self._node = node
        self._sent = SentTransforms(clean_frame(parent), clean_frame(child))
        self._broadcaster = TransformBroadcaster(node)
        self._listening_since_ns = node.time.steady_ns()
        self._others: set[str] | None = None
        self._contested_at_ns = self._foreign_at_ns = 0
        self._has_said = False
        node.transforms.on_sample(self._on_sample)
        node.time.on_look(self._look)
        node.diagnostics.add(owned_part(parent, child), self.status)

    @property
    def other_publishers(self) -> list[str]:
        """Full names of the nodes of which one sends our transform; [] if none does."""
        return sorted(self._others or ())

    @property
    def is_contested(self) -> bool:
        """Whether somebody else sends our transform."""
        return self._others is not None

    def send(self, stamp_ns: int, transform: Transform3) -> bool:
        """Send a sample; False if it was not, for another source or for listening still."""
        listened_ns = self._node.time.steady_ns() - self._listening_since_ns
        if self.is_contested or listened_ns < _LISTEN_FIRST_NS:
            return False
        x, y, z = transform.translation.tolist()
        self._sent.note(stamp_ns, (x, y, z))
        self._broadcaster.send(self._sent.parent, self._sent.child, stamp_ns, transform)
        return True

    def status(self) -> Status:
        """Return OK, or ERROR that names who may be the other source."""
        if not self.is_contested:
            return Status(OK, "no other source")
        names = " or ".join(self.other_publishers) or "a node that has not given its name"
        what = f"'{self._sent.parent}' to '{self._sent.child}'"
        return Status(ERROR, f"{what} is also published by {names}: not published here")

    def _on_sample(self, stamped: Any) -> None:
        t = stamped.transform.translation
        child, stamp_ns = stamped.child_frame_id.lstrip("/"), stamp_to_ns(stamped.header.stamp)
        if not self._sent.is_foreign(child, stamp_ns, (t.x, t.y, t.z)):
            return
        self._foreign_at_ns = self._node.time.steady_ns()
        if self.is_contested:
            return
        self._others, self._has_said = set(), False
        self._contested_at_ns = self._node.time.steady_ns()
        self._look()

    def _look(self) -> None:
        if self._others is None:
            return
        steady_ns, there = self._node.time.steady_ns(), set(self._publishers())
        is_learning = steady_ns - self._contested_at_ns < _LEARN_NAMES_NS
        if is_learning:
            self._others |= there
        if not self._has_said and (self._others or not is_learning):
            self._has_said = True
            self._node.get_logger().error(self.status().message)
        has_left = not (self._others and self._others <= there)
        # What one who left sent last may come after its name is gone.
        limit_ns = _LISTEN_FIRST_NS if has_left else _SILENT_NS
        if not is_learning and steady_ns - self._foreign_at_ns > limit_ns:
            self._others, self._listening_since_ns = None, steady_ns

    def _publishers(self) -> list[str]:
        return publisher_names(self._node, self._node.resolve_topic_name("/tf"))
