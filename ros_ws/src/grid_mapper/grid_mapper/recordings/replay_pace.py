"""When the messages of a recording are due, at any speed; both clocks of it are handed in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from grid_mapper.recordings.playback import PlayWindow

LONGEST_SLEEP_S = 0.05


class Stopped(Exception):  # noqa: N818, not an error
    """Was asked to stop."""


@dataclass(frozen=True)
class ReplayPace:
    """When recorded times are due: the start of the window is due at `began_s`.

    Attributes:
        window: What is played.
        rate: Recorded seconds in a second.
        clock_hz: How often time is told while waiting; 0 for never.
        began_s: Start of the replay on the steady clock.
        now_s: Reads the steady clock, s.
        sleep: Sleeps, s; it may take longer.
    """

    window: PlayWindow
    rate: float
    clock_hz: float
    began_s: float
    now_s: Callable[[], float]
    sleep: Callable[[float], None]

    def due_s(self, recorded_ns: int) -> float:
        """Return when a recorded time is due on the steady clock."""
        return self.began_s + (recorded_ns - self.window.start_ns) * 1e-9 / self.rate

    def recorded_ns(self, now_s: float) -> int:
        """Return the recorded time that is due at a time of the steady clock."""
        return self.window.start_ns + round((now_s - self.began_s) * self.rate * 1e9)

    def wait_for(
        self, recorded_ns: int, tick: Callable[[int], None], should_stop: Callable[[], bool]
    ) -> None:
        """Sleep until a recorded time is due, and tell the time meanwhile.

        Args:
            recorded_ns: What is waited for; one that is overdue is not waited for.
            tick: Called with the recorded time that it is, which is never behind `recorded_ns`.
            should_stop: Asked before each sleep, and at least once.

        Raises:
            Stopped: If asked to stop.
        """
        due_s = self.due_s(recorded_ns)
        period_s = 1.0 / self.clock_hz if self.clock_hz > 0.0 else LONGEST_SLEEP_S
        while not should_stop():
            now_s = self.now_s()
            if now_s >= due_s:
                return
            next_tick_s = self._next_tick_s(now_s, period_s)
            self.sleep(max(0.0, min(due_s, next_tick_s, now_s + LONGEST_SLEEP_S) - now_s))
            if self.now_s() >= next_tick_s:
                tick(min(self.recorded_ns(self.now_s()), recorded_ns))
        raise Stopped

    def _next_tick_s(self, now_s: float, period_s: float) -> float:
        """Return the first instant of the clock behind now."""
        num_ticks = int((now_s - self.began_s) / period_s)
        while (at_s := self.began_s + num_ticks * period_s) <= now_s:
            num_ticks += 1
        return at_s
