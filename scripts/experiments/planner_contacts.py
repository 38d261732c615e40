"""How far a robot's outline is from people, and whose doing a contact is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

MOVING = 0.05  # m/s


def gap_to(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return how far points are from a convex outline, negative inside.

    Args:
        corners: Of the outline, counter-clockwise or clockwise, shape (C, 2), m.
        points: Shape (N, 2), m.

    Returns:
        Shape (N,), m.
    """
    starts, edges = corners, np.roll(corners, -1, axis=0) - corners
    off = points[:, None, :] - starts[None]
    along = np.clip((off * edges).sum(-1) / (edges**2).sum(-1), 0.0, 1.0)
    distance = np.linalg.norm(off - along[..., None] * edges, axis=-1).min(axis=1)
    side = edges[:, 0] * off[..., 1] - edges[:, 1] * off[..., 0]
    is_inside = (side > 0.0).all(axis=1) | (side < 0.0).all(axis=1)
    return np.where(is_inside, -distance, distance)


def is_by_robot(
    outline: np.ndarray, place: np.ndarray, velocity: Sequence[float], yaw_rate: float = 0.0
) -> bool:
    """Tell whether a contact with a person is the robot's doing.

    Args:
        outline: Of the robot in its own frame, shape (C, 2), m.
        place: Of the person there, shape (2,), m.
        velocity: Of the robot, forward and left, m/s.
        yaw_rate: Of the robot, rad/s.
    """
    low, high = outline.min(axis=0), outline.max(axis=0)
    if math.hypot(*velocity) > MOVING and place[0] > 0.5 * (low[0] + high[0]):
        return True
    nearest = np.clip(place, low, high)
    off = place - nearest
    if not off.any():  # the torso's middle is in the robot
        off = place - 0.5 * (low + high)
    at_point = np.array(velocity) + yaw_rate * np.array([-nearest[1], nearest[0]])
    return bool(off @ at_point > MOVING * float(np.hypot(*off)))
