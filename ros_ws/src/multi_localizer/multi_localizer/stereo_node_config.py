"""Every value of the node stereo_matcher besides the matching; defaults stand here alone."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class StereoNodeConfig:
    """The node `stereo_matcher`."""

    pairs: tuple[str, ...] = param(
        ("front", "rear"), "Names of the pairs: topics are stereo/<pair>/<left, right>/...",
        read_only=True,
    )  # fmt: skip
    image_transport: str = param(
        "raw", "Whether images come as Image or, on <topic>/compressed, as CompressedImage.",
        choices=("raw", "compressed"), read_only=True,
    )  # fmt: skip
    image_timeout_s: float = param(1.0, "Silence of the images allowed.", unit="s", gt=0.0)
    wait_s: float = param(
        0.2, "How long an image waits for the other one of its stamp.", unit="s", gt=0.0, le=10.0,
        read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if not self.pairs or len(set(self.pairs)) < len(self.pairs):
            raise ValueError(f"pairs must be different names, at least one, got {self.pairs}")
