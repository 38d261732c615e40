"""The first three stages of VFH+: primary, binary and masked polar histogram.

Ulrich and Borenstein 1998, "VFH+: Reliable obstacle avoidance for fast mobile robots", ICRA.
Sector k lies about the bearing k alpha of the robot's frame, alpha = 2 pi / number of sectors,
counted counter-clockwise from straight ahead.

Magnitudes are given in units of one sure cell at the window's border: c is a share of the highest
certainty, and a - b d^2 is 1 there as in the paper.
"""

from __future__ import annotations

import math

import numba
import numpy as np

_TURN = 2.0 * math.pi


def primary_histogram(
    points: np.ndarray, certainty: np.ndarray, enlarged_by: float, reach: float,
    near_weight: float, num: int,
) -> np.ndarray:  # fmt: skip
    """Return the obstacle density of each sector, obstacles enlarged by the robot.

    Args:
        points: Middles of the occupied cells, in the base frame, shape (M, 2), m.
        certainty: Of each, in (0, 1], shape (M,).
        enlarged_by: The robot's radius and the air to keep (r_r+s), m.
        reach: Radius of the window, m; cells farther do not count.
        near_weight: Weight of a cell at the robot (a).
        num: Number of sectors.
    """
    return np.asarray(_primary(points, certainty, enlarged_by, reach, near_weight, num))


def binary_histogram(
    primary: np.ndarray, before: np.ndarray, low: float, high: float
) -> np.ndarray:
    """Return which sectors are blocked, with hysteresis, shape (num,), bool.

    Args:
        primary: The primary histogram, shape (num,).
        before: The binary histogram of the step before, shape (num,), bool.
        low: Below this a sector is open (tau_low).
        high: Above this it is blocked (tau_high).
    """
    return (primary > high) | (before & (primary >= low))


def mask_limits(
    points: np.ndarray, heading: float, turn_radius: float, enlarged_by: float
) -> tuple[float, float]:
    """Return how far to the right and to the left of its heading the robot can turn.

    The robot turns on circles that touch its heading; a cell that comes within `enlarged_by` of
    one blocks everything beyond its own bearing to that side.

    Args:
        points: Middles of the occupied cells, in the base frame, shape (M, 2), m.
        heading: Direction of motion (theta), rad.
        turn_radius: Of the circles (r_r and r_l), m; 0 for a robot that can turn where it is.
        enlarged_by: r_r+s, m.

    Returns:
        Angles from the heading, (phi_r in [-pi, 0], phi_l in [0, pi]).
    """
    if turn_radius <= 0.0:
        return -math.pi, math.pi
    right, left = _limits(points, heading, turn_radius, enlarged_by)
    return float(right), float(left)


def masked_histogram(
    is_blocked: np.ndarray, heading: float, limits: tuple[float, float]
) -> np.ndarray:
    """Return which sectors are blocked or cannot be turned to, shape (num,), bool.

    Args:
        is_blocked: The binary histogram, shape (num,), bool.
        heading: Direction of motion, rad.
        limits: From `mask_limits`.
    """
    return np.asarray(_masked(is_blocked, heading, *limits))


@numba.njit(cache=True, nogil=True)
def _primary(points, certainty, enlarged_by, reach, near_weight, num):  # type: ignore[no-untyped-def]
    alpha = 2.0 * np.pi / num
    histogram = np.zeros(num)
    b = (near_weight - 1.0) / (reach * reach)  # a - b reach^2 = 1
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        d2 = x * x + y * y
        if d2 > reach * reach:
            continue
        magnitude = certainty[i] * certainty[i] * (near_weight - b * d2)  # c^2 (a - b d^2)
        bearing = np.arctan2(y, x)  # beta
        d = np.sqrt(d2)
        half = np.arcsin(enlarged_by / d) if d > enlarged_by else 0.5 * np.pi  # gamma
        first = int(np.ceil((bearing - half) / alpha - 1e-9))
        last = int(np.floor((bearing + half) / alpha + 1e-9))
        for k in range(first, min(last, first + num - 1) + 1):
            histogram[k % num] += magnitude
    return histogram


@numba.njit(cache=True, nogil=True)
def _limits(points, heading, turn_radius, enlarged_by):  # type: ignore[no-untyped-def]
    c, s = np.cos(heading), np.sin(heading)
    right, left = -np.pi, np.pi
    near2 = (turn_radius + enlarged_by) ** 2
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        x, y = c * px + s * py, c * py - s * px
        if y <= 0.0 and x * x + (y + turn_radius) ** 2 < near2:  # condition 1
            right = max(right, -abs(np.arctan2(y, x)))
        if y >= 0.0 and x * x + (y - turn_radius) ** 2 < near2:  # condition 2
            left = min(left, abs(np.arctan2(y, x)))
    return right, left


@numba.njit(cache=True, nogil=True)
def _masked(is_blocked, heading, right, left):  # type: ignore[no-untyped-def]
    masked = is_blocked.copy()
    for k in range(len(masked)):
        off = k * (_TURN / len(masked)) - heading
        off -= _TURN * np.rint(off / _TURN)
        is_in = off <= left + 1e-9 and off >= right - 1e-9
        off -= np.copysign(_TURN, off)  # straight behind is to the left and to the right
        masked[k] |= not (is_in or (off <= left + 1e-9 and off >= right - 1e-9))
    return masked
