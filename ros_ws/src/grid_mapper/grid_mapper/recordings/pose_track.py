"""Poses over time, read in between by interpolation and never beyond their ends."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable

from floornav_common.se2 import SE2


class PoseTrack:
    """Poses by stamp. Where time went back, the later recorded poses of that time win."""

    def __init__(self, poses: Iterable[tuple[int, SE2]] = ()) -> None:
        self._stamps: list[int] = []
        self._poses: list[SE2] = []
        for stamp_ns, pose in poses:
            self.add(stamp_ns, pose)

    def add(self, stamp_ns: int, pose: SE2) -> None:
        """Take one pose; a repeated stamp replaces the pose there."""
        if not self._stamps or stamp_ns > self._stamps[-1]:
            self._stamps.append(stamp_ns)
            self._poses.append(pose)
            return
        i = bisect_left(self._stamps, stamp_ns)
        if self._stamps[i] == stamp_ns:
            self._poses[i] = pose
        else:
            self._stamps.insert(i, stamp_ns)
            self._poses.insert(i, pose)

    def at(self, stamp_ns: int) -> SE2 | None:
        """Return the pose at a time; None before the first and after the last pose."""
        i = bisect_left(self._stamps, stamp_ns)
        if i == len(self._stamps):
            return None
        t1, pose1 = self._stamps[i], self._poses[i]
        if t1 == stamp_ns:
            return pose1
        if i == 0:
            return None
        t0 = self._stamps[i - 1]
        return self._poses[i - 1].interpolate(pose1, (stamp_ns - t0) / (t1 - t0))

    def gap_ns(self, stamp_ns: int) -> int:
        """Return how far apart the poses are between which a time lies; 0 at or beyond one."""
        i = bisect_left(self._stamps, stamp_ns)
        if i in (0, len(self._stamps)) or self._stamps[i] == stamp_ns:
            return 0
        return self._stamps[i] - self._stamps[i - 1]

    def oldest_ns(self) -> int | None:
        """Return the first stamp; None while empty."""
        return self._stamps[0] if self._stamps else None

    def newest_ns(self) -> int | None:
        """Return the last stamp; None while empty."""
        return self._stamps[-1] if self._stamps else None

    def forget_before(self, stamp_ns: int) -> None:
        """Drop poses older than this, except the newest of them, which `at` still needs."""
        keep = max(bisect_left(self._stamps, stamp_ns) - 1, 0)
        del self._stamps[:keep], self._poses[:keep]

    def clear(self) -> None:
        """Forget everything."""
        self._stamps.clear()
        self._poses.clear()
