"""Time of one control step of each planning method among 20 people, beside ORCA and the rest.

A robot drives through a room of 20 people who walk; each step has a new scan of 360 or 1081 beams
(a full turn). The methods go through it one after the other, in turns. Times are of the whole
`decide`, from ranges to a command, in processor time of its one thread, so that other work on the
machine is not in them. Peer of every row: ORCA (`pyrvo`) told the truth about 20 people, no walls,
with its agents set from Python; floor: its bare `do_step`. `orca` and `dwa` are the methods that
our experiments hold ours against, from a scan too; `tracker` is what follows people in `sjmc`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pyrvo

from experiments.people_scans import Moment, walk_through
from experiments.planner_peers import PEERS
from experiments.timing import Case, median_and_p99
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import STILL, Goal, Obstacles, RobotState, Velocity

NUM_PEOPLE, NUM_SCANS, NUM_RUNS = 20, 60, 4
PERIOD_S = 0.1
BEAMS = (360, 1081)
_BEFORE = 5  # scans that do not count: nobody is known yet
_PEER = "ORCA told the truth"
_ROBOT = RobotConfig(drive="differential", radius_m=0.3, margin_m=0.05, speed_m_s=0.833,
                     accel_m_s2=0.8)  # fmt: skip
Step = Callable[[Moment, SE2], object]


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each method and number of beams."""
    cases = []
    for num_beams in BEAMS:
        say(f"planners: {num_beams} beams, {NUM_PEOPLE} people, {len(_steps())} methods")
        moments = list(walk_through(NUM_PEOPLE, num_beams, NUM_SCANS, PERIOD_S, seed))
        ms: dict[str, list[float]] = {}
        for _ in range(NUM_RUNS):
            _drive_once(moments, ms)
        values = {name: np.array(v) for name, v in ms.items()}
        peer, floor = (float(np.median(values.pop(k))) for k in ("peer", "floor"))
        for name, times in values.items():
            median, p99 = median_and_p99(times)
            extra = {"median_us": 1e3 * median, "least_us": 1e3 * float(times.min())}
            title = f"{name}, {num_beams} beams"
            cases.append(Case(title, median, p99, _PEER, peer, floor, extra))
    return cases


def _drive_once(moments: list[Moment], ms: dict[str, list[float]]) -> None:
    """Go through the room once by each method, new each time; add the time of each step in ms."""
    for name, step in _steps().items():
        last = moments[0].pose
        for number, moment in enumerate(moments):
            moved, last = last.between(moment.pose), moment.pose
            started = time.thread_time()
            step(moment, moved)
            took = 1e3 * (time.thread_time() - started)
            if number >= _BEFORE:
                ms.setdefault(name, []).append(took)


def _steps() -> dict[str, Step]:
    """Return every method by name, each with nothing known yet."""
    config = LocalPlannerConfig(robot=_ROBOT, control_period_s=PERIOD_S)
    methods: dict[str, Any] = {
        name: make_method(LocalPlannerConfig(method=name, robot=_ROBOT, control_period_s=PERIOD_S))
        for name in METHODS
    }
    methods |= {name: make(config) for name, make in PEERS.items()}
    steps: dict[str, Step] = {name: _step_of(method) for name, method in methods.items()}
    tracker = PeopleTracker(config.tracking)
    steps["tracker"] = lambda moment, moved: tracker.update(
        Obstacles(moment.scan, SE2.identity()), moved, PERIOD_S
    )
    bare = _simulator()
    return {**steps, "peer": lambda moment, _: _orca(moment), "floor": lambda *_: bare.do_step()}


def _step_of(method: Any) -> Step:
    def step(moment: Moment, moved: SE2) -> object:
        state = RobotState(Velocity(0.5, 0.0, 0.0), STILL, moved)
        goal = Goal(np.array([20.0, 0.0]), 20.0)
        return method.decide(state, Obstacles(moment.scan, SE2.identity()), goal)

    return step


def _orca(moment: Moment) -> object:
    """Return ORCA's velocity among people whose states it is told."""
    simulator = _simulator(moment.people)
    simulator.do_step()
    return simulator.get_agent_velocity(0)


def _simulator(people: np.ndarray | None = None) -> Any:
    if people is None:
        people = np.random.default_rng(0).uniform(-5.0, 5.0, (NUM_PEOPLE, 4))
    simulator = pyrvo.RVOSimulator()
    simulator.set_time_step(PERIOD_S)
    simulator.add_agent([0.0, 0.0], 6.0, 10, 3.0, 1.5, 0.35, _ROBOT.speed_m_s, [0.5, 0.0])
    simulator.set_agent_pref_velocity(0, [_ROBOT.speed_m_s, 0.0])
    for x, y, vx, vy in people.tolist():
        simulator.add_agent([x, y], 6.0, 10, 3.0, 1.5, 0.25, 1.5, [vx, vy])
    return simulator
