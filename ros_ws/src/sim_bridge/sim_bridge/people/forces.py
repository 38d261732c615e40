"""The social force model of Helbing and Molnar (1995): how people keep apart and off walls."""

from __future__ import annotations

import numpy as np

from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.obstacles import Obstacles

_BEHIND_WEIGHT = 0.5  # c, Helbing and Molnar's table of parameters
_NEAREST = 1e-3


def push_between(
    config: PeopleConfig, positions: np.ndarray, others: np.ndarray, velocities: np.ndarray
) -> np.ndarray:
    """Return the acceleration by which each other person repels each person (eq. 3, 4 there).

    The potential falls with the half minor axis b of an ellipse that reaches one foreseen step of
    the other ahead of it.

    Args:
        config: V0, sigma and the foreseen time.
        positions: Who is repelled, shape (N, 2).
        others: Who repels, shape (M, 2); at the same place as a person = that person itself.
        velocities: Of the others, shape (M, 2).

    Returns:
        Shape (N, M, 2), m/s^2.
    """
    r = positions[:, None, :] - others[None, :, :]
    step = config.people_ahead_s * velocities
    moved = r - step
    near, far = (np.maximum(np.linalg.norm(v, axis=2), _NEAREST) for v in (r, moved))
    reach = near + far
    length = np.linalg.norm(step, axis=1)
    b = 0.5 * np.sqrt(np.maximum(reach**2 - length**2, _NEAREST**2))
    grad = (reach / (4.0 * b))[..., None] * (r / near[..., None] + moved / far[..., None])
    size = config.people_push_m2_s2 / config.people_range_m * np.exp(-b / config.people_range_m)
    push = size[..., None] * grad
    return np.where((near > 10.0 * _NEAREST)[..., None], push, 0.0)


def seen_share(config: PeopleConfig, push: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return pushes (N, M, 2), halved where they come from outside the field of view.

    Args:
        config: The field of view.
        push: Accelerations.
        wanted: Unit vectors in which people want to go, shape (N, 2).
    """
    ahead = -(push * wanted[:, None, :]).sum(axis=2)
    limit = np.linalg.norm(push, axis=2) * np.cos(config.view_rad / 2.0)
    return push * np.where(ahead >= limit, 1.0, _BEHIND_WEIGHT)[..., None]


def push_of_walls(config: PeopleConfig, positions: np.ndarray, obstacles: Obstacles) -> np.ndarray:
    """Return the acceleration by which the nearest solid repels each person, (N, 2) (eq. 5)."""
    distance, away = obstacles.away(positions)
    if not distance.shape[1]:
        return np.zeros_like(positions)
    nearest = distance.argmin(axis=1)
    rows = np.arange(len(positions))
    size = np.exp(-distance[rows, nearest] / config.wall_range_m)
    size *= config.wall_push_m2_s2 / config.wall_range_m
    return np.asarray(size[:, None] * away[rows, nearest])


def kept_apart(positions: np.ndarray, others: np.ndarray, least: float) -> np.ndarray:
    """Return positions (N, 2) with each moved off others (M, 2) that are nearer than `least`.

    Bodies do not pass through each other, which the forces alone do not see to; each gives way by
    half of what is missing. An other at the same place is the person itself.
    """
    off = positions[:, None, :] - others[None, :, :]
    distance = np.linalg.norm(off, axis=2)
    missing = np.where(distance > _NEAREST, np.maximum(least - distance, 0.0), 0.0)
    unit = off / np.maximum(distance, _NEAREST)[..., None]
    return np.asarray(positions + 0.5 * (missing[..., None] * unit).sum(axis=1))
