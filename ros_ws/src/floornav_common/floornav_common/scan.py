"""A planar range scan without ROS: what LaserScan carries, as numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Scan:
    """One sweep of a planar range finder, in its own frame (REP 117).

    Attributes:
        ranges: Shape (N,), m. `+inf` nothing within range, `-inf` too near, NaN not measured.
        angle_min: Bearing of the first beam, rad.
        angle_increment: Bearing step from beam to beam, rad; negative for a clockwise sensor.
        range_min: Shortest range that is a measurement, m.
        range_max: Longest range that is a measurement, m.
        time_increment: Time between beams, s; 0 if all are taken at once.
    """

    ranges: np.ndarray
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    time_increment: float = 0.0

    @property
    def angles(self) -> np.ndarray:
        """Bearing of each beam, shape (N,), rad."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges))

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
        return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
