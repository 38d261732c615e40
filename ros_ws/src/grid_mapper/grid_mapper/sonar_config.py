"""What can be set of the ultrasonic map and of how it joins the laser's (glass paper, 5 and 6)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class SonarConfig:
    """The published map of ultrasonic points (glass paper, section 5)."""

    range_tolerance_m: float = param(0.05, "dr_S, half an arc's depth.", unit="m", ge=0.0)
    aperture_rad: float = param(
        0.0,
        "alpha_S, full opening of every sonar's cone (paper: 0.349, 20 degrees); 0 takes each "
        "message's field_of_view.",
        unit="rad", ge=0.0, le=pi,
    )  # fmt: skip
    unsaid_aperture_rad: float = param(
        pi / 9.0,
        "alpha_S of a message whose field_of_view is 0 or no angle: the paper's 20 degrees.",
        unit="rad", gt=0.0, le=pi,
    )  # fmt: skip
    min_points: float = param(
        4.5,
        "P_S: a cell with this many points (1/r^2, r in m) is an obstacle; the paper's 0.0000045 "
        "counts r in mm.",
        unit="1/m^2", gt=0.0,
    )  # fmt: skip
    no_echo_free_m: float = param(
        0.0,
        "Length of a cone without echo that is shown free; 0 takes no echo for no news, since "
        "glass at a slant gives none.",
        unit="m", ge=0.0,
    )  # fmt: skip
    max_pose_gap_s: float = param(
        1.0,
        "A reading is placed between two trusted scans no further apart in time; without such a "
        "pair it is left out.",
        unit="s", gt=0.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class SonarKeyConfig:
    """When a reading of a sonar is counted; each sonar by itself."""

    distance_m: float = param(
        0.05, "A reading is counted when the robot moved this far since the last one.",
        unit="m", ge=0.0,
    )  # fmt: skip
    turn_rad: float = param(
        0.1, "A reading is counted when the robot turned this far.", unit="rad", ge=0.0
    )
    period_s: float = param(
        0.0, "A reading is counted when this time has passed; 0 never.", unit="s", ge=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
