"""Settings of the node `live_view`, each with unit and range."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class LiveViewConfig:
    """Settings of the live view."""

    port: int = param(
        8765, "Port on this machine's loopback, 127.0.0.1; 0 takes a free one, named in the log.",
        ge=0, le=65535, read_only=True,
    )  # fmt: skip
    rate_hz: float = param(
        10.0, "The most often that scan, pose and all else are sent.", unit="Hz", gt=0.0, le=60.0,
        read_only=True,
    )  # fmt: skip
    image_rate_hz: float = param(
        2.0, "The most often that the picture is sent.", unit="Hz", gt=0.0, le=60.0
    )
    image_topic: str = param(
        "floor/overlay", "Image to show beside the map; empty for none.", read_only=True
    )
    image_width_px: int = param(480, "Wider images are made smaller.", unit="px", ge=16, le=4096)
    image_quality: int = param(70, "Quality of the JPEG sent.", unit="%", ge=1, le=100)
    sonar_topics: tuple[str, ...] = param(
        ("sonar",), "Topics of sonars, each for one or for several told apart by frame_id.",
        read_only=True,
    )  # fmt: skip
    outline_m: tuple[float, ...] = param(
        (), "Corners of the robot's outline in `base_frame`, x and y in turn; none: a circle of "
        "`radius_m`.", unit="m",
    )  # fmt: skip
    radius_m: float = param(0.2, "The robot as a circle.", unit="m", gt=0.0, le=100.0)
    silent_after_s: float = param(
        2.0,
        "An input that has come and is silent for longer is named.",
        unit="s",
        gt=0.0,
        le=3600.0,
    )

    def __post_init__(self) -> None:
        """Refuse values outside their ranges, and an outline that is none."""
        validate(self)
        if len(self.outline_m) % 2 or 0 < len(self.outline_m) < 6:
            raise ValueError(
                "outline_m must be x and y of three corners or more, got "
                f"{len(self.outline_m)} numbers"
            )

    def outline(self) -> np.ndarray:
        """Return the corners of the robot's outline in `base_frame`, shape (N, 2), m."""
        if self.outline_m:
            return np.array(self.outline_m, dtype=float).reshape(-1, 2)
        turn = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
        return self.radius_m * np.column_stack((np.cos(turn), np.sin(turn)))
