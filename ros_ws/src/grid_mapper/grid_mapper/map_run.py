"""The offline mapping run: a recording's events through the mapper, one after the other."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.stop_signals import noticed_stop
from grid_mapper.recordings import RangeEvent, Recording, ScanEvent


class ScanOutcome(Protocol):
    """What the run needs of a mapper's answer to a scan."""

    @property
    def T_map_base(self) -> SE2:  # noqa: N802, frames rule of the transforms
        """Pose of the robot at the scan's stamp."""
        ...

    @property
    def is_trusted(self) -> bool:
        """Whether the match is to be trusted."""
        ...

    @property
    def reason(self) -> str:
        """Why not."""
        ...


class ScanMapper(Protocol):
    """What the run needs of a mapper."""

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanOutcome:
        """Localize and map one scan."""
        ...

    def insert_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str
    ) -> None:
        """Map one sonar reading at the pose that the scans round it say."""
        ...

    def place_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str, T_map_base: SE2
    ) -> None:
        """Map one sonar reading at a known pose."""
        ...

    def break_motion(self) -> None:
        """Go on after the recording's time jumped back."""
        ...


@dataclass
class MapRun:
    """What a run has found so far.

    Attributes:
        trajectory: Stamp (ns) and pose of every scan that was used, as it came; without a laser
            of every stamp of a reading.
        untrusted: Stamp (ns) and reason of every scan whose match was not trusted.
        scan_ms: Time the mapper took for each scan, ms.
        range_ms: Time the mapper took for each sonar reading, ms.
        finish_ms: Time the mapper took behind the last scan, ms.
        jumps: Places in the trajectory before which time or the robot jumped.
        is_interrupted: True after Ctrl-C.
    """

    trajectory: list[tuple[int, SE2]] = field(default_factory=list)
    untrusted: list[tuple[int, str]] = field(default_factory=list)
    scan_ms: list[float] = field(default_factory=list)
    range_ms: list[float] = field(default_factory=list)
    finish_ms: float = 0.0
    jumps: list[int] = field(default_factory=list)
    is_interrupted: bool = False

    @property
    def num_ranges(self) -> int:
        """Readings of sonars met on the way."""
        return len(self.range_ms)

    def stretches(self, first: int = 0) -> list[list[tuple[int, SE2]]]:
        """Return the trajectory from a place on, parted where time or the robot jumped."""
        ends = [first, *(k for k in self.jumps if k > first), len(self.trajectory)]
        return [self.trajectory[a:b] for a, b in pairwise(ends) if b > a]

    def ms_quantile(self, share: float) -> float | None:
        """Return a quantile of the time per scan, ms; None before the first scan."""
        return float(np.quantile(self.scan_ms, share)) if self.scan_ms else None


def run_mapper(
    recording: Recording,
    mapper: ScanMapper,
    max_scans: int | None = None,
    on_scan: Callable[[MapRun], None] = lambda run: None,
) -> MapRun:
    """Feed a recording to a mapper in lockstep; Ctrl-C ends the run and keeps what there is.

    Args:
        recording: Its events are taken.
        mapper: Given every scan and sonar reading, in order, none left out.
        max_scans: Stop after so many; None for all.
        on_scan: Called after each scan.
    """
    run = MapRun()
    try:
        with noticed_stop() as should_stop:
            for event in recording.events():
                run.is_interrupted = should_stop()
                if run.is_interrupted:
                    break
                if not isinstance(event, ScanEvent):
                    _insert_range(run, mapper, event, recording.has_laser)
                    continue
                if max_scans is not None and len(run.trajectory) >= max_scans:
                    break
                _insert(run, mapper, event)
                on_scan(run)
    except KeyboardInterrupt:
        run.is_interrupted = True
    return run


def _insert(run: MapRun, mapper: ScanMapper, event: ScanEvent) -> None:
    if event.follows_jump:
        run.jumps.append(len(run.trajectory))
        mapper.break_motion()
    started = time.perf_counter()
    result = mapper.insert_scan(event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base)
    run.scan_ms.append(1e3 * (time.perf_counter() - started))
    run.trajectory.append((event.stamp_ns, result.T_map_base))
    if not result.is_trusted:
        run.untrusted.append((event.stamp_ns, result.reason))


def _insert_range(run: MapRun, mapper: ScanMapper, event: RangeEvent, has_laser: bool) -> None:
    """Hand over a reading; without a laser odometry, or its absence, is the robot's pose."""
    reading = (event.stamp_ns, event.reading, event.T_base_sonar, event.frame)
    pose = event.T_odom_base if event.T_odom_base is not None else SE2.identity()
    started = time.perf_counter()
    if has_laser:
        mapper.insert_range(*reading)
    else:
        mapper.place_range(*reading, pose)
        if not run.trajectory or run.trajectory[-1][0] != event.stamp_ns:
            run.trajectory.append((event.stamp_ns, pose))
    run.range_ms.append(1e3 * (time.perf_counter() - started))


def peak_memory_mb() -> float:
    """Return the greatest memory this process has held, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10
