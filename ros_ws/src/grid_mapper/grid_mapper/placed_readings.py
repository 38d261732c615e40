"""Sonar readings placed between the poses of the scans round their stamps (glass paper, 3)."""

from __future__ import annotations

from collections.abc import Iterator

from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper.pose_history import PoseHistory
from grid_mapper.waiting_readings import WaitingReading, WaitingReadings

MAX_AHEAD_NS = 5_000_000_000
"""A reading stamped further after the newest trusted scan is of a clock that runs ahead."""


class PlacedReadings:
    """Takes poses of scans and readings, gives readings back once their poses are known.

    Attributes:
        num_unplaced: Readings that were left out.
    """

    def __init__(self) -> None:
        self._history = PoseHistory()
        self._waiting = WaitingReadings()
        self.num_unplaced = 0

    def add_pose(self, stamp_ns: int, pose: SE2) -> None:
        """Take the pose of a trusted scan."""
        self._history.add(stamp_ns, pose)

    def push(self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str) -> None:
        """Take a reading, which waits for its pose."""
        newest_ns = self._history.newest_ns
        is_ahead = newest_ns is not None and stamp_ns - newest_ns > MAX_AHEAD_NS
        if is_ahead or not self._waiting.push(stamp_ns, reading, T_base_sonar, sensor):
            self.num_unplaced += 1

    def take(self, max_gap_s: float) -> Iterator[tuple[WaitingReading, SE2]]:
        """Yield and drop the readings that the newest scan has caught up with, with their poses.

        Args:
            max_gap_s: Scans further apart in time do not say where the robot was between them.
        """
        newest_ns = self._history.newest_ns
        if newest_ns is None:
            return
        max_gap_ns = round(max_gap_s * 1e9)
        for waiting in self._waiting.pop_until(newest_ns):
            pose = self._history.at(waiting.stamp_ns, max_gap_ns)
            if pose is None:
                self.num_unplaced += 1
            else:
                yield waiting, pose

    def break_here(self) -> None:
        """Let nothing be placed between the poses so far and the next: the pose jumped."""
        self._history.break_here()

    def clear(self) -> None:
        """Forget all: time jumped back."""
        self.num_unplaced += self._waiting.clear()
        self._history.clear()
