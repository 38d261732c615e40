"""Every value of the pose from the floor's shape; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class FloorFitConfig:
    """How the border of the floor region is fitted to the plan."""

    border_sd_px: float = param(
        0.3, "Least deviation of a border pixel; the fit's own residuals say whether it is more.",
        unit="px", gt=0.0,
    )  # fmt: skip
    offset_sd_px: float = param(
        1.0, "How far the whole border may lie inside or outside: pixels that are part wall.",
        unit="px", ge=0.0,
    )  # fmt: skip
    wall_sd_px: float = param(
        0.08, "How far a single wall may lie off besides: its color, what a mirror is not like.",
        unit="px", ge=0.0,
    )  # fmt: skip
    coarse_m: float = param(
        0.07, "Where a pixel covers more of the floor than this, wall_sd_px grows in proportion: "
        "lines and shadows near the wall melt into it.", unit="m", gt=0.0,
    )  # fmt: skip
    gate_sd: float = param(
        3.5, "Border farther off than so many deviations is an obstacle's.", gt=1.0
    )
    max_sd_px: float = param(
        1.5, "Border pixels that scatter more than this do not belong to the plan.", unit="px",
        gt=0.0,
    )  # fmt: skip
    max_hidden: float = param(
        0.72, "No pose if more than this share of the directions shows no wall.", gt=0.0, lt=1.0
    )
    rival: float = param(
        0.7, "A second pose that so much of the border fits as well is a candidate too.",
        gt=0.0, le=1.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
