"""What people are like: their bodies, how they notice a robot and how they yield to it.

These figures are fixed here, before any planner is run against them; a world file may change them
under `people_model`, and a report must then say so. Sources:

- People notice a robot after a time that differs from person to person and is shorter the nearer
  it is (SJMC thesis, 6.1.2, where it is left open): each person draws a noticing distance and a
  noticing time, and the time runs faster in proportion as the robot is nearer.
- Nobody notices what is behind: effective field of view 200 degrees (Helbing and Molnar 1995).
- Who has noticed keeps 0.45 m of clear space, where Hall (1966) draws the intimate zone.
- Walking speed 1.34 m/s with deviation 0.26 m/s, relaxation time 0.5 s, repulsion between people
  2.1 m^2/s^2 over 0.3 m, from walls 10 m^2/s^2 over 0.2 m: Helbing and Molnar (1995).
- Some never notice: a share of ours, for people who look at a telephone.
"""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class PeopleConfig:
    """Bodies and behavior of all people in a world."""

    # How they notice.
    never_share: float = param(0.1, "Share of people who never notice.", ge=0.0, le=1.0)
    notice_distance_m: float = param(4.0, "Mean noticing distance.", unit="m", gt=0.0)
    notice_distance_sd_m: float = param(1.0, "Its spread between people.", unit="m", ge=0.0)
    notice_time_s: float = param(0.6, "Median noticing time at that distance.", unit="s", ge=0.0)
    notice_time_log_sd: float = param(0.4, "Its spread (log-normal).", ge=0.0)
    view_rad: float = param(3.490658503988659, "Field of view.", unit="rad", gt=0.0, le=6.2832)
    # How they yield.
    clearance_m: float = param(0.45, "Space between bodies that they make.", unit="m", ge=0.0)
    horizon_s: float = param(4.0, "How far they look ahead in time.", unit="s", gt=0.0)
    side_speed_m_s: float = param(0.7, "Fastest step aside.", unit="m/s", gt=0.0)
    right_share: float = param(0.7, "Share who pass a head-on robot on its left.", ge=0.0, le=1.0)
    # How they walk (Helbing and Molnar 1995).
    speed_m_s: float = param(1.34, "Mean walking speed.", unit="m/s", gt=0.0)
    speed_sd_m_s: float = param(0.26, "Its spread between people.", unit="m/s", ge=0.0)
    relaxation_s: float = param(0.5, "Time to take up a speed.", unit="s", gt=0.0)
    people_push_m2_s2: float = param(2.1, "Repulsion potential between people.", ge=0.0)
    people_range_m: float = param(0.3, "Its reach.", unit="m", gt=0.0)
    people_ahead_s: float = param(2.0, "How far a step of the other is foreseen.", ge=0.0)
    wall_push_m2_s2: float = param(10.0, "Repulsion potential of walls.", ge=0.0)
    wall_range_m: float = param(0.2, "Its reach.", unit="m", gt=0.0)
    # How they look to sensors.
    has_legs: bool = param(True, "Two legs that step; else one upright body.")
    leg_radius_m: float = param(0.065, "Radius of a leg.", unit="m", gt=0.0)
    leg_gap_m: float = param(0.22, "Between the middles of the legs.", unit="m", gt=0.0)
    step_m: float = param(0.7, "Length of a step.", unit="m", gt=0.0)
    torso_radius_m: float = param(0.20, "Radius of the torso.", unit="m", gt=0.0)
    torso_bottom_m: float = param(0.82, "Where the torso begins.", unit="m", gt=0.0)
    height_m: float = param(1.72, "Height of a person.", unit="m", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)
        if self.height_m <= self.torso_bottom_m:
            raise ValueError(
                f"height_m must be > torso_bottom_m = {self.torso_bottom_m}, got {self.height_m}"
            )
