"""One drive over several goals in lockstep: world, map, way, method and robot, all in one process.

The robot knows what a robot knows. It localizes and maps by its scans (and, with glass, by its
sonars), plans on that map and drives by a method of `sjmc_planner`, each as often as its node
does; what it decides is sent one period later. The truth is for the judge alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from experiments.goal_record import GoalRecord
from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from sim_bridge import drive as base
from sim_bridge.observations import RobotObservation
from sim_bridge.simulation import Simulation
from sim_bridge.world import World
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.limited_motion import ramped
from sjmc_planner.methods import make_method
from sjmc_planner.path_target import PathTarget
from sjmc_planner.planning import REACHED, STILL, Goal, Obstacles, RobotState, Velocity
from sjmc_planner.route_keeper import RouteKeeper
from sjmc_planner.wavefront_config import WavefrontConfig

GOAL_LIMIT_S = 60.0
"""A goal not reached in this time is left for the next."""
_CYCLE_NS, _MAP_NS, _LOOK_NS = 50_000_000, 1_000_000_000, 500_000_000


@dataclass(frozen=True)
class Pilot:
    """What drives.

    Attributes:
        planner: Method and robot.
        wavefront: For the way.
        mapper: Of the map.
        has_glass: Whether sonars put glass into the map; else the laser alone makes it.
        goal_limit_s: A goal not reached in this time is left for the next.
    """

    planner: LocalPlannerConfig
    wavefront: WavefrontConfig
    mapper: GridMapperConfig
    has_glass: bool
    goal_limit_s: float = GOAL_LIMIT_S


@dataclass(frozen=True)
class GoalDrive:
    """What came of it.

    Attributes:
        record: For the judge.
        grid: The last map, in the map's frame, which is the start pose.
        poses: (stamp_ns, pose in the map's frame) of every scan.
    """

    record: GoalRecord
    grid: OccupancyMap
    poses: list[tuple[int, SE2]]


def drive_goals(
    world: World,
    pilot: Pilot,
    seed: int,
    limit_s: float | None = None,
    on_step: Callable[[float], None] = lambda time_s: None,
) -> GoalDrive:
    """Drive a world's goals one after the other.

    Args:
        world: With goals and one robot that has a laser; its cameras see nothing here.
        pilot: What drives.
        seed: Of the simulation.
        limit_s: Simulated time after which it ends, goals or not; None = with the last goal.
        on_step: Told the simulated time, s, once a second of it.
    """
    off = {"omni": None, "stereo": None}
    robots = tuple(replace(r, overrides={**r.overrides, **off}) for r in world.robots)
    simulation = Simulation(replace(world, robots=robots), seed=seed)
    try:
        return _Drive(simulation, pilot).run(math.inf if limit_s is None else limit_s, on_step)
    finally:
        simulation.close()


class _Drive:
    """The robot's knowledge, and the loop."""

    def __init__(self, simulation: Simulation, pilot: Pilot) -> None:
        ((self._name, self._model),) = simulation.models.items()
        self._simulation, self._pilot = simulation, pilot
        mounts = self._model.mounts
        assert self._model.config.laser is not None and simulation.world.goals is not None
        self._T_base_laser = _planar(mounts[self._model.config.laser.frame])
        self._sonars = [(f, _planar(mounts[f])) for f in self._model.config.sonar_frames]
        start = simulation.starts[self._name]
        self._goals = start.inverse() @ np.array(simulation.world.goals.points_m)
        self.record = GoalRecord(num_goals=len(self._goals))
        self._mapper = LayeredMapper(pilot.mapper)
        self._keeper = RouteKeeper(pilot.wavefront)
        self._target: PathTarget | None = None
        self._method = make_method(pilot.planner)
        self._velocity = self._command = STILL
        self._odometry = SE2.identity()
        self._T_map_odom: SE2 | None = None
        self._asked_at = SE2.identity()
        self._scan: tuple[Scan, SE2] | None = None
        self._poses: list[tuple[int, SE2]] = []
        self._number, self._since_ns = -1, 0

    def run(self, limit_s: float, on_step: Callable[[float], None]) -> GoalDrive:
        """Drive until the last goal is reached or left, or time is up."""
        sent = base.STOP
        while self._number < len(self._goals) and self._simulation.stamp_ns < limit_s * 1e9:
            now_ns = self._simulation.stamp_ns
            is_due = now_ns % _CYCLE_NS == 0
            if is_due:
                sent = self._cycle(now_ns)
            seen = self._simulation.step({self._name: sent} if is_due else {})
            self._note(seen.stamp_ns, seen.robots[self._name])
            if seen.stamp_ns % 200_000_000 == 0:
                places = [(p.pose.x, p.pose.y) for p in seen.ground_truth_people]
                self.record.people.append((seen.stamp_ns, np.array(places).reshape(-1, 2)))
            if seen.stamp_ns % _MAP_NS == 0:
                on_step(seen.stamp_ns * 1e-9)
        return GoalDrive(self.record, self._map(), self._poses)

    def _note(self, stamp_ns: int, seen: RobotObservation) -> None:
        self.record.note_touch(stamp_ns, seen.ground_truth.is_touching)
        if seen.odometry is not None:
            v = seen.odometry.velocity
            self._velocity = Velocity(v.speed, v.side_speed, v.yaw_rate)
            self._odometry = seen.odometry.pose
            self.record.truth.append((stamp_ns, seen.ground_truth.pose))
        if seen.sonar is not None and self._pilot.has_glass:
            for (frame, T_base_sonar), reading in zip(self._sonars, seen.sonar, strict=True):
                if not np.isnan(reading.range):
                    self._mapper.insert_range(stamp_ns, reading, T_base_sonar, frame)
        if seen.scan is not None:
            self._take_scan(stamp_ns, seen.scan)

    def _take_scan(self, stamp_ns: int, scan: Scan) -> None:
        self._scan = scan, self._odometry
        found = self._mapper.insert_scan(stamp_ns, scan, self._T_base_laser, self._odometry)
        self._T_map_odom = found.T_map_base @ self._odometry.inverse()
        self._poses.append((stamp_ns, found.T_map_base))

    def _cycle(self, now_ns: int) -> base.Velocity:
        """Return what was decided a period ago, to be sent now."""
        now = self._command
        if self._T_map_odom is None or self._scan is None:
            return base.STOP
        T_map_base = self._T_map_odom @ self._odometry
        self._plan(now_ns, T_map_base)
        wanted, is_there = STILL, False
        if self._target is not None:
            wanted, is_there = self._decide(now_ns, self._target.goal(T_map_base))
        self._command = ramped(now, wanted, self._pilot.planner.robot, _CYCLE_NS * 1e-9)
        if is_there and self._velocity.speed < 0.05:
            self.record.reached_ns.append(now_ns)
            self._next(now_ns)
        elif now_ns - self._since_ns > self._pilot.goal_limit_s * 1e9 and self._number >= 0:
            self.record.given_up.append(self._number)
            self._next(now_ns)
        return base.Velocity(now.x, now.yaw_rate, now.y)

    def _decide(self, now_ns: int, goal: Goal) -> tuple[Velocity, bool]:
        assert self._scan is not None
        scan, taken_at = self._scan
        moved = self._asked_at.between(self._odometry)
        self._asked_at = self._odometry
        decision = self._method.decide(
            RobotState(self._velocity, self._command, moved),
            Obstacles(scan, self._odometry.between(taken_at) @ self._T_base_laser),
            goal,
        )
        self.record.note_state(now_ns, decision.state, decision.reason)
        return decision.command, decision.state == REACHED

    def _plan(self, now_ns: int, T_map_base: SE2) -> None:
        if now_ns % _MAP_NS == 0 or self._number < 0:
            self._keeper.set_grid(self._map())
        if self._number < 0:
            self._next(now_ns)
        elif now_ns % _LOOK_NS:
            return
        route = self._keeper.update(np.array([T_map_base.x, T_map_base.y]))
        if route.points is not None:
            points = route.points
            lookahead = self._pilot.planner.lookahead_m
            self._target = PathTarget(points, lookahead) if len(points) else None

    def _map(self) -> OccupancyMap:
        return self._mapper.occupancy() if self._pilot.has_glass else self._mapper.laser_map()

    def _next(self, now_ns: int) -> None:
        self._number, self._since_ns, self._target = self._number + 1, now_ns, None
        if self._number < len(self._goals):
            self._keeper.set_goal(self._goals[self._number])


def _planar(T_base_sensor: np.ndarray) -> SE2:
    return Transform3(T_base_sensor).to_se2()
