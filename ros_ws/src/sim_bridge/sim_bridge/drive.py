"""From a velocity command to the wheels: refusal, delay, time-out, limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sim_bridge.config import DriveConfig


@dataclass(frozen=True)
class Velocity:
    """Velocity of a base in the plane: m/s forward and to the left, rad/s counter-clockwise."""

    speed: float
    yaw_rate: float
    side_speed: float = 0.0


STOP = Velocity(0.0, 0.0)
_CLIP_TOL = 1e-9


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
        ("linear.y", command.side_speed, config.max_speed_m_s, "m/s"),
        ("angular.z", command.yaw_rate, config.max_yaw_rate_rad_s, "rad/s"),
    )
    for name, value, limit, unit in limits:
        if not math.isfinite(value):
            return f"{name} is {value}"
        if abs(value) > config.absurd_factor * limit:
            return f"{name} is {value:g} {unit}, more than {config.absurd_factor:g} x {limit:g}"
    return ""


def limitation(config: DriveConfig, command: Velocity) -> str:
    """Return what of a command is not done as asked: clipped or ignored; "" if all is done."""
    texts = []
    travel = command.speed
    if config.is_omnidirectional:
        travel = math.hypot(command.speed, command.side_speed)
    elif command.side_speed:
        texts.append("linear.y is ignored: the drive cannot move sideways")
    if abs(travel) > config.max_speed_m_s + _CLIP_TOL:
        texts.append(f"travel is clipped to max_speed_m_s, {config.max_speed_m_s:g} m/s")
    if abs(command.yaw_rate) > config.max_yaw_rate_rad_s + _CLIP_TOL:
        limit = config.max_yaw_rate_rad_s
        texts.append(f"angular.z is clipped to max_yaw_rate_rad_s, {limit:g} rad/s")
    return "; ".join(texts)


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
    velocity = _limited(config, state.velocity, target, dt)
    return DriveState(velocity, target, age, tuple(waiting))


def _limited(config: DriveConfig, now: Velocity, target: Velocity, dt: float) -> Velocity:
    """Return the velocity on the way to a target; limits act on the vector (floor paper, eq. 10).

    Eq. 10 speaks of the floor: what the base does turns with it, so the velocity of before is seen
    from the turned base. A base that cannot move sideways ignores that part of a command, as
    drivers do; its wheels carry it round a curve, and only its speed is limited.
    """
    yaw_rate = _clip(target.yaw_rate, config.max_yaw_rate_rad_s)
    turn = now.yaw_rate + _clip(yaw_rate - now.yaw_rate, config.max_yaw_accel_rad_s2 * dt)
    if not config.is_omnidirectional:
        speed = _clip(target.speed, config.max_speed_m_s)
        return Velocity(now.speed + _clip(speed - now.speed, config.max_accel_m_s2 * dt), turn)
    x, y = _shortened(target.speed, target.side_speed, config.max_speed_m_s)
    # From the middle of the last step to the middle of this one.
    angle = -0.5 * (now.yaw_rate + turn) * dt
    c, s = math.cos(angle), math.sin(angle)
    ahead, aside = c * now.speed - s * now.side_speed, s * now.speed + c * now.side_speed
    dx, dy = _shortened(x - ahead, y - aside, config.max_accel_m_s2 * dt)
    return Velocity(ahead + dx, turn, aside + dy)


def _shortened(x: float, y: float, limit: float) -> tuple[float, float]:
    share = limit / max(math.hypot(x, y), limit)
    return share * x, share * y


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
