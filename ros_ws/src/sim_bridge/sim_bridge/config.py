"""Settings of the node, and what a robot file may set, each with unit and range."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.config import param, validate

STEP_NS = 10_000_000
STEP_S = STEP_NS * 1e-9


@dataclass(frozen=True, kw_only=True)
class SimBridgeConfig:
    """Settings of the node `sim_bridge`."""

    world: str = param(
        "furnished_floor", "Name of a world of the package, or path of a YAML file.", read_only=True
    )
    world_parameters: tuple[str, ...] = param(
        (), "Figures that the world file names, as `name=value`.", read_only=True
    )
    seed: int = param(0, "Seed of every random number.", ge=0, read_only=True)
    tf_scheme: str = param(
        "prefix", "Robots with names: `prefix`: one /tf, frames such as r1/odom; `topic`: plain "
        "frames on r1/tf and r1/tf_static.", choices=("prefix", "topic"), read_only=True,
    )  # fmt: skip
    real_time_factor: float = param(
        1.0, "Simulated seconds in a second; 0 = as fast as it goes.", ge=0.0, le=1000.0
    )
    paused: bool = param(False, "Time stands still; `~/step` still goes on.")
    lockstep: bool = param(False, "Go on only when `~/step` is called.")
    step_s: float = param(
        0.1, "How far `~/step` goes, a multiple of 0.01.", unit="s", ge=STEP_S, le=1.0
    )
    clock_period_s: float = param(
        0.02, "Simulated time between `/clock` messages.", unit="s", ge=STEP_S
    )
    start_nodes: tuple[str, ...] = param(
        (), "Nodes that time waits for before it starts, such as `grid_mapper`; none = no waiting.",
        read_only=True,
    )  # fmt: skip
    pace_topics: tuple[str, ...] = param(
        (), "Topics that time waits for, such as `cmd_vel` and `pose`, each from its first message "
        "on; none = no waiting.",
        read_only=True,
    )  # fmt: skip
    pace_nodes: tuple[str, ...] = param(
        (), "Nodes whose answers time waits for, by name; an answer is a message on any of their "
        "topics but images, maps and what every node has. A node counts from its first answer on, "
        "one that is in `start_nodes` too from time 0 on.", read_only=True,
    )  # fmt: skip
    pace_lag_s: float = param(
        0.2, "How far time may run ahead of the last answer.", unit="s", gt=0.0, read_only=True
    )
    pace_timeout_s: float = param(
        5.0, "Real time after which it goes on without.", unit="s", gt=0.0, read_only=True
    )
    view: bool = param(False, "Show pybullet's window.", read_only=True)
    enable_stamped_cmd_vel: bool = param(
        False, "Take TwistStamped instead of Twist on `cmd_vel`.", read_only=True
    )
    sonar_topics: str = param(
        "one", "`one`: all on `sonar`, told apart by frame; `each`: `sonar_0`, `sonar_1` ...",
        choices=("one", "each"), read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if abs(self.step_s / STEP_S - round(self.step_s / STEP_S)) > 1e-6:
            raise ValueError(f"step_s must be a multiple of {STEP_S:g} s, got {self.step_s:g}")


@dataclass(frozen=True, kw_only=True)
class RouteConfig:
    """Settings of the node `route_follower`."""

    route_m: tuple[float, ...] = param((0.0, 0.0), "Waypoints x, y, x, y ... in the map frame.")
    speed_m_s: float = param(0.8, "Travel speed.", unit="m/s", gt=0.0)
    max_yaw_rate_rad_s: float = param(1.2, "Fastest turn.", unit="rad/s", gt=0.0)
    lookahead_m: float = param(0.4, "Distance of the point it steers for.", unit="m", gt=0.0)
    turn_on_spot_rad: float = param(0.9, "Turns on the spot beyond this.", unit="rad", gt=0.0)
    pose_timeout_s: float = param(1.0, "Stops if the pose is older.", unit="s", gt=0.0)
    steer_by: str = param(
        "pose", "`pose`: the mapper's, carried on by odometry; `odom`: odometry alone.",
        choices=("pose", "odom"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if len(self.route_m) < 2 or len(self.route_m) % 2:
            raise ValueError(f"route_m must hold x, y pairs, got {len(self.route_m)} numbers")


@dataclass(frozen=True, kw_only=True)
class DriveConfig:
    """Limits of a drive between `cmd_vel` and the wheels."""

    is_omnidirectional: bool = param(False, "Moves sideways too; needs `wheels.bearings_deg`.")
    max_speed_m_s: float = param(1.667, "Fastest travel.", unit="m/s", gt=0.0, le=20.0)
    max_yaw_rate_rad_s: float = param(1.5, "Fastest turn.", unit="rad/s", gt=0.0, le=50.0)
    max_accel_m_s2: float = param(0.8, "Acceleration and braking limit.", unit="m/s^2", gt=0.0)
    max_yaw_accel_rad_s2: float = param(2.5, "Turning limit.", unit="rad/s^2", gt=0.0)
    command_delay_s: float = param(0.05, "Time until a command acts.", unit="s", ge=0.0)
    command_timeout_s: float = param(0.5, "Silence after which it stops.", unit="s", gt=0.0)
    absurd_factor: float = param(10.0, "A command this many times the limit is refused.", gt=1.0)

    def __post_init__(self) -> None:
        validate(self)
        if self.command_delay_s >= self.command_timeout_s:
            raise ValueError(
                f"command_delay_s must be < command_timeout_s = {self.command_timeout_s:g} or no "
                f"command ever acts, got {self.command_delay_s:g}"
            )


@dataclass(frozen=True, kw_only=True)
class WheelConfig:
    """Wheels and the ways in which they do not do what the encoders say.

    Without `bearings_deg` they are the two of a differential drive.
    """

    bearings_deg: tuple[float, ...] = param(
        (), "Where omnidirectional wheels sit; each drives across its bearing.",
        unit="deg",
    )  # fmt: skip
    mount_radius_m: float = param(
        0.07, "Distance of omnidirectional wheels from the middle.", unit="m", gt=0.0
    )
    radius_m: float = param(0.19, "Wheel radius that the robot believes.", unit="m", gt=0.0)
    track_m: float = param(0.50, "Distance between the wheels.", unit="m", gt=0.0)
    ticks_per_turn: int = param(2048, "Encoder ticks a wheel turn; 0 = exact.", ge=0)
    radius_error_sd: float = param(0.0015, "Relative error of each radius, per run.", ge=0.0)
    slip_mean: float = param(0.005, "Share of a wheel's travel lost on the floor.", ge=0.0, lt=1.0)
    slip_sd: float = param(0.01, "Deviation of that share from its mean.", ge=0.0, lt=0.5)
    slip_time_s: float = param(0.5, "How long a deviation lasts.", unit="s", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)
        if len(self.bearings_deg) in (1, 2):
            raise ValueError(f"bearings_deg must hold 0 or >= 3 wheels, got {self.bearings_deg}")
        if self.bearings_deg:
            bearings = np.radians(self.bearings_deg)
            ways = np.column_stack((np.sin(bearings), np.cos(bearings), np.ones(len(bearings))))
            if np.linalg.matrix_rank(ways, tol=1e-3) < 3:
                raise ValueError(
                    f"bearings_deg must let the base move any way, got {self.bearings_deg}"
                )


@dataclass(frozen=True, kw_only=True)
class OdometryConfig:
    """Odometry messages. The pose's covariance follows from the wheels (`sim_bridge.drift`)."""

    period_s: float = param(0.02, "Time between messages.", unit="s", ge=STEP_S)
    speed_sd: float = param(0.02, "Deviation of the speeds along x and y.", unit="m/s", ge=0.0)
    yaw_rate_sd: float = param(0.03, "Deviation of the yaw rate.", unit="rad/s", ge=0.0)

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class LaserConfig:
    """A planar laser range finder."""

    frame: str = param("laser", "Link of the robot's URDF that it sits on.")
    num_beams: int = param(541, "Beams a scan.", ge=2, le=16000)
    fov_rad: float = param(
        4.71238898038469, "Angle of first to last beam; a full turn leaves the repeated one out.",
        unit="rad", gt=0.0, le=6.283186,
    )  # fmt: skip
    period_s: float = param(0.1, "Time between scans.", unit="s", ge=STEP_S)
    range_min_m: float = param(0.05, "Nearer echoes are -inf.", unit="m", ge=0.0)
    range_max_m: float = param(10.0, "Farther echoes are +inf.", unit="m", gt=0.0)
    noise_sd_m: float = param(0.01, "Deviation of a range.", unit="m", ge=0.0)
    noise_sd_share: float = param(0.0, "Deviation of a range, in shares of it, added.", ge=0.0)
    quantum_m: float = param(0.001, "Step of the ranges; 0 = exact.", unit="m", ge=0.0)
    dropout_share: float = param(0.002, "Share of beams that come back as NaN.", ge=0.0, le=1.0)
    edge_share: float = param(
        0.1, "Share of the beams beside an edge that measure between near and far.", ge=0.0, le=1.0
    )
    edge_depth_m: float = param(
        0.5, "Deepest edge at which that happens: deeper ones give two pulses.", unit="m", ge=0.0
    )
    reach_factor: float = param(
        1.5, "Distance over range_max_m at which the echo of plaster met squarely drowns; slanted "
        "and dark surfaces and glass shorten it.", ge=1.0,
    )  # fmt: skip
    echo_log_sd: float = param(
        0.1, "Deviation of the logarithm of that distance from beam to beam.", ge=0.0, le=1.0
    )
    sweep_s: float = param(
        0.0, "Time from first to last beam, in which a robot that moves smears its scan; 0 = none.",
        unit="s", ge=0.0, le=1.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
        if self.range_max_m <= self.range_min_m:
            raise ValueError(
                f"range_max_m must be > range_min_m = {self.range_min_m}, got {self.range_max_m}"
            )
        if self.sweep_s > self.period_s:
            raise ValueError(f"sweep_s must be <= period_s = {self.period_s}, got {self.sweep_s}")
