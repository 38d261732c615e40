"""The front end of loop closing: a pose that drifts and never jumps, and which scans are nodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig, KeyScanConfig
from grid_mapper.drift import Drift
from grid_mapper.key_frames import KeyFrame, thinned
from grid_mapper.key_scans import KeyScans
from grid_mapper.localizer import ScanLocalizer
from grid_mapper.match_verdict import ScanResult
from grid_mapper.motion import rotated
from grid_mapper.recent_scans import RecentScanMatcher
from grid_mapper.surface_points import SurfacePoints, points_of
from grid_mapper.sweeps import SweepOrder


class FrontEnd:
    """Fits scans to what was seen lately."""

    def __init__(self, config: GridMapperConfig) -> None:
        self._matcher = RecentScanMatcher(config.matcher, config.loop.recent_scans)
        self._localizer = ScanLocalizer(config, matcher=self._matcher)
        self._keys, self._drift = KeyScans(), Drift()
        self.reconfigure(config)

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those marked read-only stay as they were."""
        self.config, loop = config, config.loop
        self._localizer.reconfigure(config)
        self._key = KeyScanConfig(
            distance_m=loop.node_distance_m, turn_rad=loop.node_turn_rad, period_s=0.0
        )

    @property
    def sweeps(self) -> SweepOrder:
        """In which order the beams of a scan are taken."""
        return self._localizer.sweeps

    def deskewed(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> Scan:
        """Return a scan as seen from one place; see `ScanLocalizer.deskewed`."""
        return self._localizer.deskewed(stamp_ns, scan, T_base_laser, T_odom_base)

    def follow(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> tuple[ScanResult, bool]:
        """Localize one scan, see `ScanLocalizer.localize`; tell too whether it is a node.

        Its covariance holds the drift since the beginning, or since the robot was last found.
        """
        result = self._localizer.localize(stamp_ns, scan, T_base_laser, T_odom_base)
        is_node = result.is_trusted and self._keys.take(stamp_ns, result.T_map_base, self._key)
        return self._drift.of(result, is_node, self.config), is_node

    def see(self, places: Iterable[tuple[SurfacePoints, SE2]]) -> None:
        """Take what is known of the surroundings: points and their poses in this frame."""
        for points, pose in places:
            self._matcher.insert(points, pose)

    def begin_after(self, frames: Sequence[KeyFrame], num_recent: int) -> None:
        """Begin behind key frames, of which the last are what was seen lately."""
        self.see((frame.points, frame.T_local_base) for frame in frames[-num_recent:])
        self.relocate(frames[0].T_local_base, None)
        self._localizer.begin_in_map(frames[-1].stamp_ns)
        self.relocate(frames[-1].T_local_base, None)

    def relocate(self, T_local_base: SE2, cov: np.ndarray | None) -> None:
        """Go on from another pose; see `ScanLocalizer.relocate`."""
        self._drift.restart()
        self._localizer.relocate(T_local_base, cov)

    def lose(self) -> None:
        """Follow odometry alone; see `ScanLocalizer.lose`."""
        self._localizer.lose()

    def break_motion(self, T_local_first: SE2) -> None:
        """Go on after time or odometry jumped; see `ScanLocalizer.break_motion`."""
        self._drift.restart()
        self._localizer.break_motion(T_local_first)

    @property
    def num_bytes(self) -> int:
        """Bytes held by what scans are fitted to."""
        return self._localizer.num_bytes


def in_map(result: ScanResult, T_map_local: SE2) -> ScanResult:
    """Return a result of the front end in the map's frame."""
    turn, information = T_map_local.yaw, result.information
    return replace(
        result, T_map_base=T_map_local @ result.T_map_base, cov=rotated(result.cov, turn),
        information=None if information is None else rotated(information, turn),
    )  # fmt: skip


def key_frame(
    stamp_ns: int, scan: Scan, T_base_laser: SE2, T_local_base: SE2,
    information: np.ndarray | None, config: GridMapperConfig,
) -> KeyFrame:  # fmt: skip
    """Return what a node keeps of its scan; the arguments are of the scan and its match."""
    return KeyFrame(
        stamp_ns, T_local_base, np.zeros((3, 3)) if information is None else information,
        thinned(points_of(scan, T_base_laser, config.matcher)), scan, T_base_laser,
    )  # fmt: skip
