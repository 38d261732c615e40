"""What stood nearer than the sensor sees: remembered from when it was farther away.

A mirror camera sees its own robot, and many lasers see nothing, up to `range_min`; what comes
nearer is only known to be near (`-inf`). Taken for touching, it closes half of all directions, and
a robot would not pass gaps twice its width. So the ends of near beams are kept and moved along with
the robot; a beam that now says `-inf` takes the distance of what was there, if that is as near as
the beam says: with a wall remembered farther away, something else has come. What a beam sees again,
or sees through, is forgotten, and so is what the robot has come too far from to be sure of.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from sjmc_planner.growth import Wedges

_NOISE = 0.03  # beyond range_min: this far off what is remembered may be, m
_BAND = 0.25  # beyond range_min: how near a beam must end to be kept, m
_TRAVEL = 0.5  # after which odometry is no longer trusted, m
_BESIDE = 0.1  # a beam takes what is remembered up to this beside it, rad
_MAX_WIDTH = 0.6  # wider wedges, such as a blind rear, end nowhere, rad


class NearMemory:
    """Points that stood near, in the base frame."""

    def __init__(self) -> None:
        self._points = np.zeros((0, 2))
        self._travel = np.zeros(0)

    def update(self, wedges: Wedges, moved: SE2) -> Wedges:
        """Return the wedges with what is remembered in place of what is too near to see.

        Args:
            wedges: Of the newest scan; ranges of 0 are too near.
            moved: The robot's motion since the last call: where it is, seen from where it was.
        """
        self._travel = self._travel + moved.distance
        is_sure = self._travel < _TRAVEL
        self._points = (moved.inverse() @ self._points)[is_sure]
        self._travel = self._travel[is_sure]
        filled = self._filled(wedges, np.flatnonzero(wedges.ranges == 0.0))
        ends = wedges.T_base_sensor @ _near_ends(wedges)
        self._points = np.concatenate((self._points, ends))
        self._travel = np.concatenate((self._travel, np.zeros(len(ends))))
        return filled

    def _filled(self, wedges: Wedges, blind: np.ndarray) -> Wedges:
        """Answer for the blind wedges, and keep only what lies in one of them and is near."""
        points = wedges.T_base_sensor.inverse() @ self._points
        distance, bearing = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
        middle = wedges.start[blind] + 0.5 * wedges.width[blind]
        off = np.remainder(bearing[None] - middle[:, None] + np.pi, 2.0 * np.pi) - np.pi
        beside = np.abs(off) - 0.5 * wedges.width[blind][:, None]
        is_near = distance <= wedges.blind + _NOISE
        is_kept = is_near & (beside <= 0.0).any(axis=0)
        self._points, self._travel = self._points[is_kept], self._travel[is_kept]
        is_there = is_near & (beside <= _BESIDE)
        nearest = np.where(is_there, distance, np.inf).min(axis=1, initial=np.inf)
        ranges = wedges.ranges.copy()
        ranges[blind] = np.where(np.isfinite(nearest), np.minimum(nearest, wedges.blind), 0.0)
        return replace(wedges, ranges=ranges)


def _near_ends(wedges: Wedges) -> np.ndarray:
    """Return points along the fronts of near wedges, from the sensor, shape (K, 2), m."""
    is_near = (wedges.ranges > 0.0) & (wedges.ranges < wedges.blind + _BAND)
    is_near &= wedges.width < _MAX_WIDTH
    share = np.array([0.0, 0.5, 1.0])
    angles = wedges.start[is_near, None] + wedges.width[is_near, None] * share
    r = wedges.ranges[is_near, None]
    return np.stack((r * np.cos(angles), r * np.sin(angles)), axis=-1).reshape(-1, 2)
