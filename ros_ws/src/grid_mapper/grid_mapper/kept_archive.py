"""The archive of what maps are made from: as large as the area seen asks for, not as the time.

Scans are kept with their ranges as whole steps of a millimeter or two. Of scans taken in one cell
of the floor with about the same direction, and of readings of one sonar likewise, the newest stay.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.scan import Scan
from grid_mapper.corrections import Corrections
from grid_mapper.kept_events import Kept, KeptReading, KeptScan

SCAN_CELL_M, SCAN_RAD, SCANS_A_CELL = 0.5, 0.8, 12
READING_CELL_M, READING_RAD, READINGS_A_CELL = 0.1, 0.2, 8
STEPS = 65_000
NAN, INF, MINUS_INF = 65_535, 65_534, 65_533
MIN_STEP_M = 0.001
GROWTH, LEAST = 1.25, 2000
"""What is too much is thrown out once there is so much more than after the last time."""


@dataclass(frozen=True)
class _PackedScan:
    """A scan whose ranges are whole steps."""

    kept: KeptScan
    steps: np.ndarray
    step_m: float

    def unpacked(self) -> KeptScan:
        """Return the scan; ranges are up to half a step off."""
        ranges = self.steps * self.step_m
        for code, value in ((NAN, np.nan), (INF, np.inf), (MINUS_INF, -np.inf)):
            ranges[self.steps == code] = value
        return replace(self.kept, scan=replace(self.kept.scan, ranges=ranges))


class KeptArchive:
    """Holds events in their order."""

    def __init__(self) -> None:
        self._events: list[_PackedScan | KeptReading] = []
        self._num_after_thinning = LEAST

    def __len__(self) -> int:
        return len(self._events)

    def add(self, event: Kept) -> None:
        """Keep an event."""
        self._events.append(_packed(event) if isinstance(event, KeptScan) else event)

    def from_index(self, first: int, num: int) -> Iterator[Kept]:
        """Yield up to `num` events from the one at an index."""
        for event in self._events[first : first + num]:
            yield event.unpacked() if isinstance(event, _PackedScan) else event

    @property
    def is_full(self) -> bool:
        """Whether it is time to throw out what is too much."""
        return len(self._events) > GROWTH * self._num_after_thinning

    def thin(self, corrections: Corrections) -> None:
        """Throw out the older ones of what was taken at one place, by poses known now."""
        kept = [e.kept if isinstance(e, _PackedScan) else e for e in self._events]
        is_scan = np.array([isinstance(e, KeptScan) for e in kept], bool)
        poses = corrections.all_at(
            np.array([e.node for e in kept], int),
            np.array([e.T_local_base.as_array() for e in kept]).reshape(-1, 3),
        )
        sensors = {name: k for k, name in enumerate(dict.fromkeys(_sensor(e) for e in kept))}
        source = np.array([sensors[_sensor(e)] for e in kept], int)
        is_kept = np.zeros(len(kept), bool)
        for mask, cell, turn, most in (
            (is_scan, SCAN_CELL_M, SCAN_RAD, SCANS_A_CELL),
            (~is_scan, READING_CELL_M, READING_RAD, READINGS_A_CELL),
        ):
            rows = np.flatnonzero(mask)
            bins = np.column_stack(
                (np.floor(poses[rows] / (cell, cell, turn)).astype(int), source[rows])
            )
            is_kept[rows[_newest(bins, most)]] = True
        self._events = [e for e, k in zip(self._events, is_kept, strict=True) if k]
        self._num_after_thinning = max(LEAST, len(self._events))


def _sensor(event: Kept) -> str:
    return event.sensor if isinstance(event, KeptReading) else ""


def _newest(bins: np.ndarray, most: int) -> np.ndarray:
    """Return the rows that are among the last `most` of their bin, shape (K,)."""
    if not len(bins):
        return np.zeros(0, int)
    _, group = np.unique(bins, axis=0, return_inverse=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    sizes = np.bincount(group)
    ends = np.cumsum(sizes)[group[order]]
    return np.sort(order[ends - np.arange(len(order)) <= most])


def _packed(event: KeptScan) -> _PackedScan:
    scan = event.scan
    step_m = max(MIN_STEP_M, scan.range_max / STEPS) if np.isfinite(scan.range_max) else 0.002
    ranges = np.asarray(scan.ranges, float)
    steps = np.full(len(ranges), NAN, np.uint16)
    steps[ranges == -np.inf] = MINUS_INF
    steps[ranges > STEPS * step_m] = INF
    is_near = np.isfinite(ranges) & (ranges <= STEPS * step_m)
    steps[is_near] = np.rint(np.maximum(ranges[is_near], 0.0) / step_m).astype(np.uint16)
    empty: Scan = replace(scan, ranges=np.zeros(0))
    return _PackedScan(replace(event, scan=empty), steps, step_m)
