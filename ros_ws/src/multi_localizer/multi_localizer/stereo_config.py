"""Every value of the stereo matchers; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate

METHODS = ("interval_dp", "monotone_dp", "ours", "bm", "sgbm")
"""Names of the matchers, as `StereoMatcherConfig.method` takes them."""


@dataclass(frozen=True, kw_only=True)
class StereoMatcherConfig:
    """How the images of a pair are matched. Costs are in units of the matching cost, 0 to 90."""

    method: str = param(
        "ours", "Interval DP of the stereo paper, monotone DP, the best of ours, or OpenCV's "
        "StereoBM and StereoSGBM.", choices=METHODS, read_only=True,
    )  # fmt: skip
    num_disparities: int = param(
        64, "Disparities searched, from 0 up; a multiple of 16.", unit="px", ge=16, le=256,
        read_only=True,
    )  # fmt: skip
    support_rows: int = param(
        9,
        "interval_dp, monotone_dp: the costs of so many rows are averaged; odd.",
        unit="px",
        ge=1,
        le=31,
    )
    cut_median_px: int = param(
        5, "interval_dp: side of the median window that takes texture away before intervals are "
        "cut; odd, 1 for none.", unit="px", ge=1, le=15,
    )  # fmt: skip
    cut_change: int = param(
        20, "interval_dp: change of color from a column to the next that ends an interval, of 255.",
        ge=1, le=255,
    )  # fmt: skip
    stretch: int = param(
        20, "interval_dp: cost where the disparity changes by 1 from one column to the next.",
        ge=0, le=10000,
    )  # fmt: skip
    hidden_score: float = param(
        30.0, "interval_dp: an interval that costs more a column is hidden from the right camera.",
        ge=0.0, le=255.0,
    )  # fmt: skip
    monotone_step: int = param(
        30, "monotone_dp: price of a step along one of the two rows alone.", ge=0, le=10000
    )
    small_step: int = param(
        30, "ours: price of a disparity that changes by 1 from a pixel to the next.", ge=0, le=165
    )
    large_step: int = param(
        90, "ours: price of a disparity that changes by more, where the gray is even.", ge=1,
        le=165,
    )  # fmt: skip
    gray_scale: float = param(30.0, "ours: change of gray that halves large_step, of 255.", gt=0.0)
    max_difference: int = param(
        1, "ours: left pixels that want one right pixel may differ by so much, or are holes.",
        unit="px", ge=0, le=256,
    )  # fmt: skip
    island_px: int = param(
        200, "ours: pieces of fewer pixels are holes.", unit="px", ge=0, le=100000
    )
    median_px: int = param(
        5, "ours: side of the median window, 1 (none), 3 or 5.", unit="px", ge=1, le=5
    )
    mean_px: int = param(
        7, "ours: side of the square that neighbors of nearly the same disparity are averaged "
        "over; 1 for none.", unit="px", ge=1, le=31,
    )  # fmt: skip
    fill_holes: bool = param(
        False, "ours: holes take the farther one of the disparities beside them, which is a guess; "
        "false: no value.",
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if self.num_disparities % 16 != 0:
            raise ValueError(
                f"num_disparities must be a multiple of 16, got {self.num_disparities}"
            )
        for name in ("support_rows", "cut_median_px", "median_px", "mean_px"):
            if getattr(self, name) % 2 == 0:
                raise ValueError(f"{name} must be odd, got {getattr(self, name)}")
        if self.large_step < self.small_step:
            raise ValueError(
                f"large_step must be at least small_step, got {self.large_step} and "
                f"{self.small_step}"
            )
