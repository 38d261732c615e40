"""From a velocity command to the wheels: refusal, delay, time-out, limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sim_bridge.config import DriveConfig


@dataclass(frozen=True)
class Velocity:
    """Velocity of a base in the plane: m/s forward, rad/s counter-clockwise."""

    speed: float
    yaw_rate: float


STOP = Velocity(0.0, 0.0)


@dataclass(frozen=True)
class DriveState:
    """What a drive remembers.

    Attributes:
        velocity: What the wheels turn at now.
        target: The command in force.
        target_age: Time since that command was given, s.
        waiting: Commands that do not act yet, `(age in s, command)`, oldest first.
    """

    velocity: Velocity = STOP
    target: Velocity = STOP
    target_age: float = math.inf
    waiting: tuple[tuple[float, Velocity], ...] = field(default=())


def refusal(config: DriveConfig, command: Velocity) -> str:
    """Return why a command is refused, or "" if it is not.

    Values over the limits are clipped, not refused; not-finite ones and those `absurd_factor`
    times over are a fault of the sender.
    """
    limits = (
        ("linear.x", command.speed, config.max_speed_m_s, "m/s"),
        ("angular.z", command.yaw_rate, config.max_yaw_rate_rad_s, "rad/s"),
    )
    for name, value, limit, unit in limits:
        if not math.isfinite(value):
            return f"{name} is {value}"
        if abs(value) > config.absurd_factor * limit:
            return f"{name} is {value:g} {unit}, more than {config.absurd_factor:g} x {limit:g}"
    return ""


def drive_step(
    config: DriveConfig, state: DriveState, command: Velocity | None, dt: float
) -> DriveState:
    """Return the drive `dt` later.

    Args:
        config: Its limits.
        state: Before the step.
        command: A command given at the start of the step, or None. A refused one counts as a
            stop: the caller asks `refusal` first if it wants to say so.
        dt: Length of the step, s.
    """
    waiting = [(age + dt, old) for age, old in state.waiting]
    if command is not None:
        waiting.append((dt, STOP if refusal(config, command) else command))
    target, age = state.target, state.target_age + dt
    while waiting and waiting[0][0] > config.command_delay_s + 1e-9:
        age, target = waiting.pop(0)
    if age > config.command_timeout_s + 1e-9:
        target = STOP
    wanted = (
        _clip(target.speed, config.max_speed_m_s),
        _clip(target.yaw_rate, config.max_yaw_rate_rad_s),
    )
    now = state.velocity
    velocity = Velocity(
        now.speed + _clip(wanted[0] - now.speed, config.max_accel_m_s2 * dt),
        now.yaw_rate + _clip(wanted[1] - now.yaw_rate, config.max_yaw_accel_rad_s2 * dt),
    )
    return DriveState(velocity, target, age, tuple(waiting))


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
