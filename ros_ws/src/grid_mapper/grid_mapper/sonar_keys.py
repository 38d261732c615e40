"""Which readings of a sonar are counted: as many per meter and per turn, whatever its rate."""

from __future__ import annotations

from math import inf

from floornav_common.se2 import SE2
from grid_mapper.sonar_config import SonarKeyConfig


class SonarKeys:
    """Picks readings of one sonar apart from each other.

    Readings come at places of their own; one that comes late by some share of the spacing lets the
    next come early by as much, so that a sonar of any rate is counted equally often on the same
    way. A robot that stands still adds nothing, however much its pose trembles.
    """

    def __init__(self) -> None:
        self._last: tuple[int, SE2] | None = None
        self._credit = 0.0

    def take(self, stamp_ns: int, pose: SE2, config: SonarKeyConfig) -> bool:
        """Tell whether the reading of this stamp and pose of the robot is counted."""
        if self._last is None:
            self._last = (stamp_ns, pose)
            return True
        last_ns, last_pose = self._last
        moved = last_pose.between(pose)
        passed = max(
            _share(moved.distance, config.distance_m),
            _share(abs(moved.yaw), config.turn_rad),
            1e-9 * (stamp_ns - last_ns) / config.period_s if config.period_s > 0.0 else 0.0,
        )
        if passed + self._credit < 1.0:
            return False
        self._last = (stamp_ns, pose)
        self._credit = (passed + self._credit) % 1.0 if passed < inf else 0.0
        return True


def _share(value: float, spacing: float) -> float:
    """Return a value in spacings; a spacing of 0 is always reached."""
    return value / spacing if spacing > 0.0 else inf
