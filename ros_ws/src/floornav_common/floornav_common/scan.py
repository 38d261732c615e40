"""A planar range scan without ROS: what LaserScan carries, as numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.twists import Twist, steady_offsets


@dataclass(frozen=True)
class Scan:
    """One sweep of a planar range finder, in its own frame (REP 117).

    A sensor that moves while it sweeps sees each beam from another place. With its `twist` known,
    angles, origins and points are seen from where it was at the first beam: a turn adds to the
    angle from beam to beam, all else to where beams begin.

    Attributes:
        ranges: Shape (N,), m. `+inf` nothing within range, `-inf` too near, NaN not measured.
        angle_min: Bearing of the first beam, rad.
        angle_increment: Bearing step from beam to beam, rad; negative for a clockwise sensor.
        range_min: Shortest range that is a measurement, m.
        range_max: Longest range that is a measurement, m.
        time_increment: Time between beams, s; 0 if all are taken at once.
        twist: Of the sensor during the sweep, see `twists`; None where that is not known, or none.
    """

    ranges: np.ndarray
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    time_increment: float = 0.0
    twist: Twist | None = None

    @property
    def angle_step(self) -> float:
        """Bearing step from beam to beam in the frame of the first, rad."""
        if self.twist is None:
            return self.angle_increment
        return self.angle_increment + self.twist[2] * self.time_increment

    @property
    def angles(self) -> np.ndarray:
        """Bearing of each beam, shape (N,), rad."""
        return self.angle_min + self.angle_step * np.arange(len(self.ranges))

    @property
    def sweep_s(self) -> float:
        """Time from the first to the last beam, s."""
        return self.time_increment * max(len(self.ranges) - 1, 0)

    def origins(self) -> np.ndarray | None:
        """Return where each beam begins, shape (N, 2), m; None if all do at (0, 0)."""
        if self.twist is None:
            return None
        return steady_offsets(self.twist, self.time_increment * np.arange(len(self.ranges)))

    @property
    def is_hit(self) -> np.ndarray:
        """Mask of beams that measured an obstacle, shape (N,), bool."""
        ranges = self.ranges
        with np.errstate(invalid="ignore"):
            inside = (ranges >= self.range_min) & (ranges <= self.range_max)
        return inside & np.isfinite(ranges) & (ranges > 0.0)

    def points(self) -> np.ndarray:
        """Return the obstacle points in the sensor frame, shape (M, 2), m."""
        hit = self.is_hit
        ranges, angles = self.ranges[hit], self.angles[hit]
        points = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
        origins = self.origins()
        return points if origins is None else points + origins[hit]
