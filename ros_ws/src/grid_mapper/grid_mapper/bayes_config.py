"""What can be set of the Bayesian fusion of laser and sonars."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class BayesConfig:
    """Panes from echoes that the laser does not explain, integrated over time."""

    range_tolerance_m: float = param(
        0.02, "An echo lies on a pane's line when its range fits this well, ...", unit="m", gt=0.0
    )
    range_tolerance_share: float = param(
        0.01, "... and this share of the range beside.", unit="m/m", ge=0.0
    )
    explained_m: float = param(
        0.06,
        "An echo this near the range of something opaque that the laser sees in the cone says "
        "nothing of glass.",
        unit="m", gt=0.0,
    )  # fmt: skip
    seed_views: float = param(
        3.0, "A pane begins where an echo fits a line with this many others.", unit="echoes", ge=1.0
    )
    pane_views: float = param(6.0, "A pane needs this many echoes, ...", unit="echoes", ge=2.0)
    trusted_m: float = param(
        2.0,
        "From this range on an echo counts for less, by 1/r^2 (eq. 1), and so does a miss; misses "
        "from beyond it count together as one at most.",
        unit="m", gt=0.0,
    )  # fmt: skip
    critical_rad: float = param(
        0.26,
        "How far from its normal glass still answers a sonar (about 15 degrees at 50 kHz). "
        "Set it for your sonars: cones that heard nothing speak against glass only where it must "
        "have answered.",
        unit="rad", gt=0.0, lt=pi / 2.0,
    )  # fmt: skip
    critical_sd_rad: float = param(
        0.035,
        "Standard deviation of that angle; a miss counts within the angle less two of them.",
        unit="rad", ge=0.0,
    )  # fmt: skip
    pane_baseline_m: float = param(0.2, "... heard from places this far apart.", unit="m", gt=0.0)
    max_bay_m: float = param(
        1.6,
        "A pane is carried on to the next post or wall, or over a gap in what was heard of it, "
        "over at most this length without contradiction.",
        unit="m", ge=0.0,
    )  # fmt: skip
    line_reach_m: float = param(
        10.0,
        "A pane's line is searched so far beyond its echoes for more bays of glass between posts: "
        "walls go on. There beams that dirt sent back are all that tells of glass.",
        unit="m", ge=0.0,
    )  # fmt: skip
    echo_log_odds: float = param(0.9, "What an echo adds to a stretch of pane.", gt=0.0)
    miss_log_odds: float = param(
        -1.8, "What a cone that met the stretch squarely and heard nothing there adds.", lt=0.0
    )
    hit_log_odds: float = param(
        0.9, "What beams add that came back from the stretch, though most cross it.", ge=0.0
    )
    min_log_odds: float = param(0.8, "A stretch believed more than this is glass.", gt=0.0)
    moved_misses: float = param(
        3.0,
        "This many misses newer than the last echo clear a stretch; misses older than its newest "
        "echoes, this many, are forgotten.",
        unit="misses", gt=0.0,
    )  # fmt: skip
    max_repeats: float = param(
        3.0, "An echo heard again from the same place counts at most this often.",
        unit="echoes", ge=1.0,
    )  # fmt: skip
    weak_share: float = param(
        0.5,
        "Share of a bay between two posts on a pane's line from which echoes came that the posts "
        "explain as well; from it on the bay is glass, unless a miss says that it is open.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    view_m: float = param(
        0.05, "Readings from places nearer than this, with about the same direction, are one view.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    view_rad: float = param(
        pi / 32.0, "Readings whose directions differ less than this are one view.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    max_views: int = param(200_000, "Views kept; then the oldest goes.", ge=1000, read_only=True)
    half_thickness_m: float = param(
        0.0375, "Cells whose centers lie this near a pane's line are occupied.", unit="m", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
