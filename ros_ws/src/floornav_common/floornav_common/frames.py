"""The names of the frames a node works in, and how long it waits for them (REP 105)."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class FrameConfig:
    """Frames and transforms of one robot.

    `frame_prefix` stands before the three frames named here, never before a frame id that came in
    a message: `map`, `odom` and `base` are the full names.
    """

    map_frame: str = param("map", "Fixed frame of the map, without the prefix.", read_only=True)
    odom_frame: str = param("odom", "Frame of the odometry, without the prefix.", read_only=True)
    base_frame: str = param("base_link", "Frame of the robot, without the prefix.", read_only=True)
    frame_prefix: str = param(
        "", "Put before map_frame, odom_frame and base_frame, such as `r2/`.", read_only=True
    )
    transform_timeout_s: float = param(
        0.5, "How long stamped input waits for its transform.", unit="s", ge=0.0, le=10.0
    )
    transform_tolerance_s: float = param(
        0.1, "How far ahead map->odom is stamped.", unit="s", ge=0.0, le=10.0
    )
    tf_period_s: float = param(
        0.05, "How often map->odom is sent again.", unit="s", gt=0.0, le=10.0, read_only=True
    )

    def __post_init__(self) -> None:
        """Refuse values outside their ranges and empty frames."""
        validate(self)
        for name in ("map_frame", "odom_frame", "base_frame"):
            if not getattr(self, name).strip("/"):
                raise ValueError(f"{name} must not be empty, got {getattr(self, name)!r}")

    @property
    def map(self) -> str:
        """Full name of the map frame."""
        return self._full(self.map_frame)

    @property
    def odom(self) -> str:
        """Full name of the odometry frame."""
        return self._full(self.odom_frame)

    @property
    def base(self) -> str:
        """Full name of the robot's frame."""
        return self._full(self.base_frame)

    def _full(self, frame: str) -> str:
        return (self.frame_prefix + frame).lstrip("/")
