"""How far a round robot gets along a line or an arc before it touches something.

The way of the robot's middle is an arc of curvature k from the origin; a point is touched where
the middle comes within the radius of it. A point that is within the radius already counts as
touched at once if the way leads nearer to it, and not at all if it leads away.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import Velocity

_STRAIGHT = 1e-6  # curvature below which a way is a line, 1/m
_NO_SPEED = 1e-3


def can_stop(
    velocity: Velocity, robot: RobotConfig, delay: float, points: np.ndarray, horizon: float
) -> bool:
    """Tell whether a robot that moves so can brake before it touches something.

    Args:
        velocity: Its motion now.
        robot: Its radius and how it brakes; half of its margin is kept.
        delay: How long it goes on before it brakes, s.
        points: What stands there, in the base frame, shape (M, 2), m.
        horizon: How far from the robot's middle was looked, m.
    """
    speed = velocity.speed
    if speed < _NO_SPEED:
        return True
    needed = speed * delay + speed * speed / (2.0 * robot.accel_m_s2)
    radius = robot.radius_m + 0.5 * robot.margin_m
    if needed + radius > horizon:
        return False
    is_reverse = robot.drive == "differential" and velocity.x < 0.0
    bearing = math.atan2(velocity.y, velocity.x)
    curvature = velocity.yaw_rate / speed if robot.drive == "differential" else 0.0
    curvature = -curvature if is_reverse else curvature
    return float(free_way(points, bearing, curvature, radius, needed)) >= needed


@numba.njit(cache=True, nogil=True)
def free_way(points, bearing, curvature, radius, until):  # type: ignore[no-untyped-def]
    """Return how long a way is until the robot touches a point, m; inf if none is up to `until`.

    Args:
        points: Shape (M, 2), m.
        bearing: Direction in which the way begins, rad.
        curvature: Of the way, positive to the left, 1/m.
        radius: Of the robot, m.
        until: How far to look, m.
    """
    c, s = np.cos(bearing), np.sin(bearing)
    reach2 = (until + radius) ** 2
    free = np.inf
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        d2 = px * px + py * py
        if d2 > reach2:
            continue
        along, aside = c * px + s * py, c * py - s * px
        if d2 <= radius * radius:
            free = 0.0 if along > 0.0 else free
        elif abs(curvature) < _STRAIGHT:
            if along > 0.0 and abs(aside) < radius:
                free = min(free, along - np.sqrt(radius * radius - aside * aside))
        else:
            free = min(free, _along_arc(along, aside, curvature, radius))
    return free if free <= until else np.inf


@numba.njit(cache=True, nogil=True)
def _along_arc(x, y, curvature, radius):  # type: ignore[no-untyped-def]
    """Return how long an arc from the origin along x is until it comes within `radius`."""
    if curvature < 0.0:
        y, curvature = -y, -curvature
    turn = 1.0 / curvature
    dy = y - turn  # from the arc's middle
    rho = np.sqrt(x * x + dy * dy)
    if abs(rho - turn) >= radius or rho == 0.0:
        return np.inf
    # The two circles meet beside the point's own bearing by this angle (law of cosines).
    cosine = (turn * turn + rho * rho - radius * radius) / (2.0 * turn * rho)
    half = np.arccos(min(max(cosine, -1.0), 1.0))
    at = np.arctan2(x, -dy)  # how far around the point is
    return turn * ((at - half) % (2.0 * np.pi))
