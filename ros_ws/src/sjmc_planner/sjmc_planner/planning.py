"""What a planning method takes and gives: the seam between the methods and all who run them.

A method is any object with `decide`; `methods.METHODS` lists them by name. Everything is in the
robot's frame `base_link` (x forward, y left), so a method never sees a map, a clock or a message.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2

DRIVING, BRAKING, BLOCKED, REACHED = "driving", "braking", "blocked", "reached"
TURNING, WAITING, BACKING = "turning", "waiting", "backing"


@dataclass(frozen=True, slots=True)
class Velocity:
    """Velocity of the base: m/s forward and to the left, rad/s counter-clockwise."""

    x: float
    y: float
    yaw_rate: float

    @property
    def speed(self) -> float:
        """Speed over the floor, m/s."""
        return math.hypot(self.x, self.y)

    @property
    def is_still(self) -> bool:
        """Whether it is no motion at all."""
        return self.x == self.y == self.yaw_rate == 0.0


STILL = Velocity(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RobotState:
    """How the robot moves.

    Attributes:
        velocity: Measured (the paper's v_a).
        command: The one sent last; `STILL` if none is in force.
        moved: Where it is, seen from where it was when the method was asked last.
    """

    velocity: Velocity
    command: Velocity = STILL
    moved: SE2 = SE2(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Obstacles:
    """What is known of the surroundings.

    Attributes:
        scan: Ranges in the sensor's frame. `+inf` is free to `range_max` and unknown beyond,
            `-inf` is blocked at `range_min`, NaN was not seen.
        T_base_sensor: The sensor seen from where the robot is now.
        known: Points of obstacles known beside the scan, such as glass, in the base frame, no
            farther apart than 0.05 m where there is no gap, shape (K, 2), m.
    """

    scan: Scan
    T_base_sensor: SE2
    known: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def shows_nothing(self) -> bool:
        """Whether no beam saw anything: the sensor is blind."""
        return bool(np.isnan(self.scan.ranges).all())


@dataclass(frozen=True)
class Goal:
    """Where to go.

    Attributes:
        point: What to head for, in the base frame, shape (2,), m.
        distance: How far it is to where the robot is to stand still, m; along the path if there
            is one.
    """

    point: np.ndarray
    distance: float

    @property
    def bearing(self) -> float:
        """Direction of `point`, rad."""
        return math.atan2(float(self.point[1]), float(self.point[0]))


@dataclass(frozen=True)
class Debug:
    """What a method saw and weighed, for pictures; all in the base frame.

    Attributes:
        grown: Border of the space the robot's middle may be in, shape (N, 2), m; NaN where open.
        candidates: A predicted way for each direction weighed, shapes (K, 2), m.
        times: How long each of them is free, s, shape (J,); inf = as far as was looked.
        chosen: Index of the one taken; -1 for none.
        zones: Radii of circles about the robot that matter to it, m.
        people: Who it takes for people: x, y, vx, vy, radius, shape (P, 5), m and m/s.
        who: Index of the one of them that sets the speed; -1 for nobody.
    """

    grown: np.ndarray
    candidates: Sequence[np.ndarray]
    times: np.ndarray
    chosen: int
    zones: tuple[float, ...] = ()
    people: np.ndarray = field(default_factory=lambda: np.zeros((0, 5)))
    who: int = -1


@dataclass(frozen=True)
class Decision:
    """What to do next.

    Attributes:
        command: Velocity to send.
        state: `DRIVING`, `BRAKING`, `BLOCKED` or `REACHED`; of `sjmc` too: `TURNING` off the
            target's course, `WAITING` for a person, `BACKING` before one.
        reason: Why, in words for the user; "" while driving as wanted.
        debug: For pictures; None if it was not asked for.
    """

    command: Velocity
    state: str
    reason: str = ""
    debug: Debug | None = None


class Method(Protocol):
    """A local planning method."""

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now.

        Args:
            state: How the robot moves.
            obstacles: What is around it.
            goal: Where to go.
            has_debug: Whether to fill `Decision.debug`, which takes time.
        """
        ...
