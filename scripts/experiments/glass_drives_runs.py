"""One run of the glass drives: place, robot, and the judge who knows the truth.

A touch of glass is one of a pane or of the frame that holds it, by the engine or by the outline; it
ends the run. Ways are held against the shortest one, by A* on the true floor 0.3 m off everything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.glass_drives_robot import PERIOD_NS, MappingRobot, Row
from experiments.glass_drives_worlds import Place, place_of
from experiments.glass_paths import drivable, plan
from experiments.glass_truth import lattice_round, signed_distance_near
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge import drive as base
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.solids import Solid, solids_of

LIMIT_S = 90.0  # for each goal
ROWS = {
    "sjmc": Row("sjmc"),
    "vfh_plus": Row("vfh_plus"),
    "sjmc, path only": Row("sjmc", minds_map=False, listens=False),
    "vfh_plus, path only": Row("vfh_plus", minds_map=False, listens=False),
    "sjmc, laser only": Row("sjmc", has_sonar=False),
    "vfh_plus, laser only": Row("vfh_plus", has_sonar=False),
}
GLASS_NAMES = ("glass", "frame")
_PER_EDGE = 12
_TRACK_EVERY = 25  # steps between two kept poses
_HEIGHT_M = 0.41
_NEAR_M = 1.6  # from the base to a solid that is judged: the outline reaches 0.57 m


@dataclass(frozen=True)
class Task:
    """A run to make.

    Attributes:
        number: The run's: with the seed it settles the place.
        row: One of `ROWS`.
        seed: Of the experiment.
    """

    number: int
    row: str
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What is kept of a run.

    Attributes:
        kind: Of the place.
        touched: What was touched: `glass`, `thing` or "".
        is_reached: Whether it stood at each goal in time, and had touched nothing.
        num_reached: Goals that it came to.
        time_s: Until it was there, touched something or gave up.
        path_m: Way driven.
        path_ratio: That over the shortest true way; of runs that reached all goals.
        min_glass_m: Least distance between the outline and glass.
        pose_error_m: Farthest that its own pose was off.
        state: State and reason at the end.
        track: x, y, yaw in the world, shape (N, 3).
        glass: Places of `map/glass` at the end in the world, shape (K, 2), m.
    """

    kind: str
    touched: str
    is_reached: bool
    num_reached: int
    time_s: float
    path_m: float
    path_ratio: float
    min_glass_m: float
    pose_error_m: float
    state: tuple[str, str]
    track: np.ndarray
    glass: np.ndarray


def run_task(task: Task) -> Outcome:
    """Make a run; the same task gives the same outcome, in any process."""
    place = place_of(task.seed, task.number)
    simulation = Simulation(place.world, seed=10_000 * task.seed + task.number)
    try:
        return _Run(simulation, place, ROWS[task.row]).outcome()
    finally:
        simulation.close()


