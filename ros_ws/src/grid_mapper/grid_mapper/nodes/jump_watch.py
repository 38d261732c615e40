"""Whether the pose that TF gives goes on, or jumped."""

from __future__ import annotations

from collections.abc import Callable

from floornav_common.ros.node import FloornavNode
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.pose_jumps import Jump, PoseJumps

JUMP_SHOWN_NS = 10_000_000_000


class JumpWatch:
    """Holds each pose against odometry, and says so when it jumped.

    Args:
        node: The node.
        config: Limits; to be replaced when they change.
        warn: Called with what to say, throttled.

    Attributes:
        config: As given.
        num_jumps: How often the pose jumped.
    """

    def __init__(
        self, node: FloornavNode, config: GridMapperNodeConfig, warn: Callable[[str], None]
    ) -> None:
        self.config = config
        self._node, self._warn = node, warn
        self._jumps = PoseJumps()
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self.num_jumps = 0
        self._jumped: tuple[int, Jump] | None = None
        self.restart()

    def restart(self) -> None:
        """Go on from stamps that jumped back."""
        self._is_jumping = False
        self._jumps.clear()

    def is_steady(self, stamp_ns: int, T_map_base: SE2) -> bool:
        """Tell whether the pose goes on from the last; say so if it jumped."""
        jump = self._jumps.jump(stamp_ns, T_map_base, self._odometry(stamp_ns))
        was_jumping = self._is_jumping
        is_far = jump.distance > self.config.max_pose_jump_m
        self._is_jumping = is_far or jump.turn > self.config.max_pose_jump_rad
        if not self._is_jumping:
            return True
        self.num_jumps += not was_jumping
        self._jumped = (self._node.time.steady_ns(), jump)
        self._warn(
            f"the given pose jumped by {_words(jump)}: not mapped at the jump; what was mapped "
            "before may lie elsewhere now, ~/reset forgets it"
        )
        return False

    @property
    def late_jump(self) -> str:
        """The jump of the last ten seconds in words; "" for none."""
        if self._jumped is None:
            return ""
        at_ns, jump = self._jumped
        return _words(jump) if self._node.time.steady_ns() - at_ns < JUMP_SHOWN_NS else ""

    def _odometry(self, stamp_ns: int) -> SE2 | None:
        frames = self._node.frames
        try:
            return self._node.transforms.buffer.lookup(frames.odom, frames.base, stamp_ns).to_se2()
        except (TransformUnavailable, ValueError):
            return None


def _words(jump: Jump) -> str:
    return f"{jump.distance:.2f} m and {jump.turn:.2f} rad"
