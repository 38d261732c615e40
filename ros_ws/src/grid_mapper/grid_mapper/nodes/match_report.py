"""What `pose_source: icp` says of itself on /diagnostics: whether scans fit the map."""

from __future__ import annotations

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from grid_mapper.match_verdict import ScanResult
from grid_mapper.nodes.lost_robot import LostRobot


class MatchReport:
    """Counts scans, and keeps what was said of the newest.

    Args:
        lost: What looks for a robot that is lost.
        has_odom: Whether odometry decides where scans do not say enough.
    """

    def __init__(self, lost: LostRobot, *, has_odom: bool) -> None:
        self._lost, self._has_odom = lost, has_odom
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._num_scans, self._num_trusted, self._worst_ms = 0, 0, 0.0
        self._reason, self._note = "no scan yet", ""

    def note(self, result: ScanResult, took_ms: float) -> None:
        """Take what became of a scan, and how long that took."""
        self._num_scans += 1
        self._num_trusted += result.is_trusted
        self._worst_ms = max(self._worst_ms, took_ms)
        self._reason, self._note = result.reason, result.note

    def status(self, num_bytes: int, *, is_fresh: bool, is_lost: bool) -> Status:
        """Return whether scans fit the map.

        Args:
            num_bytes: That the map takes.
            is_fresh: Whether scans come.
            is_lost: Whether no scan was trusted for too long.
        """
        values = {
            "scans": self._num_scans,
            "trusted": self._num_trusted,
            "longest scan (ms)": f"{self._worst_ms:.1f}",
            "map (MB)": f"{num_bytes / 1e6:.1f}",
            "found again": self._lost.num_found,
        }
        if not is_fresh:
            return Status(STALE, "no scans: pose and map->odom are not sent", values)
        if self._lost.is_looked_for:
            return Status(ERROR, f"lost, looking for it: {self._lost.reason}", values)
        if is_lost:
            return Status(ERROR, f"lost: {self._reason}", values)
        if self._reason:
            return Status(WARN, f"newest scan not trusted: {self._reason}", values)
        if self._note:
            judge = "odometry decides" if self._has_odom else "nothing else does either"
            return Status(WARN, f"{self._note}; {judge}", values)
        return Status(OK, "every scan fits the map", values)
