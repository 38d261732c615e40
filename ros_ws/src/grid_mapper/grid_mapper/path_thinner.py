"""A trajectory short enough to publish: a pose every so many metres, and the newest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from floornav_common.se2 import SE2

Row = TypeVar("Row")


class PathThinner(Generic[Row]):
    """Collects rows of poses at least `spacing` (m) apart; each row is made once, and kept.

    Once there are more than `max_poses` every other one goes and the spacing doubles, so that the
    whole path stays equally dense.

    Args:
        make_row: Called with (stamp_ns, pose).
        spacing: Least distance of neighboring poses at first, m.
        max_poses: Greatest number of rows kept, >= 2.
    """

    def __init__(
        self, make_row: Callable[[int, SE2], Row], spacing: float = 0.1, max_poses: int = 20_000
    ) -> None:
        if max_poses < 2:
            raise ValueError(f"max_poses must be >= 2, got {max_poses}")
        self._make_row = make_row
        self._spacing = spacing
        self._max_poses = max_poses
        self._kept: list[Row] = []
        self._last: SE2 | None = None
        self._newest: tuple[int, SE2] | None = None
        self._is_newest_kept = False

    def add(self, stamp_ns: int, pose: SE2) -> None:
        """Take the next pose."""
        self._newest = (stamp_ns, pose)
        self._is_newest_kept = (
            self._last is None or self._last.between(pose).distance >= self._spacing
        )
        if self._is_newest_kept:
            self._kept.append(self._make_row(stamp_ns, pose))
            self._last = pose
        if len(self._kept) > self._max_poses:
            self._is_newest_kept = len(self._kept) % 2 == 1
            self._kept = self._kept[::2]
            self._spacing *= 2.0

    @property
    def newest_stamp_ns(self) -> int | None:
        """Stamp of the newest pose, None before the first."""
        return None if self._newest is None else self._newest[0]

    def rows(self) -> list[Row]:
        """Return the rows, that of the newest pose last."""
        if self._newest is None or self._is_newest_kept:
            return list(self._kept)
        return [*self._kept, self._make_row(*self._newest)]
