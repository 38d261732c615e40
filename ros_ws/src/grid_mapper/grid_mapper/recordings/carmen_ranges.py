"""What a CARMEN log leaves unsaid of its laser: where its beams point and how far it reaches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from grid_mapper.recordings.carmen_lines import SICK_RANGE_MAX_M, LaserLine
from grid_mapper.recordings.events import RecordingError, RecordingOptions

MIN_SHARE = 1e-3
MIN_TIMES = 10
"""A longest reading this frequent, and so much more frequent than any other long one, is no
reading: it is what the driver writes where it saw nothing."""
MIN_LONG_M = 5.0
RANGE_PARAM = "robot_front_laser_max"


def fan_info(kind: str, line: LaserLine) -> str:
    """Return how the beams of the first scan fan out, and whether the log says so."""
    scan = line.scan
    first, step = np.degrees(scan.angle_min), np.degrees(scan.angle_increment)
    source = "CARMEN's rule for FLASER" if kind == "FLASER" else "as the lines say"
    return f"{len(scan.ranges)} beams from {first:.1f} deg in steps of {step:.3f} deg ({source})"


def range_limits(
    path: Path, lines: Sequence[LaserLine], params: Mapping[str, str], options: RecordingOptions
) -> tuple[tuple[float, float], str]:
    """Return the shortest and longest range that is a measurement, and how that is known.

    Raises:
        RecordingError: If the log's PARAM for it is no number.
    """
    if options.range_limits_m is not None:
        low, high = options.range_limits_m
        return (low, high), f"range: {low:g} to {high:g} m, as given on the command line"
    said, source = lines[0].scan.range_max, "as the lines say"
    if said == SICK_RANGE_MAX_M:
        source = "the reach of the SICK LMS (--range-limits MIN MAX says otherwise)"
    if RANGE_PARAM in params:
        try:
            said, source = float(params[RANGE_PARAM]), f"the log's PARAM {RANGE_PARAM}"
        except ValueError:
            raise RecordingError(
                f"{path}: PARAM {RANGE_PARAM} {params[RANGE_PARAM]} is no number: say the laser's"
                " reach with --range-limits MIN MAX (m, m)"
            ) from None
    nothing = nothing_seen([line.scan.ranges for line in lines])
    if nothing is not None and nothing <= said:
        high = float(np.nextafter(nothing, 0.0))
        return (0.0, high), f"range: {nothing:g} m is what the log writes for nothing seen"
    return (0.0, said), f"range: up to {said:g} m, {source}"


def nothing_seen(scans: Sequence[np.ndarray]) -> float | None:
    """Return the longest reading if it is too frequent to be one; None if it is not.

    Args:
        scans: Ranges of each scan, m.
    """
    ranges = np.concatenate(scans)
    ranges = ranges[np.isfinite(ranges)]
    values, counts = np.unique(ranges[ranges > MIN_LONG_M], return_counts=True)
    if len(values) == 0 or counts[-1] < max(MIN_SHARE * len(ranges), MIN_TIMES):
        return None
    others = counts[:-1][values[:-1] > 0.5 * values[-1]]
    is_alone = len(others) == 0 or counts[-1] > MIN_TIMES * others.max()
    return float(values[-1]) if is_alone else None
