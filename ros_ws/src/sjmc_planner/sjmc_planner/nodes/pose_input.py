"""Where the robot is, by TF."""

from __future__ import annotations

from floornav_common.ros.node import FloornavNode
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable
from sjmc_planner.limited_motion import moved_by
from sjmc_planner.nodes.input_missing import InputMissing, age_of, fixed_frame
from sjmc_planner.nodes.pose_disputes import PoseDisputes
from sjmc_planner.planning import Velocity


class PoseInput:
    """The newest pose, carried forward to now, unless its sources contradict each other.

    Args:
        node: The node.
        timeout_s: How old it may be.
    """

    def __init__(self, node: FloornavNode, timeout_s: float) -> None:
        self._node, self._timeout_s = node, timeout_s
        self._disputes = PoseDisputes(node)

    def set_timeout(self, timeout_s: float) -> None:
        """Take another time limit."""
        self._timeout_s = timeout_s

    def pose(self, frame: str, velocity: Velocity) -> SE2:
        """Return the robot's pose in a frame, carried forward from the newest known.

        Raises:
            InputMissing: If it is not known or in dispute, older than the limit or as far ahead of
                now, or if the frame is the robot's own: a goal in it would move on with the robot.
        """
        buffer, base = self._node.transforms.buffer, self._node.frames.base
        try:
            T_frame_base = buffer.lookup(frame, base).to_se2()
            stamp_ns = buffer.newest_common_stamp(frame, base)
        except (TransformUnavailable, ValueError) as error:
            raise InputMissing(f"pose: {error}") from error
        if not stamp_ns:
            raise InputMissing(fixed_frame(frame))
        age = age_of(self._node, f"pose: '{frame}' to '{base}':", stamp_ns, self._timeout_s)
        if reason := self._disputes.reason(frame):
            raise InputMissing(f"pose: {reason}")
        return T_frame_base @ moved_by(velocity, age)
