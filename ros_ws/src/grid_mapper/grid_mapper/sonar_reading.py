"""What a sonar's message says: an echo, free space, or nothing (REP 117, sensor_msgs/Range).

| range | means |
| --- | --- |
| NaN, 0, negative | nothing: no measurement |
| `-inf` | nothing: too near to measure |
| below `min_range` | nothing: Range.msg wants it discarded |
| from `min_range` to below `max_range` | an echo there |
| `max_range` | free: many drivers send it where they heard nothing |
| above `max_range` | nothing: Range.msg wants it discarded |
| `+inf` | free: nothing within reach |
| fixed distance (`min_range == max_range`), `-inf` | an echo at that distance, the most it can be |
| fixed distance, `+inf` | free up to it |
| fixed distance, any number | nothing: such a ranger sends only `inf` |
| `max_range` not above 0, limits NaN or swapped | nothing |
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from floornav_common.readings import RangeReading
from grid_mapper.sonar_config import SonarConfig

SAME_RANGE = 1e-6
"""Relative: messages carry 32 bits, so a driver's max_range may come back rounded."""


@dataclass(frozen=True)
class Hit:
    """An echo at `range` (m)."""

    range: float


@dataclass(frozen=True)
class Free:
    """No echo from nearer than `range` (m, may be infinite)."""

    range: float


@dataclass(frozen=True)
class Nothing:
    """A reading that says nothing, and why."""

    reason: str


def classify(reading: RangeReading) -> Hit | Free | Nothing:
    """Return what a reading says, by the table above."""
    r, low, high = reading.range, reading.min_range, reading.max_range
    if not (high > 0.0 and low <= high):
        return Nothing(f"limits that leave no range: {low:g} to {high:g} m")
    if math.isnan(r):
        return Nothing("not measured (NaN)")
    if low == high:
        return _fixed_distance(r, high)
    if r == math.inf or math.isclose(r, high, rel_tol=SAME_RANGE):
        return Free(high)
    if r == -math.inf:
        return Nothing("too near to measure (-inf)")
    if r <= 0.0:
        return Nothing("not measured (0 or less)")
    if r < low:
        return Nothing("below min_range")
    return Hit(r) if r < high else Nothing("above max_range")


def _fixed_distance(r: float, distance: float) -> Hit | Free | Nothing:
    """Return what a ranger says that tells only whether something is within `distance`."""
    if math.isfinite(r):
        return Nothing("a number from a fixed-distance ranger, which sends inf or -inf")
    return Free(distance) if r > 0.0 else Hit(distance)


def opening(reading: RangeReading, config: SonarConfig) -> float:
    """Return alpha_S, the full opening of the cone, rad: as set, else as the message says."""
    if config.aperture_rad > 0.0:
        return config.aperture_rad
    said = reading.field_of_view
    return said if 0.0 < said <= math.pi else config.unsaid_aperture_rad
