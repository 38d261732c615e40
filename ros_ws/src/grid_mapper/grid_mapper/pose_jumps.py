"""Jumps of a pose that another localizer gives: what odometry does not explain."""

from __future__ import annotations

from floornav_common.se2 import SE2


class PoseJumps:
    """Compares each pose with the one before it, moved on by odometry where there is odometry."""

    def __init__(self) -> None:
        self._last: tuple[int, SE2, SE2 | None] | None = None

    def clear(self) -> None:
        """Begin anew: time jumped back."""
        self._last = None

    def jump(self, stamp_ns: int, T_map_base: SE2, T_odom_base: SE2 | None) -> float:
        """Return how far the pose is from where the last one leads to, m.

        Args:
            stamp_ns: Of the pose. One older than the last is no news without odometry: 0.
            T_map_base: The pose.
            T_odom_base: Odometry at the same stamp; None where there is none.
        """
        if self._last is None:
            self._last = (stamp_ns, T_map_base, T_odom_base)
            return 0.0
        last_ns, last_pose, last_odom = self._last
        has_odometry = T_odom_base is not None and last_odom is not None
        if stamp_ns < last_ns and not has_odometry:
            return 0.0
        expected = last_pose
        if T_odom_base is not None and last_odom is not None:
            expected = last_pose @ last_odom.between(T_odom_base)
        if stamp_ns >= last_ns:
            self._last = (stamp_ns, T_map_base, T_odom_base)
        return expected.between(T_map_base).distance
