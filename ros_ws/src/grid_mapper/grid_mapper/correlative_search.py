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
    fine, corner = _field(reference)
    coarse = cv2.dilate(fine, np.ones((2 * (COARSE_CELLS // 2) + 1,) * 2, np.uint8))
    step = COARSE_CELLS * CELL_M
    turn_step = min(step / max(radius, 1.0), 0.1)
    turns = _steps(window[1], turn_step)
    if window[1] >= np.pi:
        turns = turns[:-1]
    shifts = _steps(window[0], step)
    scores = _scores(coarse, corner, query, center.as_array(), turns, shifts)
    peaks: list[Peak] = []
    for pose in _apart(scores, center, turns, shifts, num):
        refined = _refined(fine, corner, query, pose, step, turn_step)
        if all(not is_same_peak(refined.pose, other.pose) for other in peaks):
            peaks.append(refined)
    return sorted(peaks, key=lambda peak: -peak.score)


def is_same_peak(a: SE2, b: SE2) -> bool:
    """Tell whether two poses are of one peak."""
    is_near = np.hypot(a.x - b.x, a.y - b.y) < APART_M
    return bool(is_near and abs(wrap_angle(a.yaw - b.yaw)) < APART_RAD)


def _steps(reach: float, step: float) -> np.ndarray:
    num = int(np.ceil(reach / step - 1e-9))
    return np.arange(-num, num + 1) * step


def _field(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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


def _apart(
    scores: np.ndarray, center: SE2, turns: np.ndarray, shifts: np.ndarray, num: int
) -> list[SE2]:
    """Return the poses of the best scores that are apart from each other."""
    order = np.argsort(-scores, axis=None, kind="stable")
    found: list[SE2] = []
    for flat in order[: 200 * num]:
        k, r, c = (int(index) for index in np.unravel_index(flat, scores.shape))
        pose = SE2(center.x + shifts[c], center.y + shifts[r], center.yaw + turns[k])
        if all(not is_same_peak(pose, other) for other in found):
            found.append(pose)
            if len(found) == num:
                break
    return found


def _refined(
    field: np.ndarray, corner: np.ndarray, query: np.ndarray, pose: SE2, step: float, turn: float
) -> Peak:
    turns = _steps(turn, max(FINE_RAD, turn / FINE_STEPS))
    shifts = _steps(0.5 * step + CELL_M, CELL_M)
    scores = _scores(field, corner, query, pose.as_array(), turns, shifts)
    k, r, c = np.unravel_index(int(np.argmax(scores)), scores.shape)
    best = SE2(pose.x + shifts[c], pose.y + shifts[r], pose.yaw + turns[k])
    return Peak(best, float(scores[k, r, c]) / 255.0)


@numba.njit(cache=True)
def _scores(field, corner, query, center, turns, shifts):  # type: ignore[no-untyped-def]
    """Return the mean score of the points at every pose, shape (turns, y shifts, x shifts)."""
    rows, cols = field.shape
    scores = np.zeros((len(turns), len(shifts), len(shifts)), np.float32)
    num = len(shifts)
    for k in range(len(turns)):
        c, s = np.cos(center[2] + turns[k]), np.sin(center[2] + turns[k])
        for i in range(len(query)):
            x = c * query[i, 0] - s * query[i, 1] + center[0] - corner[0]
            y = s * query[i, 0] + c * query[i, 1] + center[1] - corner[1]
            for r in range(num):
                row = int(np.floor((y + shifts[r]) / CELL_M))
                if row < 0 or row >= rows:
                    continue
                for q in range(num):
                    col = int(np.floor((x + shifts[q]) / CELL_M))
                    if 0 <= col < cols:
                        scores[k, r, q] += field[row, col]
    return scores / np.float32(len(query))