class _Run:
    def __init__(self, simulation: Simulation, place: Place, row: Row) -> None:
        self._simulation, self._place = simulation, place
        ((self._name, model),) = simulation.models.items()
        self._T_world_map = simulation.starts[self._name]
        self._goals = [self._T_world_map.inverse() @ np.array([g]) for g in place.goals]
        self._robot = MappingRobot(row, model, self._goals[0][0])
        self._outline = _outline(model.config.footprint_m)
        low = [s for s in simulation.solids if s.bottom < _HEIGHT_M]
        self._glass = _Near([s for s in low if s.name in GLASS_NAMES])
        self._things = _Near([s for s in low if s.name not in GLASS_NAMES])
        self._track: list[tuple[float, float, float]] = []
        self._touched, self._path, self._error = "", 0.0, 0.0
        self._nearest = math.inf
        self._last: SE2 | None = None

    def outcome(self) -> Outcome:
        """Drive to the goals in turn and return what came of it."""
        num = 0
        for goal in self._goals:
            if num:
                self._robot.set_goal(goal[0])
            if not self._leg():
                break
            num += 1
        is_reached = num == len(self._goals)
        robot, stamp_ns = self._robot, self._simulation.stamp_ns
        glass = np.zeros((0, 2))
        if robot.glass is not None:
            glass = self._T_world_map @ robot.glass.to_points(np.argwhere(robot.glass.cells == 100))
        return Outcome(
            kind=self._place.kind, touched=self._touched, is_reached=is_reached, num_reached=num,
            time_s=stamp_ns * 1e-9, path_m=self._path,
            path_ratio=self._path / shortest(self._place) if is_reached else math.nan,
            min_glass_m=self._nearest, pose_error_m=self._error, state=robot.state,
            track=np.array(self._track, dtype=np.float32).reshape(-1, 3),
            glass=np.asarray(glass, dtype=np.float32),
        )  # fmt: skip

    def _leg(self) -> bool:
        """Drive until it stands at its goal; False if it touched something or time is up."""
        sent = base.STOP
        for step in range(round(LIMIT_S * 1e9 / STEP_NS)):
            is_due = step % (PERIOD_NS // STEP_NS) == 0
            if is_due:
                sent = self._robot.command(self._simulation.stamp_ns)
                if self._robot.is_there:
                    return True
            seen = self._simulation.step({self._name: sent} if is_due else {})
            mine = seen.robots[self._name]
            self._robot.take(seen.stamp_ns, mine)
            self._judge(step, mine.ground_truth.pose, mine.ground_truth.is_touching)
            if self._touched:
                return False
        return False

    def _judge(self, step: int, pose: SE2, is_touching: bool) -> None:
        if self._last is not None:
            self._path += self._last.between(pose).distance
        self._last = pose
        if step % _TRACK_EVERY == 0:
            self._track.append((pose.x, pose.y, pose.yaw))
        if step % (PERIOD_NS // STEP_NS) and not is_touching:
            return
        thought = self._T_world_map @ self._robot.T_map_base
        self._error = max(self._error, math.hypot(thought.x - pose.x, thought.y - pose.y))
        outline = pose @ self._outline
        to_glass, to_thing = self._glass.least(pose, outline), self._things.least(pose, outline)
        self._nearest = min(self._nearest, to_glass)
        if is_touching or min(to_glass, to_thing) <= 0.0:
            self._touched = "glass" if to_glass <= to_thing else "thing"
            self._track.append((pose.x, pose.y, pose.yaw))


def shortest(place: Place) -> float:
    """Return the length of the shortest true way over all goals, m."""
    solids = [s for s in solids_of(place.world) if s.bottom < _HEIGHT_M]
    lattice = lattice_round(np.vstack([s.outline() for s in solids]))
    cells = np.where(signed_distance_near(lattice, solids) <= 0.0, np.int8(100), np.int8(0))
    truth = OccupancyMap(cells, lattice.resolution, lattice.origin)
    can_drive = drivable(truth)
    ends = np.array([place.world.robots[0].position_m, *place.goals])
    ways = [plan(truth, can_drive, a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    if any(way is None for way in ways):
        return math.nan
    return sum(float(np.hypot(*np.diff(way, axis=0).T).sum()) for way in ways if way is not None)


def figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the figures of one row; times and ways are of the runs that reached all goals."""
    there = [o for o in outcomes if o.is_reached]
    return {
        "runs": len(outcomes),
        "touched_glass": sum(o.touched == "glass" for o in outcomes),
        "touched_things": sum(o.touched == "thing" for o in outcomes),
        "reached": len(there),
        "goals_reached": sum(o.num_reached for o in outcomes),
        "time_s": _median([o.time_s for o in there]),
        "path_ratio": _median([o.path_ratio for o in there]),
        "least_glass_m": min((max(o.min_glass_m, 0.0) for o in outcomes), default=None),
        "pose_error_max_m": max((o.pose_error_m for o in outcomes), default=None),
    }


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


class _Near:
    """Solids, of which those near the robot are looked at."""

    def __init__(self, solids: list[Solid]) -> None:
        self._solids = solids
        middles = [(s.pose.x, s.pose.y, math.hypot(*s.size[:2]) / 2.0) for s in solids]
        self._middles = np.array(middles).reshape(-1, 3)

    def least(self, pose: SE2, points: np.ndarray) -> float:
        """Return the least distance of points of the robot to a solid, m; inf beyond 1 m or so."""
        x, y, radius = self._middles.T
        near = np.flatnonzero(np.hypot(x - pose.x, y - pose.y) - radius < _NEAR_M)
        return min(
            (float(self._solids[k].signed_distance(points).min()) for k in near), default=math.inf
        )


def _outline(corners: Sequence[Sequence[float]]) -> np.ndarray:
    """Return points along the edges of a footprint, shape (N, 2), m."""
    ends = np.array(corners)
    share = np.arange(_PER_EDGE) / _PER_EDGE
    edges = [a + share[:, None] * (b - a) for a, b in zip(ends, np.roll(ends, -1, 0), strict=True)]
    return np.vstack(edges)
