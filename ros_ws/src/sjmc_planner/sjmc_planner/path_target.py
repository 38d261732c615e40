"""Where on a path to head for: a point some way ahead of the nearest one (Coulter 1992)."""

from __future__ import annotations

import numpy as np

from floornav_common.se2 import SE2
from sjmc_planner.planning import Goal

_WINDOW = 1.0  # how far ahead the nearest point is looked for, so that a crossing is no short cut


class PathTarget:
    """Progress along one path.

    Args:
        points: Of the path, shape (N, 2), m; a single one is a goal to go straight for.
        lookahead: How far ahead of the nearest point to head for, m.

    Raises:
        ValueError: If there is no point, or one is not finite.
    """

    def __init__(self, points: np.ndarray, lookahead: float) -> None:
        if points.ndim != 2 or points.shape[1] != 2 or not len(points):
            raise ValueError(f"points must be (N, 2) with N >= 1, got {points.shape}")
        if not np.isfinite(points).all():
            raise ValueError("points must be finite")
        steps = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.zeros(0)
        self._points, self._lookahead = points, lookahead
        self._along = np.concatenate(([0.0], np.cumsum(steps)))
        self._done = 0.0

    @property
    def end(self) -> tuple[float, float]:
        """Where it leads, m."""
        return float(self._points[-1, 0]), float(self._points[-1, 1])

    def goal(self, T_path_base: SE2) -> Goal:
        """Return where to head for, seen from a pose; remembers how far the robot came."""
        here = np.array([T_path_base.x, T_path_base.y])
        self._done = self._nearest(here)
        target = self._at(self._done + self._lookahead)
        end = float(np.hypot(*(self._points[-1] - here)))
        point = (T_path_base.inverse() @ target[None])[0]
        return Goal(point, max(end, float(self._along[-1]) - self._done))

    def _at(self, along: float) -> np.ndarray:
        return np.array([np.interp(along, self._along, self._points[:, k]) for k in (0, 1)])

    def _nearest(self, here: np.ndarray) -> float:
        """Return how far along the path the nearest point of the window is."""
        end = min(self._done + _WINDOW + self._lookahead, float(self._along[-1]))
        inner = self._along[(self._along > self._done) & (self._along < end)]
        along = np.concatenate(([self._done], inner, [end]))
        points = np.column_stack(
            [np.interp(along, self._along, self._points[:, k]) for k in (0, 1)]
        )
        leg = np.diff(points, axis=0)
        length2 = np.maximum((leg**2).sum(axis=1), 1e-12)
        share = np.clip(((here - points[:-1]) * leg).sum(axis=1) / length2, 0.0, 1.0)
        distance = np.hypot(*(points[:-1] + share[:, None] * leg - here).T)
        best = int(distance.argmin())
        return float(along[best] + share[best] * (along[best + 1] - along[best]))
