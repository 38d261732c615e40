"""When the mapping node looks for its robot: in a map to begin with, and after it was lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.dead_reckoning import OdometryWatch
from grid_mapper.fit_watch import FitWatch
from grid_mapper.layers import LayeredMapper
from grid_mapper.map_swaps import MapSwaps
from grid_mapper.match_verdict import ScanResult
from grid_mapper.recovery import Recovery
from grid_mapper.relocation_messages import Prior


class LostRobot:
    """Starts and ends the search, and tells the mapper where the robot is found.

    Without odometry nothing is looked for: what was driven between two looks is not known.

    Args:
        mapper: Goes on where the robot is found.
        recovery: Looks for it.
        config: Of the node.
    """

    def __init__(
        self,
        mapper: LayeredMapper | ClosingMapper,
        recovery: Recovery,
        config: GridMapperNodeConfig,
    ) -> None:
        self._mapper, self._recovery, self.config = mapper, recovery, config
        self._fits = FitWatch(mapper.config.relocation.max_contradiction)
        self.close = recovery.close
        self.begin()

    def begin(self) -> None:
        """Begin anew: in a map that was made before the robot is anywhere."""
        self._untrusted_since_ns: int | None = None
        self._swaps = MapSwaps(self._mapper, self._recovery)
        self._odometry = OdometryWatch()
        self._looked_for_since_ns: int | None = None
        self._recovery.stop()
        if self._has_start_map:
            self._recovery.start()

    @property
    def is_looked_for(self) -> bool:
        """Whether it is."""
        return self._recovery.is_active

    @property
    def reason(self) -> str:
        """Why it is not found yet."""
        return self._recovery.reason

    @property
    def num_found(self) -> int:
        """How often it was found."""
        return self._recovery.num_found

    def is_said_at(self, pose: SE2, cov: np.ndarray) -> None:
        """Look near a pose in the map that there is; without map or odometry go on from there."""
        if self.config.use_odom and self._recovery.start(Prior(pose, cov)):
            self._mapper.lose()
            return
        self._recovery.stop()
        self._mapper.relocate(pose, cov, self._recovery.surroundings(pose))

    def restart(self) -> None:
        """Go on after time jumped: where the robot was, if odometry goes on and a scan fits there.

        Else it is looked for in the whole map that there is, or near the word that still counts;
        before there is a map it goes on where scans fit near the newest or the first pose.
        """
        self._odometry.break_time()
        self._mapper.break_motion()

    def is_jump(self, stamp_ns: int, T_odom_base: SE2 | None) -> bool:
        """Take odometry at a scan; tell whether it jumped further than a robot can move.

        What was looked at before counts no longer then. A mapper that is not lost sees to itself,
        but for a jump of time too: then the robot may be anywhere.
        """
        has_time_jumped = self._odometry.has_time_jumped
        if not self._recovery.is_active:
            self._looked_for_since_ns = None
        elif self._looked_for_since_ns is None:
            self._looked_for_since_ns = stamp_ns
        is_jump = self._odometry.take(stamp_ns, T_odom_base, self._mapper.config.motion)
        may_look = self.config.use_odom and (has_time_jumped or self._recovery.is_active)
        if is_jump and may_look and self._recovery.restart():
            self._mapper.lose()
        return is_jump

    def look(self, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None) -> SE2 | None:
        """Look for the robot if it is lost; go on where it is found, and return that."""
        self._swaps.note()
        if not self._recovery.is_active or T_odom_base is None or self._swaps.is_map_old:
            return None
        if self._swaps.is_search_old:
            self._swaps.is_search_old = False
            self._recovery.restart()
        clipped = self._mapper.config.clipped(scan)
        found = self._recovery.look(clipped, T_base_laser, T_odom_base)
        if found is None:
            return None
        self._mapper.relocate(found.T_map_base, found.cov, found.seen)
        return found.T_map_base

    def looked_for_s(self, stamp_ns: int) -> float:
        """Return for how long the robot is, or was until now, looked for, s."""
        since_ns = self._looked_for_since_ns
        return 0.0 if since_ns is None else max(0.0, (stamp_ns - since_ns) * 1e-9)

    def checked(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, result: ScanResult
    ) -> ScanResult:
        """Return a result; not trusted, and the robot looked for, if a map that is kept says no."""
        if not (self.config.keep_start_map and result.is_trusted):
            self._fits.forget()
            return result
        if not self.config.use_odom or not self._fits.is_due(stamp_ns):
            return result
        near = self._recovery.surroundings(result.T_map_base)
        if near is None:
            return result
        clipped = self._mapper.config.clipped(scan)
        doubt = self._fits.doubt(stamp_ns, clipped, T_base_laser, result, near)
        if not doubt:
            return result
        self._fits.forget()
        self._recovery.start()
        self._mapper.lose()
        return replace(result, is_trusted=False, reason=doubt)

    def judge(self, stamp_ns: int, is_trusted: bool, is_lost: bool) -> None:
        """Begin to look once the robot has been lost for so long."""
        if is_trusted or self._recovery.is_active or not self.config.use_odom:
            self._untrusted_since_ns = None
            return
        since_ns = self._untrusted_since_ns
        self._untrusted_since_ns = stamp_ns if since_ns is None else min(since_ns, stamp_ns)
        lost_ns = stamp_ns - self._untrusted_since_ns
        if is_lost and lost_ns > self.config.lost_after_s * 1e9 and self._recovery.start():
            self._mapper.lose()

    @property
    def _has_start_map(self) -> bool:
        return bool(self.config.start_map) and self.config.use_odom
