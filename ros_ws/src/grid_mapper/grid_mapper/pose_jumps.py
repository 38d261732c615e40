"""Jumps of a pose that another localizer gives: what odometry does not explain.

TF interpolates map->odom between its samples, so a jump is spread over all inputs between two of
them. So not the last step is looked at but the way since about a second ago: the correction
`T_map_odom = T_map_base @ inv(T_odom_base)` stands still while the localizer agrees with odometry.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from floornav_common.se2 import SE2

WINDOW_NS = 1_000_000_000
"""Longer than localizers take between two samples of map->odom."""
MAX_POSES = 1000
"""Kept at most: of a ring of 24 sonars at 40 Hz those of a second."""
MAX_SPEED = 1.0
"""Expected of a robot without odometry, m/s: no faster motion is told from a jump."""
MAX_YAW_RATE = 1.5
"""The same, rad/s."""


@dataclass(frozen=True)
class Jump:
    """How far a pose is from where an earlier one leads to.

    Attributes:
        distance: m, of the robot's place.
        turn: rad, 0 or more.
    """

    distance: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True)
class _Given:
    stamp_ns: int
    T_map_base: SE2
    T_odom_base: SE2 | None


class PoseJumps:
    """Compares each pose with the oldest of the last second, moved on by odometry if there is any.

    For a second after a jump every pose is as far from the oldest, so all inputs of that time are
    told as jumping; then the poses after the jump are compared with each other.
    """

    def __init__(self) -> None:
        self._poses: deque[_Given] = deque(maxlen=MAX_POSES)

    def clear(self) -> None:
        """Begin anew: time jumped back."""
        self._poses.clear()

    def jump(self, stamp_ns: int, T_map_base: SE2, T_odom_base: SE2 | None) -> Jump:
        """Return how far the pose is from where the one of a second ago leads to.

        Without odometry what the robot may have driven in the time between is taken off.

        Args:
            stamp_ns: Of the pose. One older than the oldest kept is compared with that.
            T_map_base: The pose.
            T_odom_base: Odometry at the same stamp; None where there is none.
        """
        given = _Given(stamp_ns, T_map_base, T_odom_base)
        if not self._poses or stamp_ns >= self._poses[-1].stamp_ns:
            self._poses.append(given)
        # One pose older than the window stays: slow inputs have none within it.
        while len(self._poses) > 2 and stamp_ns - self._poses[1].stamp_ns >= WINDOW_NS:
            self._poses.popleft()
        return _between(self._poses[0], given)


def _between(earlier: _Given, later: _Given) -> Jump:
    if earlier.T_odom_base is not None and later.T_odom_base is not None:
        expected = earlier.T_map_base @ earlier.T_odom_base.between(later.T_odom_base)
        off = expected.between(later.T_map_base)
        return Jump(off.distance, abs(off.yaw))
    dt = abs(later.stamp_ns - earlier.stamp_ns) * 1e-9
    off = earlier.T_map_base.between(later.T_map_base)
    distance = max(0.0, off.distance - MAX_SPEED * dt)
    return Jump(distance, max(0.0, abs(off.yaw) - MAX_YAW_RATE * dt))
