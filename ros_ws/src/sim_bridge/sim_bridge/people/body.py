"""What sensors see of a person: two legs that step, and a torso."""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.people.config import PeopleConfig
from sim_bridge.solids import Solid

_TROUSERS = ((0.20, 0.24, 0.36), (0.30, 0.28, 0.26), (0.16, 0.16, 0.18))
_SHIRTS = ((0.75, 0.30, 0.25), (0.25, 0.50, 0.70), (0.85, 0.75, 0.35), (0.45, 0.65, 0.45))


def foot_offsets(config: PeopleConfig, walked: float) -> np.ndarray:
    """Return where the legs are in the person's frame (x forward), (2, 2): left, right.

    A foot on the ground stays where it is while the body goes on by one step; meanwhile the
    other swings from one step behind to one step ahead. Half a step of standing time each.

    Args:
        config: Body.
        walked: Distance walked so far, m.
    """
    phase = (walked / config.step_m + 0.5) % 2.0
    # The left foot stands while phase is 0..1, the right one while it is 1..2.
    ahead = 0.5 - phase if phase < 1.0 else phase - 1.5
    along = config.step_m * np.array([ahead, -ahead])
    return np.column_stack((along, np.array([0.5, -0.5]) * config.leg_gap_m))


def body_parts(config: PeopleConfig, number: int) -> list[Solid]:
    """Return a person's solids around the origin: left leg, right leg, torso; or one body."""
    shirt, trousers = _SHIRTS[number % len(_SHIRTS)], _TROUSERS[number % len(_TROUSERS)]
    origin, leg, torso = SE2.identity(), 2.0 * config.leg_radius_m, 2.0 * config.torso_radius_m
    if not config.has_legs:
        size = (torso, torso, config.height_m)
        return [Solid("person", origin, size, 0.0, True, shirt, surface="cloth")]
    legs = [
        Solid(
            "leg", origin, (leg, leg, config.torso_bottom_m), 0.0, True, trousers, surface="cloth"
        )
        for _ in range(2)
    ]
    size = (torso, torso, config.height_m - config.torso_bottom_m)
    return [
        *legs,
        Solid("torso", origin, size, config.torso_bottom_m, True, shirt, surface="cloth"),
    ]


def part_places(config: PeopleConfig, pose: SE2, walked: float) -> np.ndarray:
    """Return where the parts of `body_parts` are in the world, shape (parts, 2), m."""
    middle = np.array([[pose.x, pose.y]])
    if not config.has_legs:
        return middle
    return np.vstack((pose @ foot_offsets(config, walked), middle))
