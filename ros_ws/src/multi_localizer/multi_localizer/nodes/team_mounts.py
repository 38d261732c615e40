"""Where each robot's camera sits, from static transforms: one tree for all, or one a robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import TF_STATIC_QOS, create_subscription
from floornav_common.ros.transforms import tf_message_type
from floornav_common.se2 import SE2
from floornav_common.transform_buffer import TransformBuffer, TransformUnavailable


class CameraMounts:
    """Listens to `/tf_static` and to `/<namespace>/tf_static` of each robot.

    A frame with a prefix (`r2/omni_camera_floor`) is looked for in the tree that all share, one
    without only in the robot's own: there all robots' frames have the same names. The tree that
    this node hears as `/tf_static` is also its own robot's.

    Args:
        node: The node; `base_frame` is the robots' frame, without prefixes.
        team: Namespaces.
        own: That of this robot; "" if it is none of them.
    """

    def __init__(self, node: FloornavNode, team: Sequence[str], own: str) -> None:
        """Subscribe."""
        self._base, self._own = node.frames.base_frame, own
        self._shared = TransformBuffer()
        self._trees = {name: TransformBuffer() for name in team}
        message = tf_message_type()
        if message is None:
            return
        self._subscriptions = [
            create_subscription(node, message, topic, _store_in(tree, node), TF_STATIC_QOS)
            for topic, tree in self._topics(team)
        ]

    def find(self, name: str, frame_id: str) -> SE2 | None:
        """Return the frame of a robot's bearings in its base; None while nobody has said."""
        prefix = frame_id.rpartition("/")[0]
        base = f"{prefix}/{self._base}" if prefix else self._base
        trees = [self._trees[name]]
        if prefix or name == self._own:
            trees.append(self._shared)
        for tree in trees:
            if frame_id == base:
                return SE2.identity()
            if tree.can_transform(base, frame_id):
                return tree.lookup(base, frame_id).to_se2()
        return None

    def missing_text(self, frame_id: str, name: str) -> str:
        """Return what is missing, in words."""
        return (
            f"where its camera sits is not known: no transform from '{frame_id}' to its "
            f"'{self._base}' on /tf_static or /{name}/tf_static"
        )

    def _topics(self, team: Sequence[str]) -> list[tuple[str, TransformBuffer]]:
        own = [(f"/{name}/tf_static", self._trees[name]) for name in team]
        return [("/tf_static", self._shared), *own]


def _store_in(tree: TransformBuffer, node: FloornavNode) -> Callable[[Any], None]:
    def store(msg: Any) -> None:
        for each in msg.transforms:
            t, q = each.transform.translation, each.transform.rotation
            try:
                tree.set_transform(
                    each.header.frame_id, each.child_frame_id, stamp_to_ns(each.header.stamp),
                    (t.x, t.y, t.z), (q.x, q.y, q.z, q.w), is_static=True,
                )  # fmt: skip
            except (ValueError, TransformUnavailable) as error:
                node.get_logger().warning(f"transform ignored: {error}")

    return store
