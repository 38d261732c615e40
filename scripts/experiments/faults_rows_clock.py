"""The faults of time: a clock that jumps, stands, or goes at another speed."""

from __future__ import annotations

import time

from experiments.faults_case import Act, Fault, changing, drive_up
from experiments.faults_changes import drop
from experiments.faults_graph import SIMULATOR, FaultGraph, set_parameters
from experiments.faults_judge import BASE, DIP, DRIVE, HALT, OTHER
from experiments.faults_rows_nodes import BASE_S

_S = 1_000_000_000
_BACK_NS, _FORWARD_NS = -5 * _S, 60 * _S
_PAUSE_S, _SLOW, _FAST = 4.0, 0.1, 10.0


def clock_faults() -> list[Fault]:
    """Return the faults of time."""
    alone = "zero in the next period: stamps and clock do not go together"
    return [
        Fault(
            name="clock-back", what="time jumps back 5 s, stamps and clock together (a bag's loop)",
            kind=DIP, expected="zero at once, then drives on", strike=_shift(_BACK_NS),
            mend=_shift(0),
        ),
        Fault(
            name="clock-forward", what="time jumps ahead 60 s, stamps and clock together",
            kind=OTHER, expected="touches nothing; drives on", strike=_shift(_FORWARD_NS),
            mend=_shift(0),
        ),
        Fault(
            name="clock-back-alone", what="/clock alone jumps back 5 s: stamps are of the future",
            kind=HALT, expected=alone, strike=_shift_clock(_BACK_NS), mend=_shift_clock(0),
        ),
        Fault(
            name="clock-forward-alone", what="/clock alone jumps ahead 60 s: stamps are old",
            kind=HALT, expected=alone, strike=_shift_clock(_FORWARD_NS), mend=_shift_clock(0),
        ),
        Fault(
            name="clock-stands", what="/clock comes no more; sensors do", kind=BASE,
            limit_s=BASE_S, stops_clock=True,
            expected="no period passes, the base brakes by its own limit of 0.5 s; the planner "
            "says it and sends zero after 2 s of real time", check=_is_said, hold_s=6.0,
            **changing("/clock", lambda: drop),
        ),
        Fault(
            name="clock-paused", what="the whole simulation is paused for 4 s of real time",
            kind=OTHER, expected="the planner says it; then drives on, nothing is lost",
            strike=_pause, hold_s=0.5, check=_was_said, stops_clock=True,
        ),
        Fault(
            name="clock-tenth", what="time goes at a tenth of real time", kind=DRIVE,
            expected="drives on as if nothing were", strike=_at(_SLOW), mend=_as_before, hold_s=1.5,
            note=_factor,
        ),
        Fault(
            name="clock-ten-times", kind=DRIVE,
            what="ten times real time is asked for; the simulation waits for the planner",
            expected="drives on", strike=_at(_FAST), mend=_as_before, note=_factor,
        ),
    ]  # fmt: skip


def _wait_past(graph: FaultGraph, ns: int) -> None:
    """Wait until so much time has passed that going back by it is a time still."""
    if graph.relay.now_ns <= ns:
        graph.spin_sim((ns - graph.relay.now_ns) * 1e-9 + 1.0)
        drive_up(graph)
        graph.notes["struck_ns"] = graph.relay.now_ns


def _shift(shift_ns: int) -> Act:
    def act(graph: FaultGraph) -> None:
        _wait_past(graph, -shift_ns)
        graph.relay.shift_ns = shift_ns

    return act


def _shift_clock(shift_ns: int) -> Act:
    def act(graph: FaultGraph) -> None:
        _wait_past(graph, -shift_ns)
        graph.relay.clock_shift_ns = shift_ns

    return act


def _set_up(graph: FaultGraph, **values: object) -> None:
    set_parameters(graph, SIMULATOR, **values)


def _at(factor: float) -> Act:
    def act(graph: FaultGraph) -> None:
        _set_up(graph, real_time_factor=factor)
        graph.notes["since"] = time.monotonic(), graph.sim_s

    return act


def _as_before(graph: FaultGraph) -> None:
    _set_up(graph, real_time_factor=graph.rtf)


def _factor(graph: FaultGraph) -> str:
    real, simulated = graph.notes["since"]
    factor = (graph.sim_s - simulated) / (time.monotonic() - real)
    return f"{factor:.2f} times real time was reached"


def _pause(graph: FaultGraph) -> None:
    _set_up(graph, paused=True)
    graph.notes["paused"] = False
    end = time.monotonic() + _PAUSE_S
    while time.monotonic() < end:
        graph.spin(0.1)
        if "/clock" in graph.watch.state[1]:
            graph.notes["paused"] = True
    _set_up(graph, paused=False)


def _was_said(graph: FaultGraph) -> str:
    return "" if graph.notes["paused"] else "the planner did not say that /clock stands still"


def _is_said(graph: FaultGraph) -> str:
    state, reason = graph.watch.state
    is_zero = bool(graph.watch.record.commands) and graph.watch.record.commands[-1].is_zero
    is_said = state == "stopped" and "/clock" in reason
    return "" if is_said and is_zero else f"the planner says {state}: {reason}"
