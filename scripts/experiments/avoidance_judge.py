"""What is measured of one drive: collision, time, way, clearance, and when the turn began."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.avoidance_fields import ROBOT_RADIUS, Field
from floornav_common.se2 import SE2

TURN_RAD = math.radians(5.0)
MOVING = 0.05
TRACK_S = 1.0 / 3.0
_GIVE_UP_S, _NEARER_M = 6.0, 0.05  # without coming nearer to the goal than ever before


@dataclass(frozen=True)
class Run:
    """What came of it.

    Attributes:
        field: Where.
        is_reached: Whether the robot came to stand at the goal.
        has_collided: Whether it touched anything.
        time_s: Until it stood there, touched something, or gave up.
        path_m: Way driven.
        min_clearance_m: Least distance between the robot and anything.
        turn_start_s: When its velocity was first 5 degrees off the goal; None if never.
        track: Places x, y every 1/3 s, shape (N, 2).
        path: The same at every step, shape (M, 2).
    """

    field: Field
    is_reached: bool
    has_collided: bool
    time_s: float
    path_m: float
    min_clearance_m: float
    turn_start_s: float | None
    track: np.ndarray
    path: np.ndarray


class Judge:
    """Watches one drive by the truth of the simulation.

    Args:
        field: Where it is.
        solids: All that can be touched, each with `signed_distance(points)`.
    """

    def __init__(self, field: Field, solids: Sequence[Any]) -> None:
        self._field, self._solids = field, solids
        self._times: list[float] = [0.0]
        self._path: list[tuple[float, float]] = [field.start]
        self._turn_start: float | None = None
        self._nearest, self._nearer_at = math.inf, 0.0
        self.has_touched = False

    @property
    def has_given_up(self) -> bool:
        """Whether the robot came no nearer to the goal for 6 s."""
        return self._times[-1] - self._nearer_at > _GIVE_UP_S

    def note(self, time_s: float, pose: SE2, velocity: Sequence[float], is_touching: bool) -> None:
        """Take what is so after a step; velocity is (forward, left), m/s."""
        self._times.append(time_s)
        self._path.append((pose.x, pose.y))
        self.has_touched = self.has_touched or is_touching
        x, y = self._field.goal[0] - pose.x, self._field.goal[1] - pose.y
        if math.hypot(x, y) < self._nearest - _NEARER_M:
            self._nearest, self._nearer_at = math.hypot(x, y), time_s
        if self._turn_start is not None or math.hypot(*velocity) < MOVING:
            return
        bearing = math.atan2(velocity[1], velocity[0]) + pose.yaw
        off = math.remainder(bearing - math.atan2(y, x), 2.0 * math.pi)
        if abs(off) > TURN_RAD:
            self._turn_start = time_s

    def result(self, is_reached: bool) -> Run:
        """Return what came of it; a drive ends where it first touches anything."""
        path, times = np.array(self._path), np.array(self._times)
        clearance = np.min([s.signed_distance(path) for s in self._solids], axis=0) - ROBOT_RADIUS
        num = int(np.argmax(clearance <= 0.0)) + 1 if (clearance <= 0.0).any() else len(path)
        has_collided = self.has_touched or num < len(path) or bool(clearance[-1] <= 0.0)
        path, end = path[:num], float(times[num - 1])
        turn = self._turn_start
        return Run(
            field=self._field, is_reached=is_reached and not has_collided,
            has_collided=has_collided, time_s=end,
            path_m=float(np.hypot(*np.diff(path, axis=0).T).sum()),
            min_clearance_m=float(clearance[:num].min()),
            turn_start_s=turn if turn is not None and turn <= end else None,
            track=path[np.unique(np.searchsorted(times[:num], np.arange(0.0, end, TRACK_S)))],
            path=path,
        )  # fmt: skip


def median(values: Sequence[float]) -> float | None:
    """Return the median; None of nothing."""
    return float(np.median(values)) if values else None


def figures(runs: Sequence[Run]) -> dict[str, Any]:
    """Return the figures of some drives; times and ways are of those that reached the goal."""
    there = [r for r in runs if r.is_reached]
    return {
        "collisions": sum(r.has_collided for r in runs),
        "runs": len(runs),
        "reached": len(there),
        "time_s": median([r.time_s for r in there]),
        "path_m": median([r.path_m for r in there]),
        "min_clearance_m": min((r.min_clearance_m for r in runs), default=None),
        "median_clearance_m": median([r.min_clearance_m for r in runs]),
        "turn_start_s": median([r.turn_start_s for r in runs if r.turn_start_s is not None]),
    }


def turns(pairs: Sequence[tuple[Run, Run]]) -> dict[str, Any]:
    """Return in how many fields the turn begins earlier with velocity, and by how much.

    Args:
        pairs: Drives of the same field with velocity and without; one that never turned is left
            out.
    """
    leads = [
        static.turn_start_s - aware.turn_start_s
        for aware, static in pairs
        if aware.turn_start_s is not None and static.turn_start_s is not None
    ]
    lead = np.round(np.array(leads), 3)
    return {
        "fields": len(lead), "earlier": int((lead > 0).sum()), "later": int((lead < 0).sum()),
        "mean_lead_s": float(lead.mean()) if len(lead) else None,
    }  # fmt: skip
