"""Every value of the team's localizer; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class PublishedTeamConfig:
    """The steps of the paper (3.2.3 and 3.3)."""

    angle_tolerance_rad: float = param(
        0.105, "Three angles make a triangle if their sum is 180 degrees within this (the paper's "
        "dE, not given there).", unit="rad", gt=0.0, lt=1.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class TeamConfig:
    """Identities by geometry and the fit of all poses."""

    bearing_sd_rad: float = param(
        0.0349, "Deviation of a bearing where a view names none.", unit="rad", gt=0.0, lt=1.0
    )
    rough_sd_m: float = param(
        0.36, "Deviation of a rough position along each axis where a view names none.",
        unit="m", gt=0.0,
    )  # fmt: skip
    body_radius_m: float = param(
        0.15, "Radius of a robot's body, which hides what is behind it.", unit="m", ge=0.0
    )
    gate_sd: float = param(3.5, "A bearing within so many deviations may be a robot's.", gt=0.0)
    max_rounds: int = param(
        8, "Identities are looked at again at most so many times.", ge=1, le=100
    )
    published: PublishedTeamConfig = PublishedTeamConfig()

    def __post_init__(self) -> None:
        validate(self)
