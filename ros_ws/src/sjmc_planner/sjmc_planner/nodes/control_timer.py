"""Calls for a decision once a control period, in step with the scans."""

from __future__ import annotations

from collections.abc import Callable

from floornav_common.ros.node import FloornavNode
from sjmc_planner.control_pace import ControlPace


class ControlTimer:
    """A timer that a `ControlPace` moves.

    Args:
        node: The node.
        period_s: The control period.
        decide: Called when a decision is due.
    """

    def __init__(self, node: FloornavNode, period_s: float, decide: Callable[[], None]) -> None:
        self._time, self._decide = node.time, decide
        self._period_ns = round(period_s * 1e9)
        self._pace = ControlPace(period_s)
        node.time.on_restart(self._pace.restart)
        self._timer = node.create_timer(period_s, self._look)

    def take_scan(self) -> None:
        """Note that a scan came: a decision that is nearly due is made with it."""
        if self._pace.is_due_at_scan(self._time.read_ns()):
            self._go()

    def _look(self) -> None:
        wait_ns = self._pace.wait_ns(self._time.read_ns())
        if wait_ns:
            self._wait(wait_ns)
        else:
            self._go()

    def _go(self) -> None:
        self._pace.decided(self._time.read_ns())
        self._wait(self._period_ns)
        self._decide()

    def _wait(self, wait_ns: int) -> None:
        self._timer.timer_period_ns = wait_ns
        self._timer.reset()
