"""Whether the robot still knows where it is, from which scans could be trusted."""

from __future__ import annotations


class Tracking:
    """Lost before the first trusted scan, and after too long without one.

    Attributes:
        is_lost: Whether the pose is not to be used.
    """

    def __init__(self) -> None:
        self.is_lost = True
        self._trusted_ns: int | None = None

    def lose(self) -> None:
        """Be lost until the next trusted scan: scans stopped, or time jumped."""
        self.is_lost, self._trusted_ns = True, None

    def update(self, stamp_ns: int, is_trusted: bool, lost_after_s: float) -> None:
        """Take the verdict on a scan; stamps may jump back."""
        if is_trusted:
            self._trusted_ns = stamp_ns
        elif self._trusted_ns is not None:
            self._trusted_ns = min(self._trusted_ns, stamp_ns)
        silent_ns = 0 if self._trusted_ns is None else stamp_ns - self._trusted_ns
        self.is_lost = self._trusted_ns is None or silent_ns > lost_after_s * 1e9
