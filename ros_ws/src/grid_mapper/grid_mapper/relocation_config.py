"""Values of finding a robot in a map; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class RelocationConfig:
    """When a place in a map is believed to be where a lost robot is."""

    look_distance_m: float = param(
        0.3,
        "A lost robot looks again when it has moved this far.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    look_turn_rad: float = param(
        0.3,
        "A lost robot looks again when it has turned this far.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    way_m: float = param(
        1.0,
        "Looks have to be taken this far apart before a place is believed, for a turn on the spot "
        "shows nothing new; not where somebody says about where the robot is.",
        unit="m", ge=0.0, read_only=True,
    )  # fmt: skip
    min_overlap: float = param(
        0.75,
        "A place where less of the scans is near the map is not believed.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    min_agreement: float = param(
        0.75,
        "A place where what is near fits worse (mean weight) is not believed.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    max_contradiction: float = param(
        0.3,
        "A place where more of the map's walls are seen through is not believed.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    rival_share: float = param(
        0.8,
        "A place is ambiguous while another fits by this share as well, look by look.",
        gt=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    agree_m: float = param(
        0.03,
        "Two looks whose places differ by more, beside what odometry errs, do not agree.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    max_sigma_m: float = param(
        0.05,
        "A place less certain than this in some direction is not believed, nor one where parts of "
        "the scan disagree by more.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
