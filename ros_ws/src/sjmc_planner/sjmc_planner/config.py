"""Settings of the robot, the methods and the node, each with unit and range."""

from __future__ import annotations

import math
from dataclasses import dataclass

from floornav_common.config import param, validate
from sjmc_planner.follow_config import FollowConfig
from sjmc_planner.histogram_config import HistogramConfig
from sjmc_planner.known_config import KnownConfig
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.tracking_config import TrackingConfig


@dataclass(frozen=True, kw_only=True)
class RobotConfig:
    """What the planner must know of the robot. The defaults are the floor paper's robot."""

    drive: str = param(
        "omni", "`omni`: moves sideways too; `differential`: does not.",
        choices=("omni", "differential"),
    )  # fmt: skip
    radius_m: float = param(
        0.085, "Circle around `base_frame` that holds the whole robot (r_robot).", unit="m", gt=0.0
    )
    margin_m: float = param(0.02, "Air to keep beyond that circle.", unit="m", ge=0.0)
    front_m: float = param(
        0.0, "How far the robot reaches ahead of `base_frame`, for methods that know its box "
        "(`sjmc`); 0 with `rear_m` and `half_width_m` = the circle.", unit="m", ge=0.0,
    )  # fmt: skip
    rear_m: float = param(0.0, "How far it reaches behind.", unit="m", ge=0.0)
    half_width_m: float = param(0.0, "How far it reaches to either side.", unit="m", ge=0.0)
    speed_m_s: float = param(0.4, "Travel speed (v_c).", unit="m/s", gt=0.0)
    accel_m_s2: float = param(0.3, "Acceleration and braking limit (alpha).", unit="m/s^2", gt=0.0)
    yaw_rate_rad_s: float = param(1.2, "Fastest turn (differential).", unit="rad/s", gt=0.0)
    yaw_accel_rad_s2: float = param(2.0, "Turning limit (differential).", unit="rad/s^2", gt=0.0)
    idle_time_s: float = param(
        0.03, "Time until a command acts (delta t): sensor, network and driver.", unit="s", ge=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
        farthest = math.hypot(max(self.front_m, self.rear_m), self.half_width_m)
        if farthest > self.radius_m + 1e-6:
            raise ValueError(
                f"radius_m must hold the box, whose corners are {farthest:.3f} m from the base, "
                f"got {self.radius_m}"
            )
        if max(self.front_m, self.rear_m) > 0.0 and self.half_width_m == 0.0:
            raise ValueError("half_width_m must be > 0 where front_m or rear_m is, got 0")

    @property
    def grown_radius(self) -> float:
        """By how much obstacles are grown, m."""
        return self.radius_m + self.margin_m


@dataclass(frozen=True, kw_only=True)
class OmniConfig:
    """Settings of the methods `omni_velocity` and `omni_static` (floor paper, 3.2)."""

    num_directions: int = param(180, "Directions weighed (J).", ge=4, le=3600)
    num_bearings: int = param(
        360, "Entries of the table of obstacle distances (N).", ge=16, le=7200
    )
    clear_time_s: float = param(
        2.75, "A direction is open if it is free for this long (T_th).", unit="s", gt=0.0, le=60.0
    )
    time_step_s: float = param(
        0.05, "Step of the predicted ways (Delta t).", unit="s", ge=0.005, le=1.0
    )
    num_speeds: int = param(
        3, "`omni_velocity`: speeds tried, each half of the one before, until a direction is open; "
        "1 is the published rule.", ge=1, le=8,
    )  # fmt: skip
    detour_rad: float = param(
        1.0, "`omni_velocity`: farther from the goal than this it rather goes slower.",
        unit="rad", ge=0.0, le=3.1416,
    )  # fmt: skip
    steady_weight: float = param(
        0.0, "`omni_velocity`: how much an angle to the present motion counts beside one to the "
        "goal; 0 is the published rule.", ge=0.0, le=1.0,
    )  # fmt: skip
    remembers_near: bool = param(
        True, "`omni_velocity`: remember what went nearer than the sensor sees; false is the "
        "published rule.",
    )  # fmt: skip
    keeps_stoppable: bool = param(
        True, "`omni_velocity`: only take what can still be stopped from within what is seen; "
        "false is the published rule.",
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if self.time_step_s > self.clear_time_s:
            raise ValueError(
                f"time_step_s must be <= clear_time_s = {self.clear_time_s}, got {self.time_step_s}"
            )


@dataclass(frozen=True, kw_only=True)
class LocalPlannerConfig:
    """Settings of the node `local_planner`."""

    method: str = param(
        "omni_velocity", "How to avoid obstacles.",
        choices=(
            "omni_velocity", "omni_static", "sjmc", "sjmc_published", "vfh_plus", "vfh", "vff",
        ),
    )  # fmt: skip
    goal_source: str = param(
        "path", "`path`: follow the topic `path`; `goal_pose`: go straight for the topic "
        "`goal_pose`; `follow_path`: Nav2's action.",
        choices=("path", "goal_pose", "follow_path"), read_only=True,
    )  # fmt: skip
    control_period_s: float = param(
        0.05, "Time between commands.", unit="s", ge=0.01, le=1.0, read_only=True
    )
    lookahead_m: float = param(
        0.5, "How far ahead on the path it heads for.", unit="m", gt=0.0, le=20.0
    )
    goal_tolerance_m: float = param(0.05, "This near is there.", unit="m", gt=0.0)
    scan_timeout_s: float = param(0.5, "Stops if no scan came for this long.", unit="s", gt=0.0)
    odom_timeout_s: float = param(0.5, "Stops if no `odom` came for this long.", unit="s", gt=0.0)
    pose_timeout_s: float = param(
        0.5, "Stops if the pose in the goal's frame is older.", unit="s", gt=0.0
    )
    unseen_gap_rad: float = param(
        0.1, "Gaps in what is seen (NaN) up to this take the nearer range beside them; wider ones "
        "are closed.", unit="rad", ge=0.0, le=6.2832,
    )  # fmt: skip
    enable_stamped_cmd_vel: bool = param(
        False, "Send TwistStamped instead of Twist on `cmd_vel`.", read_only=True
    )
    robot: RobotConfig = RobotConfig()
    omni: OmniConfig = OmniConfig()
    histogram: HistogramConfig = HistogramConfig()
    known: KnownConfig = KnownConfig()
    follow: FollowConfig = FollowConfig()
    sjmc: SjmcConfig = SjmcConfig()
    tracking: TrackingConfig = TrackingConfig()

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class SendGoalConfig:
    """The goal that `send_goal` sends."""

    x_m: float = param(0.0, "Where to go.", unit="m", read_only=True)
    y_m: float = param(0.0, "Where to go.", unit="m", read_only=True)
    yaw_rad: float = param(
        0.0, "Heading there, for planners that care.", unit="rad", read_only=True
    )
    frame: str = param("odom", "Frame of these, not fixed to the robot.", read_only=True)
    waits: bool = param(True, "Run until the planner says that it is there.", read_only=True)

    def __post_init__(self) -> None:
        validate(self)
