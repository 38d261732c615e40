"""One fault: what is done, what is expected, and how it is run in the graph that drives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from experiments.faults_graph import EXCEPTION, FaultGraph, GraphError
from experiments.faults_judge import BASE, Verdict, between, judge
from experiments.faults_result import Row, Trace

_STEADY_TURN, _NEAR_POSE_M = 0.25, 0.5
_ATTEMPTS = 4
_SHOWN_NS = 1_000_000_000
_RECOVERY_S, _UP_S = 60.0, 90.0
_UNANSWERED = "cmd_vel does not answer: going on without it"  # sim_bridge's words

Act = Callable[[FaultGraph], None]


def _nothing(_graph: FaultGraph) -> None:
    return None


def _no_problem(_graph: FaultGraph) -> str:
    return ""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault.

    Attributes:
        name: For the command line.
        what: Is wrong, in words.
        kind: What must happen, of `faults_judge`.
        expected: The same in words, and more.
        strike: Brings it about, while the robot drives.
        mend: Ends it.
        hold_s: How long it lasts, simulated.
        has_time: False where the simulator's time stands still: then it is real time.
        stops_clock: Whether a `/clock` that stands still belongs to it.
        limit_s: The limit on silence after which the robot must stop.
        topic: Whose last message before the fault (with a limit) or first changed one the time
            to a stop is counted from; "" = from the strike.
        is_first_good: Whether the first changed one is still good, and the limit counts from it.
        check: Looks before it ends; gives what is wrong, "" for nothing.
        after: Looks when the robot drives again; gives what is wrong.
        note: Looks before it ends; gives what else was seen.
    """

    name: str
    what: str
    kind: str
    expected: str
    strike: Act
    mend: Act = _nothing
    hold_s: float = 3.0
    has_time: bool = True
    stops_clock: bool = False
    limit_s: float = 0.0
    topic: str = ""
    is_first_good: bool = False
    check: Callable[[FaultGraph], str] = _no_problem
    after: Callable[[FaultGraph], str] = _no_problem
    note: Callable[[FaultGraph], str] = _no_problem


@dataclass(frozen=True)
class _Before:
    cells: int
    goals_again: int
    traces: int
    poses: int
    scans: int


def run_fault(graph: FaultGraph, fault: Fault) -> Row:
    """Run a fault; anew where the machine was too busy for it. A touch is never excused so."""
    number, why, touches = 0, "", graph.watch.record.touches
    while True:
        number += 1
        num_stops, num_touches = graph.watch.num_clock_stops, len(touches)
        row = _run_once(graph, fault)
        if graph.watch.num_clock_stops != num_stops and not fault.stops_clock:
            why = "the machine stood still for 2 s"
        elif not row.safe and graph.notes["unanswered"]:
            why = "time went on for want of the planner's commands"
        else:
            break
        if not row.recovered or number == _ATTEMPTS or len(touches) > num_touches:
            break
    if number > 1:
        row.seen += f"; run {number} times, as {why}"
    return row


def _run_once(graph: FaultGraph, fault: Fault) -> Row:
    """Wait until the robot drives, strike, look, mend, and wait until it drives again."""
    drive_up(graph)
    before = _before(graph)
    graph.notes["struck_ns"] = graph.relay.now_ns
    fault.strike(graph)
    struck_ns = graph.notes["struck_ns"]  # it may have had to get ready first
    num_unanswered = graph.count_logged(_UNANSWERED)
    _hold(graph, fault)
    graph.notes["unanswered"] = graph.count_logged(_UNANSWERED) - num_unanswered
    problem, end_ns, note = fault.check(graph), graph.relay.now_ns, fault.note(graph)
    due_ns = _due(graph, fault, struck_ns)
    record = graph.watch.record
    verdict = judge(record, fault.kind, struck_ns, due_ns, end_ns, graph.setup.decel)
    fault.mend(graph)
    recover_s = _recovery(graph, end_ns)
    problem = problem or fault.after(graph) or _aftermath(graph, before, end_ns)
    row = _row(graph, fault, verdict, problem, recover_s, _lost(graph, before))
    row.seen += f"; {note}" if note else ""
    row.trace = _trace(graph, struck_ns, due_ns, end_ns)
    return row


def _trace(graph: FaultGraph, struck_ns: int, due_ns: int, end_ns: int) -> Trace:
    record, now_ns = graph.watch.record, graph.relay.now_ns
    first, last = struck_ns - _SHOWN_NS, min(now_ns, end_ns + 5 * _SHOWN_NS)
    parts = (between(moments, first, last) for moments in (record.commands, record.motion))
    return Trace(*parts, struck_ns, due_ns, end_ns)


def _hold(graph: FaultGraph, fault: Fault) -> None:
    if fault.has_time:
        graph.spin_sim(fault.hold_s)
    else:
        graph.spin(fault.hold_s)


