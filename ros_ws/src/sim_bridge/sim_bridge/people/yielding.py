"""How a person notices a robot and steps out of its way (figures and sources: `config.py`)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim_bridge.people.config import PeopleConfig

_SIDE_IS_CLEAR = 0.15
_AT_REST = 0.05
_STOPS_AT = 0.15


@dataclass(frozen=True)
class Robot:
    """A robot as people see it: a disk that moves.

    Attributes:
        position: Middle of its footprint, shape (2,), m.
        velocity: Shape (2,), m/s.
        radius: Of the disk round its footprint, m.
        eye: Where its laser is, shape (2,), m; None = at `position`.
    """

    position: np.ndarray
    velocity: np.ndarray
    radius: float
    eye: np.ndarray | None = None

    def sensed_distance(self, place: np.ndarray) -> float:
        """Return how far a place is from its laser, m."""
        return float(np.hypot(*(place - (self.position if self.eye is None else self.eye))))


@dataclass(frozen=True)
class Traits:
    """What one person is like for a whole run.

    Attributes:
        speed: Walking speed, m/s.
        notice_distance: Nothing farther off is noticed, m; 0 = never notices.
        notice_time: How long a robot at that distance must be in view, s.
        side: -1 passes a head-on robot to the person's own right, 1 to its left.
    """

    speed: float
    notice_distance: float
    notice_time: float
    side: int


def draw_traits(config: PeopleConfig, rng: np.random.Generator) -> Traits:
    """Draw a person; the same count of numbers is drawn for everyone."""
    speed, distance, time = rng.standard_normal(3)
    never, right = rng.random(2)
    reach = config.notice_distance_m + config.notice_distance_sd_m * distance
    return Traits(
        speed=max(0.4, config.speed_m_s + config.speed_sd_m_s * float(speed)),
        notice_distance=0.0 if never < config.never_share else max(1.0, float(reach)),
        notice_time=config.notice_time_s * math.exp(config.notice_time_log_sd * float(time)),
        side=-1 if right < config.right_share else 1,
    )


def attention_after(
    config: PeopleConfig,
    traits: Traits,
    attention: float,
    bearing: float,
    distance: float,
    dt: float,
) -> float:
    """Return how much of the noticing time has passed; noticed once it reaches 1.

    Args:
        config: The field of view.
        traits: The person.
        attention: Before, 0..1.
        bearing: Of the robot from the person's facing, rad.
        distance: To the robot, m; inf if it is hidden.
        dt: Time that passed, s.
    """
    if attention >= 1.0:
        return 1.0
    if distance > traits.notice_distance or abs(bearing) > config.view_rad / 2.0:
        return 0.0
    # The nearer the robot, the sooner it is noticed.
    rate = traits.notice_distance / max(distance, 0.1)
    return min(1.0, attention + dt * rate / max(traits.notice_time, 1e-3))


@dataclass(frozen=True)
class SideStep:
    """How a person makes room for one robot.

    Attributes:
        direction: Unit vector, (2,); zero when there is no need.
        speed: m/s.
        side: -1 or 1 while it lasts, as in `Traits`; 0 = no need.
    """

    direction: np.ndarray
    speed: float
    side: int


_NO_NEED = SideStep(np.zeros(2), 0.0, 0)


def side_step(
    config: PeopleConfig, traits: Traits, position: np.ndarray, velocity: np.ndarray,
    robot: Robot, side: int,
) -> SideStep:  # fmt: skip
    """Return the step aside that clears a noticed robot.

    Both are foreseen at constant velocity; if they would come nearer than the clearance within the
    horizon, the person goes square to the relative motion, as fast as is needed and possible.
    Position and velocity are the person's, (2,) each; `side` is the one taken since earlier.
    """
    r, w = position - robot.position, velocity - robot.velocity
    speed = float(np.hypot(*w))
    if speed < _AT_REST:
        return _NO_NEED
    closing, to_left = -float(r @ w), np.array([-w[1], w[0]]) / speed
    lateral = float(r @ to_left)
    needed = robot.radius + config.torso_radius_m + config.clearance_m
    if side != 0 and -needed < closing / speed <= 0.0:
        return SideStep(side * to_left, 0.0, side)  # not past yet
    if closing <= 0.0 or closing > config.horizon_s * speed**2:
        return _NO_NEED
    if side == 0 and abs(lateral) >= needed:
        return _NO_NEED
    if side == 0:
        side = traits.side if abs(lateral) < _SIDE_IS_CLEAR else int(math.copysign(1, lateral))
    missing = max(0.0, needed - side * lateral)
    # Half of the time left, so that the way is clear before the robot is there.
    time_left = max(0.5 * closing / speed**2, 0.3)
    return SideStep(side * to_left, min(config.side_speed_m_s, missing / time_left), side)


def held_back(
    config: PeopleConfig, position: np.ndarray, velocity: np.ndarray, robot: Robot
) -> np.ndarray:
    """Return the velocity without its part into a noticed robot that is within reach, (2,)."""
    r = position - robot.position
    distance = max(float(np.hypot(*r)), 1e-9)
    inward = -float(velocity @ r) / distance
    gap = distance - robot.radius - config.torso_radius_m
    return velocity + max(inward, 0.0) * r / distance if gap < _STOPS_AT else velocity
