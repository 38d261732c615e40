"""What every node that takes stereo pairs is told of them; defaults stand here alone."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class StereoPairsConfig:
    """Which pairs there are, and how their images come."""

    pairs: tuple[str, ...] = param(
        ("front", "rear"), "Names of the pairs: topics are stereo/<pair>/...; one alone will do.",
        read_only=True,
    )  # fmt: skip
    image_transport: str = param(
        "raw", "Whether images come as Image or, on <topic>/compressed, as CompressedImage.",
        choices=("raw", "compressed"), read_only=True,
    )  # fmt: skip

    image_timeout_s: float = param(
        1.0, "Silence of a pair's images or disparities allowed.", unit="s", gt=0.0
    )
    wait_s: float = param(
        0.2, "How long what has one stamp waits for the rest of it.", unit="s", gt=0.0, le=10.0,
        read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if not self.pairs or len(set(self.pairs)) < len(self.pairs):
            raise ValueError(f"pairs must be different names, at least one, got {self.pairs}")
