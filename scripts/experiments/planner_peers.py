"""Planners of others behind the seam of ours, for comparison: ORCA, and the dynamic window.

ORCA (van den Berg et al. 2009) is the library `pyrvo`; it hears of people from our own tracker and
of what stands from the scan. What it chooses, a differential robot turns to and drives as for our
histogram methods, and no faster than it can stop before what the scan shows (`Steering`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyrvo

from experiments.planner_dwa import DwaPeer
from experiments.planner_peer import Peer
from sjmc_planner.beam_ends import BeamEnds
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import (
    BLOCKED,
    BRAKING,
    DRIVING,
    STILL,
    Decision,
    Goal,
    Method,
    Obstacles,
    RobotState,
)
from sjmc_planner.steering import Steering

_APART = 0.2  # beams that ended farther apart than this met different things, m


@dataclass(frozen=True)
class OrcaSettings:
    """What the library is given; horizons as in its own examples.

    Attributes:
        neighbor_m: How far people count.
        horizon_s: How far ahead people are kept clear of.
        wall_horizon_s: How far ahead what stands is kept clear of.
        wall_m: How far what stands counts.
        piece_m: Longest piece of a wall.
        disk_m: Things that stand alone count as disks up to this radius: a wall ahead stops ORCA
            for good, a disk it goes round.
    """

    neighbor_m: float = 6.0
    horizon_s: float = 3.0
    wall_horizon_s: float = 1.5
    wall_m: float = 3.0
    piece_m: float = 0.4
    disk_m: float = 0.6


class OrcaPeer(Peer):
    """ORCA by `pyrvo`.

    Args:
        config: Robot, rhythm and tolerance.
        settings: Of the library.
    """

    def __init__(self, config: LocalPlannerConfig, settings: OrcaSettings | None = None) -> None:
        super().__init__(config)
        self._settings = OrcaSettings() if settings is None else settings
        self._tracker = PeopleTracker(config.tracking)

    def _drive(
        self, state: RobotState, obstacles: Obstacles, ends: BeamEnds, goal: Goal
    ) -> Decision:
        """Return the command for now: people from the tracker, what stands from the scan."""
        tracks = self._tracker.update(obstacles, state.moved, self._config.control_period_s)
        wanted = self._steering.fastest(goal) * np.array(
            [math.cos(goal.bearing), math.sin(goal.bearing)]
        )
        others = list(zip(tracks.position, tracks.velocity, tracks.radius, strict=True))
        walls: list[np.ndarray] = []
        for points in _clusters(ends, tracks.beam_track < 0, self._settings.wall_m):
            middle, radius = _disk(points)
            if radius < self._settings.disk_m:
                others.append((middle, np.zeros(2), radius))
            else:
                walls += _pieces(points, self._settings.piece_m)
        vx, vy = self._solve(state, wanted, others, walls)
        return _decision(self._steering, math.atan2(vy, vx), math.hypot(vx, vy), state, ends)

    def _solve(
        self, state: RobotState, wanted: np.ndarray,
        others: list[tuple[np.ndarray, np.ndarray, float]], walls: list[np.ndarray],
    ) -> tuple[float, float]:  # fmt: skip
        """Return the velocity that the library takes for the robot."""
        s, robot = self._settings, self._config.robot
        period = self._config.control_period_s
        simulator = pyrvo.RVOSimulator()
        simulator.set_time_step(period)
        own = [s.neighbor_m, 10, s.horizon_s, s.wall_horizon_s]
        moving = [state.velocity.x, state.velocity.y]
        simulator.add_agent([0.0, 0.0], *own, robot.grown_radius, robot.speed_m_s, moving)
        simulator.set_agent_pref_velocity(0, wanted.tolist())
        for place, velocity, radius in others:
            speed = max(float(np.hypot(*velocity)), 0.1)
            simulator.add_agent(place.tolist(), *own, float(radius), speed, velocity.tolist())
        for wall in walls:
            simulator.add_obstacle([tuple(point) for point in wall.tolist()])
        simulator.process_obstacles()
        simulator.do_step()
        velocity = simulator.get_agent_velocity(0)
        return float(velocity.x), float(velocity.y)


def _clusters(ends: BeamEnds, is_standing: np.ndarray, reach: float) -> list[np.ndarray]:
    """Return runs of beams that ended side by side, each its points, shape (K, 2), m."""
    x, y, c, s, _ = ends.pose
    angles = ends.angle_min + ends.angle_increment * np.arange(len(ends.ranges))
    is_used = is_standing & (ends.ranges < reach)
    r, angles, beams = ends.ranges[is_used], angles[is_used], np.flatnonzero(is_used)
    px, py = r * np.cos(angles), r * np.sin(angles)
    points = np.column_stack((x + c * px - s * py, y + s * px + c * py))
    if not len(points):
        return []
    is_new = (np.diff(beams) > 3) | (np.hypot(*np.diff(points, axis=0).T) > _APART)
    return np.split(points, np.flatnonzero(is_new) + 1)


def _disk(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Return a disk for a thing that stands alone: as wide as it looks."""
    middle = 0.5 * (points[0] + points[-1])
    return middle, max(float(np.hypot(*(points - middle).T).max()), 0.05)


def _pieces(points: np.ndarray, length: float) -> list[np.ndarray]:
    """Return a wall in pieces of two points, each no longer than `length`."""
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    num = max(1, math.ceil(along[-1] / length))
    at = np.searchsorted(along, np.linspace(0.0, along[-1], num + 1)).clip(0, len(points) - 1)
    corners = points[np.unique(at)]
    return [np.stack(pair) for pair in zip(corners[:-1], corners[1:], strict=True)]


def _decision(
    steering: Steering, bearing: float, speed: float, state: RobotState, ends: BeamEnds
) -> Decision:
    command = steering.toward(bearing, speed, state, ends)
    if command is None:
        return Decision(STILL, BRAKING, "no room to stop within what is seen")
    if command.is_still:
        return Decision(STILL, BLOCKED, "no velocity is free")
    return Decision(command, DRIVING)


PEERS: dict[str, Callable[[LocalPlannerConfig], Method]] = {"orca": OrcaPeer, "dwa": DwaPeer}
