"""What every node of ours has: frames, transforms, time, diagnostics, and a checked start."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from rclpy.node import Node

from floornav_common.frames import FrameConfig
from floornav_common.ros.clock import NodeTime
from floornav_common.ros.parameters import declare_config, refuse_unknown_parameters
from floornav_common.ros.transforms import TransformListener


class FloornavNode(Node):
    """A plain node; each part exists from its first use on.

    Args:
        name: Node name.
        kwargs: As rclpy's Node.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        """Create the node and start watching its clock."""
        super().__init__(name, **kwargs)
        self.time = NodeTime(self)
        self._frames: FrameConfig | None = None

    @property
    def frames(self) -> FrameConfig:
        """Frames and transform times, as parameters."""
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
        """End the construction: refuse unknown parameters, compile, and say ready.

        Raises:
            ParameterError: If a parameter was given that nothing declared.
        """
        refuse_unknown_parameters(self)
        if compile_kernels is not None:
            compile_kernels()
        self.get_logger().info("ready")

    def _set_frames(self, frames: FrameConfig) -> None:
        self._frames = frames
