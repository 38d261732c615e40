"""Every value of the mapper that can be set; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi

from floornav_common.config import param, validate
from floornav_common.scan import Scan
from grid_mapper.bayes_config import BayesConfig
from grid_mapper.loop_config import LoopConfig as LoopConfig
from grid_mapper.node_config import GridMapperNodeConfig as GridMapperNodeConfig
from grid_mapper.relocation_config import RelocationConfig as RelocationConfig
from grid_mapper.sonar_config import SonarConfig, SonarKeyConfig


@dataclass(frozen=True, kw_only=True)
class ScanMatcherConfig:
    """Scan-to-map ICP in the plane."""

    cell_m: float = param(
        0.25, "Edge of the cells that hold the map to match to.", unit="m", gt=0.0, le=2.0,
        read_only=True,
    )  # fmt: skip
    max_pair_distance_m: float = param(
        0.5, "Greatest distance of a point to the map cell it is paired with.", unit="m", gt=0.0
    )
    range_sigma_m: float = param(
        0.02, "Deviation of a point across the surface it lies on.", unit="m", gt=0.0
    )
    max_points_per_cell: int = param(
        50, "A map cell takes no more points than this: the first passes fix the map.", ge=1
    )
    max_iterations: int = param(30, "Gauss-Newton steps at most.", ge=1)
    stop_step_m: float = param(
        1e-4, "A step shorter than this (and as many radians) ends the iteration.", unit="m", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class LabelGridConfig:
    """The published label grid (glass paper, section 4)."""

    range_tolerance_m: float = param(0.05, "dr_L, half a wall's sampled depth.", unit="m", ge=0.0)
    beam_angle_rad: float = param(
        0.0,
        "alpha_L, opening of a beam's sector; 0 takes the scan's angle increment, which must then "
        "be below pi / 2.",
        unit="rad", ge=0.0, lt=pi / 2.0,
    )  # fmt: skip
    noise_points: int = param(
        4, "P_L: occupied cells with at most this many points are noise candidates.", ge=0
    )
    hole_cells: int = param(
        25,
        "Noise beside an unknown region of fewer cells than this is not on the border of the "
        "known; 0 counts every unknown cell.",
        ge=0,
    )
    no_return_free_m: float = param(
        5.0, "Length shown free by a beam without return (+inf); 0 ignores such beams.",
        unit="m", ge=0.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class LogOddsConfig:
    """The log-odds grid by rays."""

    p_hit: float = param(0.7, "P(occupied | a beam ended in this cell).", gt=0.5, lt=1.0)
    p_miss: float = param(0.4, "P(occupied | a beam crossed this cell).", gt=0.0, lt=0.5)
    p_max: float = param(0.97, "No cell is believed more than this.", gt=0.5, lt=1.0)
    no_return_free_m: float = param(
        5.0, "Length shown free by a beam without return (+inf); 0 ignores such beams.",
        unit="m", ge=0.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class MotionConfig:
    """How far a prediction of the next pose can be wrong; deviations, not bounds."""

    slip: float = param(0.1, "Error of odometry per metre driven.", unit="m/m", ge=0.0)
    turn_slip: float = param(0.1, "Error of odometry's turn per radian turned.", ge=0.0)
    turn_per_m: float = param(
        0.1, "Error of odometry's turn per metre driven.", unit="rad/m", ge=0.0
    )
    base_m: float = param(0.005, "Error of a prediction over no distance.", unit="m", gt=0.0)
    base_rad: float = param(0.01, "Error of a prediction over no turn.", unit="rad", gt=0.0)
    acceleration: float = param(
        1.0, "Change of speed expected where there is no odometry.", unit="m/s^2", gt=0.0
    )
    turn_acceleration: float = param(
        2.0, "Change of turn rate expected where there is no odometry.", unit="rad/s^2", gt=0.0
    )
    max_speed: float = param(
        3.0, "Odometry that moves faster was set anew: its step is no motion.", unit="m/s", gt=0.0
    )
    max_turn_rate: float = param(
        4.0, "Odometry that turns faster was set anew.", unit="rad/s", gt=0.0
    )
    stamp_jitter_s: float = param(
        0.05, "Error of a scan's stamp where there is no odometry.", unit="s", ge=0.0
    )
    smoothing_s: float = param(
        0.3, "Time over which velocity is averaged where there is no odometry.", unit="s", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class KeyScanConfig:
    """When a scan is kept."""

    distance_m: float = param(
        0.2, "A scan is kept when the robot moved this far since the last one.", unit="m", ge=0.0
    )
    turn_rad: float = param(
        0.2, "A scan is kept when the robot turned this far.", unit="rad", ge=0.0
    )
    period_s: float = param(
        5.0, "A scan is kept when this time has passed; 0 never.", unit="s", ge=0.0
    )

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class GridMapperConfig:
    """The mapper.

    `match_key` says which scans the next ones are matched to, `map_key` which enter the grid,
    `sonar_key` which readings of a sonar enter the ultrasonic map.
    """

    resolution_m: float = param(
        0.05, "Edge of a map cell.", unit="m", gt=0.0, le=1.0, read_only=True
    )
    grid: str = param(
        "label", "Map rule: the published labels, or the log-odds that the field uses.",
        choices=("label", "log_odds"), read_only=True,
    )  # fmt: skip
    fusion: str = param(
        "bayes",
        "How sonars enter the map: the published overlay, Bayesian integration, or not at all.",
        choices=("overlay", "bayes", "none"), read_only=True,
    )  # fmt: skip
    min_range_m: float = param(
        0.0, "Shorter readings are left out, beside the scan's own range_min.", unit="m", ge=0.0
    )
    max_range_m: float = param(
        80.0, "Longer readings are left out, beside the scan's own range_max.", unit="m", gt=0.0
    )
    min_pairs: int = param(20, "A match of fewer scan points is not trusted.", ge=3)
    min_overlap: float = param(
        0.2, "A match of a smaller share of the scan's points is not trusted.", ge=0.0, le=1.0
    )
    min_agreement: float = param(
        0.6, "A match whose pairs fit worse (mean weight) is not trusted.", ge=0.0, le=1.0
    )
    sure_overlap: float = param(
        0.5, "From this overlap on, a match that agrees is believed against odometry.",
        ge=0.0, le=1.0,
    )  # fmt: skip
    max_correction_sigmas: float = param(
        5.0,
        "Below sure_overlap, a match further from the prediction is not trusted.",
        unit="deviations",
        gt=0.0,
    )
    vague_sigma_m: float = param(
        0.5, "From this doubt of the prediction on, only a match of lost_* is believed.",
        unit="m", gt=0.0,
    )  # fmt: skip
    vague_sigma_rad: float = param(
        0.3, "From this doubt of the predicted yaw on, likewise.", unit="rad", gt=0.0
    )
    lost_overlap: float = param(
        0.8, "Overlap that a match needs when the robot does not know where it is.", ge=0.0, le=1.0
    )
    lost_agreement: float = param(
        0.7, "Agreement that a match needs when the robot does not know where it is.",
        ge=0.0, le=1.0,
    )  # fmt: skip
    undetermined_sigma_m: float = param(
        0.2, "A scan that leaves a direction less certain than this says nothing of it.",
        unit="m", gt=0.0,
    )  # fmt: skip
    keepout_margin_m: float = param(
        0.3, "How far the saved keepout mask reaches round glass.", unit="m", ge=0.0, le=5.0
    )
    loop_closing: bool = param(
        True,
        "Close loops: match to what was seen lately, and correct all poses by a pose graph; the "
        "live node does so in the background. False matches to all key scans instead.",
        read_only=True,
    )
    deskew: str = param(
        "auto",
        "Order of the beams in time, where time_increment says that they follow each other: with "
        "it each is seen from where the robot was at the scan's stamp, but for `pose_source` tf. "
        "`auto` learns the order from the first turns, `none` takes all beams as of one moment.",
        choices=("auto", "first_to_last", "last_to_first", "none"), read_only=True,
    )  # fmt: skip
    loop: LoopConfig = field(default_factory=LoopConfig)
    relocation: RelocationConfig = field(default_factory=RelocationConfig)
    match_key: KeyScanConfig = field(default_factory=KeyScanConfig)
    map_key: KeyScanConfig = field(default_factory=KeyScanConfig)
    matcher: ScanMatcherConfig = field(default_factory=ScanMatcherConfig)
    motion: MotionConfig = field(default_factory=MotionConfig)
    label: LabelGridConfig = field(default_factory=LabelGridConfig)
    log_odds: LogOddsConfig = field(default_factory=LogOddsConfig)
    sonar: SonarConfig = field(default_factory=SonarConfig)
    sonar_key: SonarKeyConfig = field(default_factory=SonarKeyConfig)
    bayes: BayesConfig = field(default_factory=BayesConfig)

    def __post_init__(self) -> None:
        validate(self)

    def clipped(self, scan: Scan) -> Scan:
        """Return the scan with these range limits beside its own."""
        low = max(scan.range_min, self.min_range_m)
        high = min(scan.range_max, self.max_range_m)
        return replace(scan, range_min=low, range_max=high)
