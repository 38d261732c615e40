"""How fast simulated time really goes; nothing here reads a clock."""

from __future__ import annotations

from collections import deque

_SHARE = 0.9


class RealTime:
    """The factor reached over the last seconds, beside the one asked for.

    Args:
        window_s: Real time that the factor is taken over.
    """

    def __init__(self, window_s: float = 5.0) -> None:
        self._window_s = window_s
        self._seen: deque[tuple[float, float]] = deque()

    def look(self, now: float, sim: float) -> None:
        """Take in real and simulated time, s; simulated time that went back starts afresh."""
        if self._seen and sim < self._seen[-1][1]:
            self._seen.clear()
        self._seen.append((now, sim))
        while len(self._seen) > 2 and now - self._seen[1][0] >= self._window_s:
            self._seen.popleft()

    def restart(self) -> None:
        """Forget what was: time stands still on purpose."""
        self._seen.clear()

    @property
    def factor(self) -> float | None:
        """Simulated seconds in a second; None before a whole window was seen."""
        if not self._seen or self._seen[-1][0] - self._seen[0][0] < self._window_s:
            return None
        (start, sim_start), (end, sim_end) = self._seen[0], self._seen[-1]
        return (sim_end - sim_start) / (end - start)

    def complaint(self, asked: float) -> str:
        """Return what to say if less than nine tenths of the factor asked for are reached."""
        factor = self.factor
        if not asked or factor is None or factor >= _SHARE * asked:
            return ""
        return f"runs at {factor:.2f} of real time, {asked:.2f} asked"
