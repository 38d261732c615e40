"""When the mapping node looks for its robot: in a map to begin with, and after it was lost."""

from __future__ import annotations

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
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
        self.close = recovery.close
        self.begin()

    def begin(self) -> None:
        """Begin anew: in a map that was made before the robot is anywhere."""
        self._untrusted_since_ns: int | None = None
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

    def look(self, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None) -> None:
        """Look for the robot if it is lost; go on where it is found."""
        if not self._recovery.is_active or T_odom_base is None:
            return
        clipped = self._mapper.config.clipped(scan)
        found = self._recovery.look(clipped, T_base_laser, T_odom_base)
        if found is not None:
            self._mapper.relocate(found.T_map_base, found.cov, found.seen)

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
