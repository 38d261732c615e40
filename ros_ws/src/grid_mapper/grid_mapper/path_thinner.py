"""A trajectory short enough to publish: a pose every so many metres, and the newest."""

from __future__ import annotations

from floornav_common.se2 import SE2


class PathThinner:
    """Collects poses at least `spacing` (m) apart."""

    def __init__(self, spacing: float = 0.1) -> None:
        self._spacing = spacing
        self._kept: list[tuple[int, SE2]] = []
        self._newest: tuple[int, SE2] | None = None

    def add(self, stamp_ns: int, pose: SE2) -> None:
        """Take the next pose."""
        self._newest = (stamp_ns, pose)
        if not self._kept or self._kept[-1][1].between(pose).distance >= self._spacing:
            self._kept.append(self._newest)

    def poses(self) -> list[tuple[int, SE2]]:
        """Return (stamp_ns, pose) rows, the newest pose last."""
        if self._newest is None or self._newest == self._kept[-1]:
            return list(self._kept)
        return [*self._kept, self._newest]
