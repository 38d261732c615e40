"""Grids made anew from poses known: every scan and reading again, so nothing known is lost."""

from __future__ import annotations

from collections.abc import Sequence

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import KnownPose
from grid_mapper.sweeps import with_sweep


class MapRebuild:
    """Takes a recording's events once more, and maps them at the poses that are known now."""

    def __init__(self, mapper: LayeredMapper, poses: Sequence[KnownPose]) -> None:
        """Begin with the first scan.

        Args:
            mapper: Filled; empty at first.
            poses: Of every scan, in the order in which the scans come.
        """
        self._mapper, self._poses, self._next = mapper, poses, 0

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> KnownPose:
        """Map one scan at its pose, if that is to be trusted."""
        known = self._poses[self._next]
        self._next += 1
        if known.is_trusted:
            seen = with_sweep(scan, known.sweep)
            self._mapper.follow_scan(stamp_ns, seen, T_base_laser, known.T_map_base)
        return known

    def insert_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str
    ) -> None:
        """Map one reading at the pose that the scans round it have."""
        self._mapper.insert_range(stamp_ns, reading, T_base_sonar, sensor)

    def place_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str, T_map_base: SE2
    ) -> None:
        """Map one reading at a pose that is known."""
        self._mapper.place_range(stamp_ns, reading, T_base_sonar, sensor, T_map_base)

    def break_motion(self) -> None:
        """Go on after time jumped."""
        self._mapper.break_motion()
