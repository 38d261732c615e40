"""Where the robot was at a sonar's own stamp: between the poses of two scans (glass paper, 3)."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque

from floornav_common.se2 import SE2

MAX_POSES = 1000


class PoseHistory:
    """The newest trusted poses in the order of their stamps, and which of them belong together."""

    def __init__(self, max_poses: int = MAX_POSES) -> None:
        self._poses: deque[tuple[int, SE2, int]] = deque(maxlen=max_poses)
        self._piece = 0

    def add(self, stamp_ns: int, pose: SE2) -> None:
        """Take the next pose; a stamp that does not go on begins anew."""
        if self._poses and stamp_ns <= self._poses[-1][0]:
            self._poses.clear()
        self._poses.append((stamp_ns, pose, self._piece))

    def break_here(self) -> None:
        """Let nothing be interpolated between the poses so far and the next: the pose jumped."""
        self._piece += 1

    def clear(self) -> None:
        """Forget all: time jumped back."""
        self._poses.clear()

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest pose; None if there is none."""
        return self._poses[-1][0] if self._poses else None

    def at(self, stamp_ns: int, max_gap_ns: int) -> SE2 | None:
        """Return the pose at a stamp, linear between its neighbors.

        Args:
            stamp_ns: At most `newest_ns`; beyond it the pose is not known yet.
            max_gap_ns: Neighbors further apart do not say where the robot was between them.

        Returns:
            The pose; None if the stamp lies before all poses, in a gap or across a break.
        """
        index = bisect_left(self._poses, stamp_ns, key=lambda entry: entry[0])
        if index == len(self._poses):
            return None
        after_ns, after, after_piece = self._poses[index]
        if after_ns == stamp_ns:
            return after
        if index == 0:
            return None
        before_ns, before, before_piece = self._poses[index - 1]
        if before_piece != after_piece or after_ns - before_ns > max_gap_ns:
            return None
        return before.interpolate(after, (stamp_ns - before_ns) / (after_ns - before_ns))
