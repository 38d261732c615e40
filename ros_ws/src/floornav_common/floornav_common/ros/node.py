"""What every node of ours has: frames, transforms, time, diagnostics, and a checked start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rclpy.node import Node

from floornav_common.config import param, validate
from floornav_common.frames import FrameConfig
from floornav_common.kernels import compile_once
from floornav_common.ros.clock import NodeTime
from floornav_common.ros.diagnostics import ERROR, OK, Diagnostics, Status
from floornav_common.ros.parameters import (
    ParameterError,
    declare_config,
    refuse_unknown_parameters,
)
from floornav_common.ros.threads import limit_threads
from floornav_common.ros.transforms import TransformListener
from floornav_common.ros.type_watch import TypeWatch


@dataclass(frozen=True, kw_only=True)
class ProcessConfig:
    """How much of the machine a node takes."""

    num_threads: int = param(1, "Threads for OpenCV, BLAS and numba.", ge=1, le=256, read_only=True)

    def __post_init__(self) -> None:
        """Refuse values outside their ranges."""
        validate(self)


class FloornavNode(Node):
    """A plain node; frames and transforms exist from their first use on.

    Args:
        name: Node name.
        kwargs: As rclpy's Node.

    Attributes:
        time: Both clocks by the rule of time.
        diagnostics: What this node says of itself.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        """Create the node and start watching its clock."""
        super().__init__(name, **kwargs)
        limit_threads(declare_config(self, ProcessConfig).num_threads)
        self.time = NodeTime(self)
        self.diagnostics = Diagnostics(self)
        self.diagnostics.add("clock", self._clock_status)
        self.time.on_restart(self._say_restart)
        self._types = TypeWatch(self, self.diagnostics)
        self.time.on_look(lambda: self._types.look(self.time.steady_ns()))
        self.time.on_look(lambda: self.diagnostics.look(self.time.steady_ns()))
        self._frames: FrameConfig | None = None

    @property
    def frames(self) -> FrameConfig:
        """Frames and transform times; declared as parameters at the first use."""
        if self._frames is None:
            self._frames = declare_config(self, FrameConfig, on_change=self._set_frames)
        return self._frames

    @cached_property
    def transforms(self) -> TransformListener:
        """Listener on /tf and /tf_static."""
        listener = TransformListener(self, self.time.steady_ns)
        self.time.on_restart(listener.clear)
        return listener

    def ready(self, compile_kernels: Callable[[], None] | None = None) -> None:
        """End the construction: refuse unknown parameters, compile kernels, say ready.

        Raises:
            ParameterError: If a parameter was given that nothing declared, or what was given
                cannot be computed with.
        """
        refuse_unknown_parameters(self)
        if compile_kernels is not None:
            try:
                compile_once(compile_kernels, self.get_name(), self.get_logger().info)
            except ValueError as error:
                raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error
            limit_threads(self.get_parameter("num_threads").value)
        self.get_logger().info("ready")

    def _set_frames(self, frames: FrameConfig) -> None:
        self._frames = frames

    def _clock_status(self) -> Status:
        values = {"stands still for (s)": f"{self.time.stopped_for_ns / 1e9:.1f}"}
        if self.time.is_stopped:
            return Status(ERROR, "/clock stands still, or nobody publishes it", values)
        return Status(OK, "simulated time" if self.time.is_simulated else "steady time", values)

    def _say_restart(self) -> None:
        self.get_logger().warning("the clock jumped back: transforms, queues, deadlines cleared")
