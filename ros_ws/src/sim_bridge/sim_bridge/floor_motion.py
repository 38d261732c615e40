"""Steps of a base over the floor: what it is to go, and what of that contacts leave."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.drive import Velocity


def floor_velocity(yaw: float, velocity: Velocity, dt: float) -> tuple[float, float, float]:
    """Return a base's velocity as a steady one over the floor for a step (m/s, m/s, rad/s).

    Args:
        yaw: Of the base at the start of the step.
        velocity: Of the base in its own frame.
        dt: Length of the step, s.
    """
    # Along the middle direction of the step, with the chord of the arc: no curve is cut.
    turn = velocity.yaw_rate * dt
    shrunk = float(np.sinc(turn / (2.0 * np.pi)))
    ahead, aside = shrunk * velocity.speed, shrunk * velocity.side_speed
    c, s = math.cos(yaw + turn / 2.0), math.sin(yaw + turn / 2.0)
    return ahead * c - aside * s, ahead * s + aside * c, velocity.yaw_rate


def on_its_way(before: SE2, after: SE2, wanted: np.ndarray) -> SE2:
    """Return the end of a step whose contacts may shorten the wanted way, and do nothing else.

    Args:
        before: Pose before the step.
        after: What the engine made of it.
        wanted: Way (m, m) and turn (rad) of the wheels, over the floor.
    """
    way, turn = wanted[:2], float(wanted[2])
    came = np.array([after.x - before.x, after.y - before.y])
    share = float(np.clip(came @ way / max(way @ way, 1e-18), 0.0, 1.0))
    turned = math.remainder(after.yaw - before.yaw, 2.0 * math.pi)
    turned = min(max(turned, min(turn, 0.0)), max(turn, 0.0))
    return SE2(before.x + share * way[0], before.y + share * way[1], before.yaw + turned)
