"""Every value of the node stereo_matcher besides the matching; defaults stand here alone."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param
from multi_localizer.stereo_pairs_config import StereoPairsConfig


@dataclass(frozen=True, kw_only=True)
class StereoNodeConfig(StereoPairsConfig):
    """The node `stereo_matcher`."""

    image_timeout_s: float = param(1.0, "Silence of the images allowed.", unit="s", gt=0.0)
    wait_s: float = param(
        0.2, "How long an image waits for the other one of its stamp.", unit="s", gt=0.0, le=10.0,
        read_only=True,
    )  # fmt: skip
