"""Danger, Caution and Safety Zone (SJMC thesis, 3.4.3)."""

from __future__ import annotations

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
