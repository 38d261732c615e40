"""The angles and limits of a LaserScan, checked: what drivers leave open or get wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floornav_common.scan import Scan

LONGEST_SWEEP_RAD = 1.05 * 2.0 * math.pi
"""Drivers whose motor runs unevenly send a few beams too many; more is no scan."""
NOT_CLOSED_BEAMS = 1.5
"""angle_max may be the last beam's angle or the one behind it; more than that is a mismatch."""

RangeLimits = tuple[float, float]


def scan_of(message: Any, limits: RangeLimits | None = None) -> Scan:
    """Return the scan of a LaserScan message.

    Args:
        message: As deserialized.
        limits: Shortest and longest range that is a measurement, m; None to take the message's.

    Raises:
        ValueError: If its angles, its limits or its ranges make no scan; with what would cure it.
    """
    ranges = np.asarray(message.ranges, dtype=np.float64)
    if len(ranges) == 0:
        raise ValueError("no ranges")
    angle_min = float(message.angle_min)
    if not math.isfinite(angle_min):
        raise ValueError(f"angle_min {angle_min}")
    low, high = limits or (float(message.range_min), float(message.range_max))
    if not low < high or not high > 0.0:
        raise ValueError(
            f"range_min {low:g} and range_max {high:g} leave no range: say them with"
            " --range-limits MIN MAX (m, m)"
        )
    return Scan(
        ranges=ranges,
        angle_min=angle_min,
        angle_increment=increment_of(message, len(ranges)),
        range_min=low,
        range_max=high,
        time_increment=float(message.time_increment),
    )


def increment_of(message: Any, num_beams: int) -> float:
    """Return the angle from beam to beam; from the limits where the message's cannot be.

    Raises:
        ValueError: If neither can be.
    """
    increment, by_limits = float(message.angle_increment), _by_limits(message, num_beams)
    if num_beams == 1 or _is_possible(increment, num_beams):
        return increment if math.isfinite(increment) else 0.0
    if _is_possible(by_limits, num_beams):
        return by_limits
    raise ValueError(f"angle_increment {increment:g} for {num_beams} beams")


def angle_note(message: Any) -> str:
    """Return what is odd about the angles of a scan and what is done; "" if nothing is."""
    num_beams = len(message.ranges)
    increment, used = float(message.angle_increment), increment_of(message, num_beams)
    if num_beams > 1 and used != increment:
        return (
            f"angle_increment {increment:g} cannot be for {num_beams} beams:"
            f" {used:.6f} rad, from angle_min, angle_max and their number"
        )
    end = float(message.angle_min) + used * (num_beams - 1)
    off = abs(float(message.angle_max) - end)
    if num_beams > 1 and off > NOT_CLOSED_BEAMS * abs(used):
        return (
            f"angle_max {float(message.angle_max):.3f} is not where {num_beams} beams of"
            f" angle_increment {used:.6f} end ({end:.3f}): angle_increment is taken"
        )
    return ""


def _by_limits(message: Any, num_beams: int) -> float:
    return (float(message.angle_max) - float(message.angle_min)) / max(num_beams - 1, 1)


def _is_possible(increment: float, num_beams: int) -> bool:
    """Tell whether beams so far apart lie within a turn or little more."""
    sweep = abs(increment) * (num_beams - 1)
    return math.isfinite(increment) and increment != 0.0 and sweep < LONGEST_SWEEP_RAD
