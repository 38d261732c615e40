"""Settings of the tracker of people."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class TrackingConfig:
    """What people look like to a scan, how they move, and how long they are remembered."""

    range_m: float = param(
        10.0, "Nothing farther from the sensor is tracked.", unit="m", gt=0.0, le=100.0
    )
    leg_width_m: float = param(
        0.25, "Clusters up to this are taken for a leg.", unit="m", gt=0.0, le=1.0
    )
    body_width_m: float = param(
        0.8, "Wider clusters are walls and the like, and are not tracked.", unit="m", gt=0.0, le=3.0
    )
    step_m: float = param(
        0.85, "Two legs of a person are no farther apart.", unit="m", gt=0.0, le=2.0
    )
    person_radius_m: float = param(
        0.25, "Least radius of the disk that stands for a person.", unit="m", gt=0.0, le=1.0
    )
    accel_m_s2: float = param(
        1.5, "How much people change their velocity within a second.", unit="m/s^2", gt=0.0, le=10.0
    )
    confirm_s: float = param(
        0.15, "Something is only reported once it was seen for so long.", unit="s", ge=0.0, le=5.0
    )
    memory_s: float = param(
        1.0, "Somebody who is hidden is carried on for so long.", unit="s", ge=0.0, le=10.0
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.leg_width_m > self.body_width_m:
            raise ValueError(
                f"leg_width_m must be <= body_width_m = {self.body_width_m}, got {self.leg_width_m}"
            )
