"""How a pose follows from the last one and the motion; defaults stand here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class MotionConfig:
    """What a tracker of any kind of view takes for one and the same robot, driven on."""

    gate_sd: float = param(
        4.0, "A pose follows from the last and the motion within so many deviations.", gt=1.0
    )
    odom_share: float = param(0.1, "Deviation of odometry, of the way and of the turn.", ge=0.0)
    slack_m: float = param(0.03, "Deviation from one view to the next besides.", unit="m", gt=0.0)
    slack_rad: float = param(0.03, "The same of yaw.", unit="rad", gt=0.0)
    max_speed_m_s: float = param(
        1.0, "Speed that is thought possible without odometry.", unit="m/s", gt=0.0
    )
    max_turn_rad_s: float = param(
        2.0, "Turn that is thought possible without odometry.", unit="rad/s", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
