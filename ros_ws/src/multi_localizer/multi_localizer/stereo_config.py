"""Every value of the stereo matchers; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate

METHODS = ("interval_dp", "monotone_dp", "bm", "sgbm")
"""Names of the matchers, as `StereoMatcherConfig.method` takes them."""


@dataclass(frozen=True, kw_only=True)
class StereoMatcherConfig:
    """How the images of a pair are matched. Costs are in units of the matching cost, 0 to 184."""

    method: str = param(
        "interval_dp", "Interval DP of the stereo paper, monotone DP, or OpenCV's StereoBM and "
        "StereoSGBM.", choices=METHODS, read_only=True,
    )  # fmt: skip
    num_disparities: int = param(
        64, "Disparities searched, from 0 up; a multiple of 16.", unit="px", ge=16, le=256,
        read_only=True,
    )  # fmt: skip
    support_rows: int = param(
        5, "The costs of so many rows are averaged; odd.", unit="px", ge=1, le=31
    )
    cut_change: int = param(
        15, "interval_dp: change of color from a column to the next that ends an interval, of 255.",
        ge=1, le=255,
    )  # fmt: skip
    stretch: int = param(
        50, "interval_dp: cost where the disparity changes by 1 from one column to the next.",
        ge=0, le=10000,
    )  # fmt: skip
    hidden_score: float = param(
        60.0, "interval_dp: an interval that costs more a column is hidden from the right camera.",
        ge=0.0, le=255.0,
    )  # fmt: skip
    occlusion: int = param(60, "monotone_dp: cost of a pixel that has no partner.", ge=0, le=10000)

    def __post_init__(self) -> None:
        validate(self)
        if self.num_disparities % 16 != 0:
            raise ValueError(
                f"num_disparities must be a multiple of 16, got {self.num_disparities}"
            )
        if self.support_rows % 2 == 0:
            raise ValueError(f"support_rows must be odd, got {self.support_rows}")
