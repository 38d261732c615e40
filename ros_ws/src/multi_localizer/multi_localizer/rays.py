"""Where two rays meet."""

from __future__ import annotations

import numpy as np

_PARALLEL = 1e-6


def crossing(
    p: np.ndarray, along_p: float, q: np.ndarray, along_q: float, least: float = _PARALLEL
) -> np.ndarray | None:
    """Return where two rays meet, (2,); None if they do not.

    Args:
        p: Where the first begins, (2,).
        along_p: Its direction, rad.
        q: Where the second begins, (2,).
        along_q: Its direction, rad.
        least: Sine of the angle between them below which they count as parallel.
    """
    u = np.array([np.cos(along_p), np.sin(along_p)])
    v = np.array([np.cos(along_q), np.sin(along_q)])
    det = u[0] * v[1] - u[1] * v[0]
    if abs(det) < least:
        return None
    gap = q - p
    far_p = (gap[0] * v[1] - gap[1] * v[0]) / det
    far_q = (gap[0] * u[1] - gap[1] * u[0]) / det
    if far_p <= 0.0 or far_q <= 0.0:
        return None
    return np.asarray(p + far_p * u)
