"""Values of the team's filter over time; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class TeamFilterConfig:
    """How well bearings and odometry are believed, and when a robot counts as located or lost.

    Noise of the motion grows with the way, so its unit holds a square root: after d meters the
    position's deviation is travel_noise * sqrt(d).
    """

    bearing_sd_rad: float = param(0.006, "Deviation of one bearing.", unit="rad", gt=0.0)
    repeat_s: float = param(
        6.0,
        "Errors of bearings to one thing are alike for about so long: looks that follow each other "
        "sooner count for less; 0 takes every bearing for new knowledge.",
        unit="s", ge=0.0,
    )  # fmt: skip
    travel_noise: float = param(
        0.07, "Deviation along the way after 1 m where the odometry gives none.", ge=0.0
    )
    sideways_noise: float = param(0.02, "Deviation across the way after 1 m.", ge=0.0)
    turn_noise_way: float = param(0.03, "Deviation of the yaw after 1 m of way, rad.", ge=0.0)
    turn_noise: float = param(0.08, "Deviation of the yaw after turning by 1 rad, rad.", ge=0.0)
    offset_sd_rad: float = param(
        0.017, "Bearings are off by one angle; deviation of it at the start.", unit="rad", ge=0.0
    )
    offset_walk: float = param(0.0003, "How far that angle wanders in 1 s, rad.", ge=0.0)
    scale_sd: float = param(
        0.0,
        "Bearings grow by one factor from ahead to the side; deviation of it at the start. 0 for a "
        "camera that sees all round, 0.03 for one with a lens of uncertain focal length.",
        ge=0.0, lt=1.0,
    )  # fmt: skip
    travel_scale_sd: float = param(
        0.05, "The odometry's way is off by one factor; deviation of it at the start.",
        ge=0.0, lt=1.0,
    )  # fmt: skip
    turn_scale_sd: float = param(
        0.1, "The odometry's turns are off by one factor; deviation of it at the start.",
        ge=0.0, lt=1.0,
    )  # fmt: skip
    curve_sd: float = param(
        0.05, "A robot told to go straight turns; deviation of that at the start, rad/m.", ge=0.0
    )
    drag_sd: float = param(
        0.1,
        "The factor of the way grows or shrinks with the rate of turning; deviation of that at the "
        "start. 0.5 where the odometry is what the robot was told to drive.",
        unit="s", ge=0.0,
    )  # fmt: skip
    scale_walk: float = param(
        0.01, "How far the factors and the curve wander in 1 m or 1 rad.", ge=0.0
    )
    gate_sd: float = param(4.0, "Bearings further off than so many deviations are left out.", gt=1)
    soft_sd: float = param(2.0, "Bearings further off than so many count for less.", gt=0.0)
    identity_odds: float = param(
        20.0, "A bearing without a name is used if one meaning is so many times as likely as any.",
        gt=1.0,
    )  # fmt: skip
    false_share: float = param(
        0.02, "Share of nameless bearings that belong to nothing known.", gt=0.0, lt=1.0
    )
    start_window_s: float = param(
        20.0, "A start is found from the bearings of so long a time.", unit="s", gt=0.0
    )
    start_bearings: int = param(4, "And from at least so many bearings.", ge=3, le=1000)
    start_margin_m: float = param(
        3.0, "It is looked for around the landmarks, up to so far from their middle's box.",
        unit="m", gt=0.0,
    )  # fmt: skip
    start_step_m: float = param(0.5, "In steps of this.", unit="m", gt=0.0)
    start_max_sd_m: float = param(
        0.4, "And taken once its position is known this well.", unit="m", gt=0.0
    )
    start_odds: float = param(
        100.0, "And no other place is more likely than one to so many.", gt=1.0
    )
    lost_looks: int = param(20, "A robot is lost if of so many bearings ...", ge=4, le=1000)
    lost_share: float = param(
        0.6, "... more than this share had to be left out; then it starts anew.", gt=0.0, le=1.0
    )

    def __post_init__(self) -> None:
        validate(self)
