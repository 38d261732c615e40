"""The rule of time: on which clock silence is counted, and what a clock may do.

On a robot silence is counted on the steady clock, which nobody sets. In simulation it is counted
in simulated time, so that a tenth of real time, ten times or a pause changes nothing; then a
`/clock` that stands still is a fault of its own, and one that jumps back starts everything afresh.
Nothing here reads a clock: both times are handed in.

Silence is a difference, so what is handed out is a count of the time that passed on the clock
that counts: it never runs back, and the first `/clock` after a start is no silence of fifty years.
"""

from __future__ import annotations

from collections.abc import Callable

STOPPED_AFTER_NS = 2_000_000_000


class TimeWatch:
    """Follows the steady and the simulated clock.

    Args:
        stopped_after_ns: How long `/clock` may stand still, in steady time, ns.
    """

    def __init__(self, stopped_after_ns: int = STOPPED_AFTER_NS) -> None:
        """Start before the first update."""
        self._stopped_after_ns = stopped_after_ns
        self._steady_ns: int | None = None
        self._sim_ns: int | None = None
        self._passed_ns = 0
        self._moved_at_ns = 0
        self._on_restart: list[Callable[[], None]] = []

    @property
    def now_ns(self) -> int:
        """Time passed since the first update on the clock silence is counted on, ns."""
        return self._passed_ns

    @property
    def is_simulated(self) -> bool:
        """Whether simulated time counts."""
        return self._sim_ns is not None

    @property
    def stopped_for_ns(self) -> int:
        """How long `/clock` has stood still, in steady time, ns; 0 without simulated time."""
        if self._sim_ns is None or self._steady_ns is None:
            return 0
        return self._steady_ns - self._moved_at_ns

    @property
    def is_stopped(self) -> bool:
        """Whether `/clock` has stood still, or never come, for longer than allowed."""
        return self.stopped_for_ns >= self._stopped_after_ns

    def on_restart(self, callback: Callable[[], None]) -> None:
        """Call back whenever time starts afresh: the clock jumped back or changed its kind."""
        self._on_restart.append(callback)

    def update(self, steady_ns: int, sim_ns: int | None) -> bool:
        """Take in both clocks; `sim_ns` is None without `use_sim_time`, 0 before the first /clock.

        Returns:
            Whether time started afresh; callbacks have been called.
        """
        before_steady_ns, before_sim_ns = self._steady_ns, self._sim_ns
        self._steady_ns, self._sim_ns = steady_ns, sim_ns
        if sim_ns != before_sim_ns:
            self._moved_at_ns = steady_ns
        if before_steady_ns is None:
            return False
        if sim_ns is None and before_sim_ns is None:
            self._passed_ns += steady_ns - before_steady_ns
            return False
        if sim_ns is not None and before_sim_ns is not None and sim_ns >= before_sim_ns:
            # 0 is a clock that has not come yet.
            self._passed_ns += sim_ns - before_sim_ns if before_sim_ns else 0
            return False
        for callback in self._on_restart:
            callback()
        return True


class Deadline:
    """Silence of one input: over once nothing came for `timeout_ns`.

    Args:
        timeout_ns: How long silence is allowed, ns.
    """

    def __init__(self, timeout_ns: int) -> None:
        """Start at the first look, so that a start-up is not a fault at once."""
        self.timeout_ns = timeout_ns
        self._since_ns: int | None = None
        self._has_heard = False

    @property
    def has_heard(self) -> bool:
        """Whether something came since the start or the last restart."""
        return self._has_heard

    def feed(self, now_ns: int) -> None:
        """Note that the input came."""
        self._since_ns, self._has_heard = now_ns, True

    def silence_ns(self, now_ns: int) -> int:
        """Return how long nothing came, ns; counted from the first look if nothing ever came."""
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns

    def is_over(self, now_ns: int) -> bool:
        """Return whether the silence is longer than allowed."""
        return self.silence_ns(now_ns) > self.timeout_ns

    def restart(self) -> None:
        """Forget what came, as when the clock jumps back: count from the next look."""
        self._since_ns, self._has_heard = None, False


class Throttle:
    """Lets one thing through in a while, such as a warning.

    Args:
        period_ns: At least this long between two, ns.
    """

    def __init__(self, period_ns: int) -> None:
        """Start ready."""
        self._period_ns = period_ns
        self._last_ns: int | None = None

    def is_due(self, steady_ns: int) -> bool:
        """Return whether the next may pass now, and note it."""
        if self._last_ns is not None and steady_ns - self._last_ns < self._period_ns:
            return False
        self._last_ns = steady_ns
        return True
