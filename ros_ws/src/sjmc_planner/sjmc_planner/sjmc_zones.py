"""Danger, Caution and Safety Zone (SJMC thesis, 3.4.3), and the obstacle that counts."""

from __future__ import annotations

import numpy as np

DANGER, CAUTION, SAFETY = "danger", "caution", "safety"


def zone_of(distance: float, danger: float, caution: float) -> str:
    """Return the zone that an obstacle at a distance is in.

    Args:
        distance: To it (l_Ro), m.
        danger: L_DANGER, m.
        caution: L_CAUTION, m.
    """
    if distance <= danger:  # eq. 3.1
        return DANGER
    if distance <= caution:  # eq. 3.2
        return CAUTION
    return SAFETY  # eq. 3.3


def target_obstacle(distances: np.ndarray, is_in_region: np.ndarray) -> int:
    """Return the obstacle that counts (o_f): the nearest in D; -1 if D is empty.

    Args:
        distances: To each obstacle (l_Roi), shape (N,), m.
        is_in_region: Which of them lie in D, shape (N,), bool.
    """
    if not is_in_region.any():
        return -1
    return int(np.argmin(np.where(is_in_region, distances, np.inf)))
