"""Where one set of points fits another, found by trying all poses of a window (Olson 2009).

Coarse poses are scored on a field that is as good as the best of the poses they stand for; the
best few, apart from each other, are refined on a fine field.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numba
import numpy as np

from floornav_common.se2 import SE2, wrap_angle

CELL_M = 0.05
COARSE_CELLS = 4
SMEAR_M = 0.1
MAX_POINTS = 250
MARGIN_M = 1.0
APART_M, APART_RAD = 0.5, 0.2
"""Poses nearer than this to each other are of one peak."""
FINE_RAD = 0.01
FINE_STEPS = 3
MAX_CLIMBS = 6
STARTS_A_PEAK = 3
"""Coarse poses refined for each peak: their scores are too kind to tell neighbors apart."""


@dataclass(frozen=True)
class Peak:
    """A pose where the points fit, and how well: the mean score of a point, 0..1."""

    pose: SE2
    score: float


def find_peaks(
    reference: np.ndarray, query: np.ndarray, center: SE2, window: tuple[float, float], num: int
) -> list[Peak]:
    """Return the best poses of the query in the reference's frame, the best first.

    Args:
        reference: Points, shape (N, 2), m.
        query: Points in their own frame, shape (M, 2), m.
        center: Pose round which is searched.
        window: How far to each side (m) and how far round (rad).
        num: Peaks wanted at most; they are `APART_M` or `APART_RAD` apart.
    """
    if not len(reference) or not len(query):
        return []
    query = np.ascontiguousarray(query[:: max(1, -(-len(query) // MAX_POINTS))])
    radius = float(np.quantile(np.hypot(query[:, 0], query[:, 1]), 0.8))
    fine, corner = score_field(reference)
    coarse = cv2.dilate(fine, np.ones((2 * (COARSE_CELLS // 2) + 1,) * 2, np.uint8))
    step = COARSE_CELLS * CELL_M
    turn_step = min(step / max(radius, 1.0), 0.1)
    turns = _steps(window[1], turn_step)
    if window[1] >= np.pi:
        turns = turns[:-1]
    shifts = _steps(window[0], step)
    scores = _scores(
        coarse, corner, query, center.as_array(), turns, len(shifts) // 2, COARSE_CELLS
    )
    starts = _starts(scores, center, turns, shifts, STARTS_A_PEAK * num)
    refined = [refined_peak(fine, corner, query, pose, step, turn_step) for pose in starts]
    peaks: list[Peak] = []
    for peak in sorted(refined, key=lambda peak: -peak.score):
        off = np.abs(peak.pose.as_array()[:2] - center.as_array()[:2])
        is_inside = float(off.max()) <= window[0] + step
        if is_inside and all(not is_same_peak(peak.pose, other.pose) for other in peaks):
            peaks.append(peak)
    return peaks[:num]


def is_same_peak(a: SE2, b: SE2) -> bool:
    """Tell whether two poses are of one peak."""
    is_near = np.hypot(a.x - b.x, a.y - b.y) < APART_M
    return bool(is_near and abs(wrap_angle(a.yaw - b.yaw)) < APART_RAD)


def _steps(reach: float, step: float) -> np.ndarray:
    num = int(np.ceil(reach / step - 1e-9))
    return np.arange(-num, num + 1) * step


def score_field(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the score of each cell (uint8), 255 on a point, and the (x, y) of its corner."""
    corner = points.min(axis=0) - MARGIN_M
    cols, rows = (
        np.ceil((points.max(axis=0) + MARGIN_M - corner) / CELL_M).astype(int) + 1
    ).tolist()
    cells = np.floor((points - corner) / CELL_M).astype(int)
    is_free = np.ones((rows, cols), np.uint8)
    is_free[cells[:, 1], cells[:, 0]] = 0
    distance = cv2.distanceTransform(is_free, cv2.DIST_L2, 3) * CELL_M
    return np.rint(255.0 * np.exp(-0.5 * (distance / SMEAR_M) ** 2)).astype(np.uint8), corner


def _starts(
    scores: np.ndarray, center: SE2, turns: np.ndarray, shifts: np.ndarray, num: int
) -> list[SE2]:
    """Return the poses of the best coarse scores, none beside a better one."""
    left = scores.copy()
    starts: list[SE2] = []
    for _ in range(num):
        k, r, c = (int(index) for index in np.unravel_index(int(np.argmax(left)), left.shape))
        if left[k, r, c] <= 0.0:
            break
        shift = np.array([shifts[c], shifts[r], turns[k]])
        starts.append(SE2(*(float(v) for v in center.as_array() + shift)))
        left[max(0, k - 1) : k + 2, max(0, r - 1) : r + 2, max(0, c - 1) : c + 2] = 0.0
    return starts


def refined_peak(
    field: np.ndarray, corner: np.ndarray, query: np.ndarray, pose: SE2, step: float, turn: float
) -> Peak:
    """Return the best pose round a coarse one, followed uphill as far as it goes."""
    turns = _steps(turn, max(FINE_RAD, turn / FINE_STEPS))
    shifts = _steps(0.5 * step + CELL_M, CELL_M)
    middle = (len(turns) // 2, len(shifts) // 2, len(shifts) // 2)
    score = 0.0
    for _ in range(MAX_CLIMBS):
        scores = _scores(field, corner, query, pose.as_array(), turns, middle[1], 1)
        k, r, c = (int(i) for i in np.unravel_index(int(np.argmax(scores)), scores.shape))
        score = float(scores[k, r, c]) / 255.0
        if (k, r, c) == middle:
            break
        pose = SE2(*(float(v) for v in pose.as_array() + (shifts[c], shifts[r], turns[k])))
    return Peak(pose, score)


@numba.njit(cache=True)
def _scores(field, corner, query, center, turns, num, stride):  # type: ignore[no-untyped-def]
    """Return the mean score of the points at every pose, shape (turns, y shifts, x shifts).

    Shifts go from `-num` to `num` strides of so many cells.
    """
    rows, cols = field.shape
    size = 2 * num + 1
    sums = np.zeros((len(turns), size, size), np.int32)
    for k in range(len(turns)):
        c, s = np.cos(center[2] + turns[k]), np.sin(center[2] + turns[k])
        for i in range(len(query)):
            x = c * query[i, 0] - s * query[i, 1] + center[0] - corner[0]
            y = s * query[i, 0] + c * query[i, 1] + center[1] - corner[1]
            first_row = int(np.floor(y / CELL_M)) - num * stride
            first_col = int(np.floor(x / CELL_M)) - num * stride
            low = max(0, -(first_col // stride))
            high = min(size, (cols - 1 - first_col) // stride + 1)
            for r in range(size):
                row = first_row + r * stride
                if 0 <= row < rows:
                    for q in range(low, high):
                        sums[k, r, q] += field[row, first_col + q * stride]
    return sums.astype(np.float32) / np.float32(len(query))
