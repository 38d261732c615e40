"""How much room any robot with these limits can leave in section 5.2.3 without turning.

The person of Fig. 5.4 sets out once the robot senses it a distance away and heeds nothing. Whoever
goes straight can only back. Here a robot is told that the person walks, and backs as hard as the
drive can once a command acts: from rest, told at once or by its laser's next scan; and from the
creeping speed of `sjmc`, told by the next scan. What is left is the most that can be asked for of
a robot that goes at that speed; the slower it creeps, the more it is.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from experiments.crowd_scenes import ROBOT
from experiments.planner_contacts import gap_to
from sim_bridge.people.config import PeopleConfig
from sjmc_planner.sjmc_config import SjmcConfig

SPEEDS = (0.8, 1.1, 1.4)
ACTS_S, SCAN_S = 0.1, 0.1  # one period and the drive's delay; between two scans
_WALK = (1.5, 1.8)  # towards the robot and across
_BESIDE, _LASER = 0.9, 0.1  # the person's start beside the way; the laser ahead of base_link, m
_DT, _LONG = 0.002, 4.0


def best_gap(distance: float, walker_speed: float, speed: float, latency: float) -> float:
    """Return the least gap between the bodies when backing as hard as possible, m.

    Args:
        distance: From the laser to the person's body when the person sets out, m.
        walker_speed: m/s.
        speed: Of the robot then, towards the person, m/s.
        latency: Until its brakes act, s.
    """
    body = PeopleConfig().torso_radius_m
    t = np.arange(0.0, _LONG, _DT)
    slowed = np.maximum(t - latency, 0.0) * ROBOT.accel_m_s2
    v = np.maximum(speed - slowed, -ROBOT.speed_m_s)
    ahead = math.sqrt((distance + body) ** 2 - _BESIDE**2) + _LASER
    base = ahead - np.concatenate(([0.0], np.cumsum(v[:-1]) * _DT))
    length = math.hypot(*_WALK)
    walked = np.minimum(walker_speed * t, length) / length
    # The robot faces -x; seen from its base:
    x, y = base - walked * _WALK[0], walked * _WALK[1] - _BESIDE
    front, rear, half = ROBOT.front_m, ROBOT.rear_m, ROBOT.half_width_m
    outline = np.array([[front, half], [-rear, half], [-rear, -half], [front, -half]])
    return float(gap_to(outline, np.column_stack((x, y))).min()) - body


def bound_rows(distances: list[float]) -> list[dict[str, Any]]:
    """Return what who is told at once could keep, and who sees every 0.1 s, at rest or creeping."""
    creep = SjmcConfig().bystander_end_m_s
    return [
        {
            "distance_m": d, "walker_m_s": s, "at_rest_told_at_once_m": best_gap(d, s, 0.0, ACTS_S),
            "at_rest_told_by_the_next_scan_m": best_gap(d, s, 0.0, ACTS_S + SCAN_S),
            "creeping_told_by_the_next_scan_m": best_gap(d, s, creep, ACTS_S + SCAN_S),
        }
        for d in distances if d > 1.0
        for s in SPEEDS
    ]  # fmt: skip