def drive_up(graph: FaultGraph) -> None:
    """Wait until the robot drives straight, with room ahead of it and a pose that is right."""
    graph.wait(
        lambda: _is_driving(graph) and _room(graph) > graph.setup.room_m,
        "a robot that drives",
        _UP_S,
    )


def _is_driving(graph: FaultGraph) -> bool:
    motion = graph.watch.record.motion
    if not motion or graph.watch.state[0] != "driving":
        return False
    if graph.setup.has_map:
        error = graph.watch.pose_error(graph.T_world_goals)
        if error is None or error > _NEAR_POSE_M:
            return False
    is_straight = abs(motion[-1].yaw_rate) < _STEADY_TURN
    return motion[-1].speed > graph.setup.speed and is_straight


def _room(graph: FaultGraph) -> float:
    """Return the distance to the goal in force, m."""
    goal = graph.T_world_goals @ graph.watch.goal[None, :]
    _, pose, _ = graph.watch.truth[-1]
    return math.hypot(goal[0, 0] - pose.x, goal[0, 1] - pose.y)


def _before(graph: FaultGraph) -> _Before:
    watch = graph.watch
    return _Before(
        watch.known_cells, watch.num_goals_again, graph.count_logged(EXCEPTION),
        watch.counts.get("pose", 0), _num_scans(graph),
    )  # fmt: skip


def _num_scans(graph: FaultGraph) -> int:
    return graph.relay.passed["scan"].num if "scan" in graph.relay.passed else 0


def _due(graph: FaultGraph, fault: Fault, struck_ns: int) -> int:
    """Return from when on the robot must stop, or has to begin to."""
    if fault.kind == BASE:
        moving = [m.ns for m in graph.watch.record.commands if not m.is_zero]
        return (moving[-1] if moving else struck_ns) + round(fault.limit_s * 1e9)
    if not fault.topic:
        return struck_ns + round(fault.limit_s * 1e9)
    passed = graph.relay.passed[fault.topic]
    changed_ns = struck_ns if passed.changed_ns is None else passed.changed_ns
    if not fault.limit_s:
        return changed_ns
    last_ns = changed_ns if fault.is_first_good else passed.last_ns
    return last_ns + round(fault.limit_s * 1e9)


def _recovery(graph: FaultGraph, end_ns: int) -> float | None:
    try:
        graph.wait(lambda: _is_driving(graph), "a robot that drives again", _RECOVERY_S)
    except GraphError:
        return None
    return (graph.relay.now_ns - end_ns) * 1e-9


def _aftermath(graph: FaultGraph, before: _Before, end_ns: int) -> str:
    """Return what the fault left: a touch on the way out of it, or an unhandled exception."""
    if any(ns > end_ns for ns in graph.watch.record.touches):
        return "the robot touched something after it"
    num = graph.count_logged(EXCEPTION) - before.traces
    return f"{num} unhandled exceptions" if num else ""


def _lost(graph: FaultGraph, before: _Before) -> str:
    watch = graph.watch
    scans = _num_scans(graph) - before.scans
    poses = max(0, scans - (watch.counts.get("pose", 0) - before.poses))
    cells = max(0, before.cells - watch.known_cells)
    again = watch.num_goals_again - before.goals_again
    texts = [f"{poses} poses"] * (poses > 2) + [f"{cells} cells of the map"] * (cells > 0)
    return ", ".join(texts + [f"the goal, sent {again} times more"] * (again > 0))


def _row(
    graph: FaultGraph, fault: Fault, verdict: Verdict, problem: str, recover_s: float | None,
    lost: str,
) -> Row:  # fmt: skip
    error = graph.watch.pose_error(graph.T_world_goals)
    seen = verdict.seen + (f"; {problem}" if problem else "")
    if recover_s is None:
        mapping = graph.watch.said.get("/grid_mapper: mapping", ("", ""))[1]
        seen += f"; planner: {': '.join(graph.watch.state)}; mapper: {mapping}"
    elif error is not None and error > 0.1:
        seen += f"; pose {error:.2f} m off"
    return Row(
        name=fault.name, what=fault.what, expected=fault.expected, seen=seen,
        safe=verdict.is_safe and not problem, recovered=recover_s is not None,
        stop_ms=verdict.stop_ms, stand_s=verdict.stand_s, recover_s=recover_s, lost=lost,
        kind=fault.kind, graph=graph.setup.name,
    )  # fmt: skip


def changing(topics: str, make: Callable[[], Any]) -> dict[str, Act]:
    """Return what sets a change on each of some topics, and what takes it away."""

    def strike(graph: FaultGraph) -> None:
        for topic in topics.split():
            graph.relay.set_change(topic, make())

    def mend(graph: FaultGraph) -> None:
        for topic in topics.split():
            graph.relay.set_change(topic, None)

    return {"strike": strike, "mend": mend}
