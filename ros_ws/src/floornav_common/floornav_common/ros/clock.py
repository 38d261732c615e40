"""A node's two clocks, watched by DESIGN's rule of time."""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.clock import Clock, ClockType, JumpThreshold
from rclpy.duration import Duration
from rclpy.node import Node

from floornav_common.time_watch import TimeWatch

_LOOK_PERIOD_S = 0.1


class NodeTime(TimeWatch):
    """`TimeWatch` fed by a node: looks ten times a second and at every jump of its clock.

    Args:
        node: The node; `use_sim_time` decides which clock counts.
    """

    def __init__(self, node: Node) -> None:
        """Start looking."""
        super().__init__()
        self._clock = node.get_clock()
        self.steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.look()
        threshold = JumpThreshold(
            min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=True
        )
        self._jumps = self._clock.create_jump_callback(
            threshold, post_callback=lambda _jump: self.look()
        )
        self._on_look: list[Callable[[], None]] = []
        self._timer = node.create_timer(_LOOK_PERIOD_S, self._on_timer, clock=self.steady_clock)

    def on_look(self, callback: Callable[[], None]) -> None:
        """Call back ten times a second of the steady clock, after a look at the clocks."""
        self._on_look.append(callback)

    @staticmethod
    def steady_ns() -> int:
        """Return the steady clock, ns."""
        return time.monotonic_ns()

    def look(self) -> None:
        """Read both clocks."""
        is_simulated = self._clock.ros_time_is_active
        self.update(self.steady_ns(), self._clock.now().nanoseconds if is_simulated else None)

    def read_ns(self) -> int:
        """Look, and return the time silence is counted on, ns."""
        self.look()
        return self.now_ns

    def _on_timer(self) -> None:
        self.look()
        for callback in self._on_look:
            callback()
