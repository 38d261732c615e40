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
    gate_sd: float = param(4.0, "A bearing within so many deviations may be a robot's.", gt=0.0)
    detected_share: float = param(
        0.95, "Chance that a robot that nothing hides is detected.", gt=0.0, lt=1.0
    )
    num_false: float = param(0.1, "Mean number of false detections in a view.", gt=0.0)
    least_visible: float = param(
        0.02, "Chance that a robot is seen although a body seems to hide it.", gt=0.0, le=1.0
    )
    new_share: float = param(
        0.1, "Of all bearings at most this share, the surest, begins to count in one round.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    max_rounds: int = param(
        20, "Identities are looked at again at most so many times.", ge=1, le=100
    )
    num_messages: int = param(
        15, "Messages run between pairs and bearings so many times a round.", ge=1, le=1000
    )
    loose_yaw_rad: float = param(
        0.1, "A yaw known worse than this is settled by the pattern of the robot's bearings first.",
        unit="rad", gt=0.0,
    )  # fmt: skip
    far_sd_m: float = param(
        5.0, "A position known worse than this along an axis is not known.", unit="m", gt=0.0
    )
    explained_share: float = param(
        0.95, "A robot of whose bearings less than this share fits anybody is looked for anew.",
        ge=0.0, le=1.0,
    )  # fmt: skip
    least_views: int = param(
        1, "Robots with fewer bearings than this are not looked for anew.", ge=1
    )
    search_rounds: int = param(
        10, "Identities are looked at again at most so many times after a search.", ge=1, le=100
    )
    max_lost: int = param(10, "So many of them are looked for at once, the worst ones.", ge=1)
    max_searches: int = param(4, "Robots are looked for anew so many times.", ge=0, le=100)
    soft_rounds: int = param(
        24, "In a crowd poses are fitted so many times to soft beliefs.", ge=1, le=1000
    )
    soft_heat: float = param(
        8.0, "In a crowd innovations are at first so much wider than their covariance says.",
        ge=1.0,
    )  # fmt: skip
    soft_cold: float = param(2.5, "As `soft_heat`, in the end.", ge=1.0)
    confirmed_share: float = param(
        0.65, "In a crowd a robot of whose bearings less than this share is returned is looked for "
        "anew.", ge=0.0, le=1.0,
    )  # fmt: skip
    crowd_searches: int = param(
        12, "In a crowd robots are looked for anew so many times.", ge=0, le=100
    )
    liar_share: float = param(
        0.5, "Bearings of a robot of which less than this share fits anybody are left out.",
        ge=0.0, le=1.0,
    )  # fmt: skip
    least_trust: float = param(
        0.25, "Identities count only if the share of bearings with an owner, times the share of "
        "those that are returned, is this much above twice chance; else each robot is alone.",
        ge=0.0, le=1.0,
    )  # fmt: skip
    returned_share: float = param(
        0.85, "Share of a robot's bearings that should be returned, if as much is usual in the "
        "team; a robot of whose bearings clearly less is returned is placed alone.", ge=0.0, le=1.0,
    )  # fmt: skip
    lost_yaw_rad: float = param(
        1.0, "A yaw known worse than this is not known.", unit="rad", gt=0.0
    )
    published: PublishedTeamConfig = PublishedTeamConfig()

    def __post_init__(self) -> None:
        validate(self)
