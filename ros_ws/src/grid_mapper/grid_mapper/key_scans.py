"""Which scans are kept: those taken after the robot has moved, or after some time."""

from __future__ import annotations

from floornav_common.se2 import SE2
from grid_mapper.config import KeyScanConfig
from grid_mapper.sonar_config import SonarKeyConfig


class KeyScans:
    """Picks scans apart from each other, so that what is made of them depends on no scan rate."""

    def __init__(self) -> None:
        self._last: tuple[int, SE2] | None = None

    def take(self, stamp_ns: int, pose: SE2, config: KeyScanConfig | SonarKeyConfig) -> bool:
        """Tell whether the scan of this stamp and pose is one to keep; the first always is."""
        if self._last is not None:
            last_ns, last_pose = self._last
            moved, period_ns = last_pose.between(pose), config.period_s * 1e9
            is_far = moved.distance >= config.distance_m or abs(moved.yaw) >= config.turn_rad
            if not is_far and not (period_ns > 0.0 and stamp_ns - last_ns >= period_ns):
                return False
        self._last = (stamp_ns, pose)
        return True
