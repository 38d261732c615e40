"""When to decide: once a control period, and as a scan comes where one is due.

A timer alone lets a scan wait up to a whole period. Deciding at every scan would change how often
a method is asked. So the period's phase follows the scans: a decision that is due a little early
is made as a scan comes, and one that is due just before a scan is expected waits for it a little.
"""

from __future__ import annotations

_EARLY, _LATE = 0.6, 1.4  # periods since the last decision
_KEEPS = 0.8  # of what was known of the time between scans
_LONGEST_NS = 1_000_000_000  # a longer silence says nothing of the time between scans


class ControlPace:
    """Says when the next decision is due; times are of one clock, ns.

    Args:
        period_s: The control period.
    """

    def __init__(self, period_s: float) -> None:
        self._period_ns = period_s * 1e9
        self.restart()

    def restart(self) -> None:
        """Forget all; for when the clock jumped."""
        self._decided_ns: int | None = None
        self._scan_ns: int | None = None
        self._between_ns = 0.0

    def decided(self, now_ns: int) -> None:
        """Note a decision."""
        self._decided_ns = now_ns

    def is_due_at_scan(self, now_ns: int) -> bool:
        """Note a scan, and return whether to decide now."""
        between = now_ns - self._scan_ns if self._scan_ns is not None else 0
        if 0 < between < _LONGEST_NS:
            known = self._between_ns or between
            self._between_ns = _KEEPS * known + (1.0 - _KEEPS) * between
        self._scan_ns = now_ns
        return self._since(now_ns) >= _EARLY * self._period_ns

    def wait_ns(self, now_ns: int) -> int:
        """Return how long to wait with the decision that the timer asks for; 0: decide now."""
        since = self._since(now_ns)
        if not self._between_ns or self._scan_ns is None or since >= _LATE * self._period_ns:
            return 0
        until_scan = self._scan_ns + self._between_ns - now_ns
        if abs(until_scan) > (_LATE - 1.0) * self._period_ns:
            return 0
        return max(1, round(_LATE * self._period_ns - since))

    def _since(self, now_ns: int) -> float:
        return float("inf") if self._decided_ns is None else float(now_ns - self._decided_ns)
