"""What drivers really send, turned into what REP 117 says; the same code live and offline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan


def clean_scan(scan: Scan) -> Scan:
    """Return the scan with every beam a measurement, `+inf`, `-inf` or NaN, and none twice.

    - 0 and negative values (Neato and others send 0.0) and NaN mean "no return": nothing is known
      about the beam, so it is NaN and clears no space.
    - A value beyond `range_max` is out of the sensor's word: `+inf`, nothing within range.
    - A positive value below `range_min` is `-inf`, too near.
    - A last beam that points where the first does (361 beams of 1 degree) is left out.

    Args:
        scan: As received; not modified.

    Returns:
        The cleaned scan.

    Raises:
        ValueError: If the range limits are none, for then no beam could be told from another.
    """
    if not scan.range_max > max(scan.range_min, 0.0):
        raise ValueError(
            f"range_max must be > range_min and > 0, got {scan.range_min} to {scan.range_max}: "
            "the laser's driver is to say them"
        )
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        no_return = (ranges == 0.0) | ((ranges < 0.0) & np.isfinite(ranges))
        too_near = (ranges > 0.0) & (ranges < scan.range_min)
        too_far = ranges > scan.range_max
    ranges[no_return] = np.nan
    ranges[too_near] = -np.inf
    ranges[too_far] = np.inf
    if _repeats_first_beam(scan):
        ranges = ranges[:-1]
    return replace(scan, ranges=ranges)


def _repeats_first_beam(scan: Scan) -> bool:
    """Tell whether the last beam closes the full turn and so repeats the first."""
    sweep = abs(scan.angle_increment) * (len(scan.ranges) - 1)
    return len(scan.ranges) > 2 and sweep > 2.0 * np.pi - 0.5 * abs(scan.angle_increment)
