"""Settings of the methods `vff`, `vfh` and `vfh_plus`, which share one certainty window."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class HistogramConfig:
    """Settings of `vff`, `vfh` and `vfh_plus` (Borenstein and Koren; Ulrich and Borenstein)."""

    window_m: float = param(
        2.0, "Radius of the window around the robot; what is farther does not count.",
        unit="m", gt=0.1, le=20.0,
    )  # fmt: skip
    cell_m: float = param(0.05, "Edge of a cell of the window.", unit="m", ge=0.01, le=1.0)
    hit_gain: int = param(
        5, "What a scan that ends in a cell adds to its certainty, 0 to 15; 3 was published for "
        "sonars.", ge=1, le=15,
    )  # fmt: skip
    miss_loss: int = param(
        5, "What a scan that sees past a cell takes from its certainty; 1 was published for "
        "sonars.", ge=1, le=15,
    )  # fmt: skip
    num_sectors: int = param(72, "Sectors of the polar histogram.", ge=8, le=720)
    near_weight: float = param(
        3.0, "How much a cell beside the robot counts beside one at the window's border (a).",
        ge=1.0, le=100.0,
    )  # fmt: skip
    threshold_low: float = param(
        0.3, "`vfh_plus`: a sector below this is open (tau_low); 1 is one sure cell at the "
        "window's border.", gt=0.0,
    )  # fmt: skip
    threshold_high: float = param(
        0.6, "`vfh_plus`: a sector above this is blocked (tau_high).", gt=0.0
    )
    wide_sectors: int = param(
        6, "Openings of more sectors than this are wide: it keeps half as many from their sides "
        "(s_max); `vfh_plus`; 16 was published.", ge=1, le=360,
    )  # fmt: skip
    goal_weight: float = param(5.0, "`vfh_plus`: cost of an angle to the goal (mu_1).", ge=0.0)
    heading_weight: float = param(
        2.0, "`vfh_plus`: cost of an angle to where the robot moves (mu_2).", ge=0.0
    )
    steady_weight: float = param(
        2.0, "`vfh_plus`: cost of an angle to what was chosen last (mu_3).", ge=0.0
    )
    vfh_smoothing: int = param(
        5, "`vfh`: sectors to each side that the histogram is smoothed over (l).", ge=0, le=36
    )
    vfh_wide_sectors: int = param(
        18, "`vfh`: most sectors of a valley that it steers for the middle of (s_max).",
        ge=1, le=360,
    )  # fmt: skip
    vfh_threshold: float = param(
        0.7, "`vfh`: a sector below this density is open; 1 is one sure cell at the robot.", gt=0.0
    )
    vfh_full_stop: float = param(
        10.0, "`vfh`: density ahead at which it goes slowest (h_m).", gt=0.0
    )
    vff_repulsion: float = param(
        8.0, "`vff`: push of a square meter of sure cells at 1 m beside the goal's pull "
        "(F_cr / F_ct).", ge=0.0,
    )  # fmt: skip
    least_speed: float = param(
        0.2, "`vff`, `vfh`: share of its speed that is kept while slowed (V_min).", ge=0.0, le=1.0
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.threshold_low > self.threshold_high:
            raise ValueError(
                f"threshold_low must be <= threshold_high = {self.threshold_high}, "
                f"got {self.threshold_low}"
            )
        if self.window_m < 4.0 * self.cell_m:
            raise ValueError(
                f"window_m must be >= 4 cell_m = {4.0 * self.cell_m}, got {self.window_m}"
            )
