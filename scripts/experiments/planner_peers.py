"""Planners of others behind the seam of ours, for comparison: ORCA and the dynamic window.

ORCA (van den Berg et al. 2011) is the library `pyrvo`; it hears of people from our own tracker and
of what stands from the scan, as short walls. The dynamic window (Fox, Burgard, Thrun 1997) is made
here from the paper, in numpy, over the points of the scan: no library of it installs everywhere.

Both choose; a differential robot then turns and drives as for our histogram methods, and all
are kept from driving where they could no longer stop before what the scan shows (`Steering`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyrvo

from sjmc_planner.beam_ends import BeamEnds, BeamReader
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.free_way import can_stop
from sjmc_planner.limited_motion import ramped
from sjmc_planner.people_tracker import PeopleTracker
from sjmc_planner.planning import (
    BLOCKED,
    BRAKING,
    DRIVING,
    REACHED,
    STILL,
    Decision,
    Goal,
    Method,
    Obstacles,
    RobotState,
    Velocity,
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


class OrcaPeer:
    """ORCA by `pyrvo`.

    Args:
        config: Robot, rhythm and tolerance.
        settings: Of the library.
    """

    def __init__(self, config: LocalPlannerConfig, settings: OrcaSettings | None = None) -> None:
        self._config = config
        self._settings = OrcaSettings() if settings is None else settings
        self._tracker = PeopleTracker(config.tracking)
        self._reader = BeamReader(config.unseen_gap_rad)
        self._steering = Steering(config.robot, config.control_period_s)

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now."""
        tracks = self._tracker.update(obstacles, state.moved, self._config.control_period_s)
        if goal.distance <= self._config.goal_tolerance_m:
            return Decision(STILL, REACHED)
        ends = self._reader.read(obstacles)
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


@dataclass(frozen=True)
class DwaSettings:
    """Settings of the dynamic window; with the paper's weights it stays before a box for good.

    Attributes:
        num_speeds: Samples of the speed.
        num_turns: Samples of the yaw rate (differential) or the direction (holonomic).
        window_s: Velocities that can be reached within this are sampled.
        heading, clearance, velocity: Weights alpha, beta, gamma; 0.8, 0.1, 0.1 in the paper.
        look_s: How long a way is driven before its heading is judged.
        reach_m: Clearance beyond this is as good as none in the way.
    """

    num_speeds: int = 11
    num_turns: int = 21
    window_s: float = 0.25
    heading: float = 0.3
    clearance: float = 0.3
    velocity: float = 0.1
    look_s: float = 1.0
    reach_m: float = 3.0


class DwaPeer:
    """The dynamic window over the points of a scan.

    Args:
        config: Robot, rhythm and tolerance.
        settings: Of the method.
    """

    def __init__(self, config: LocalPlannerConfig, settings: DwaSettings | None = None) -> None:
        self._config = config
        self._settings = DwaSettings() if settings is None else settings
        self._reader = BeamReader(config.unseen_gap_rad)
        self._steering = Steering(config.robot, config.control_period_s)

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now: window, admissible velocities, objective."""
        if goal.distance <= self._config.goal_tolerance_m:
            return Decision(STILL, REACHED)
        ends = self._reader.read(obstacles)
        near = _thinned(ends, self._settings.reach_m)
        vx, vy, w = self._window(state, self._steering.fastest(goal))
        clear = _clearance(vx, vy, w, near, self._config.robot.grown_radius)
        clear = np.minimum(clear, self._settings.reach_m)
        best = self._best(vx, vy, w, clear, goal)
        robot, delay = self._config.robot, self._delay
        if best < 0:
            return Decision(STILL, BRAKING, "no velocity of the window is admissible")
        command = Velocity(float(vx[best]), float(vy[best]), float(w[best]))
        after = ramped(state.velocity, command, robot, self._config.control_period_s)
        horizon = ends.horizon - math.hypot(*ends.pose[:2])
        if not can_stop(after, robot, delay, ends.points, horizon):
            return Decision(STILL, BRAKING, "no room to stop within what is seen")
        if command.is_still:
            return Decision(STILL, BLOCKED, "no velocity is better than none")
        return Decision(command, DRIVING)

    @property
    def _delay(self) -> float:
        return self._config.robot.idle_time_s + self._config.control_period_s

    def _window(
        self, state: RobotState, fastest: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the velocities of the window: vx, vy, w."""
        s, robot, dt = self._settings, self._config.robot, self._settings.window_s
        now, most = state.velocity, robot.accel_m_s2 * dt
        if robot.drive == "differential":
            low, high = max(0.0, now.x - most), min(fastest, now.x + most)
            v = np.linspace(low, max(high, low), s.num_speeds)
            turn = robot.yaw_accel_rad_s2 * dt
            w = np.clip(
                np.linspace(now.yaw_rate - turn, now.yaw_rate + turn, s.num_turns),
                -robot.yaw_rate_rad_s, robot.yaw_rate_rad_s,
            )  # fmt: skip
            w = np.append(w, 0.0)
            v, w = (a.ravel() for a in np.meshgrid(v, w))
            return v, np.zeros_like(v), w
        r, a = np.meshgrid(
            np.linspace(0.0, most, s.num_speeds // 2 + 1),
            2.0 * np.pi * np.arange(2 * s.num_turns) / (2 * s.num_turns),
        )
        vx, vy = (now.x + r * np.cos(a)).ravel(), (now.y + r * np.sin(a)).ravel()
        share = np.minimum(1.0, fastest / np.maximum(np.hypot(vx, vy), 1e-9))
        return vx * share, vy * share, np.zeros(vx.size)

    def _best(
        self, vx: np.ndarray, vy: np.ndarray, w: np.ndarray, clear: np.ndarray, goal: Goal
    ) -> int:
        """Return the admissible velocity with the best objective; -1 if there is none."""
        s, robot = self._settings, self._config.robot
        speed = np.hypot(vx, vy)
        needed = speed * self._delay + speed**2 / (2.0 * robot.accel_m_s2)
        is_admissible = needed <= clear
        if not is_admissible.any():
            return -1
        t = s.look_s
        bearing = np.where(robot.drive == "differential", w * t, np.arctan2(vy, vx))
        half = np.sinc(0.5 * w * t / np.pi) * t
        c, sn = np.cos(0.5 * w * t), np.sin(0.5 * w * t)
        x, y = half * (c * vx - sn * vy), half * (sn * vx + c * vy)
        to_goal = np.arctan2(goal.point[1] - y, goal.point[0] - x)
        off = np.abs(np.remainder(to_goal - bearing + np.pi, 2.0 * np.pi) - np.pi)
        score = s.heading * (1.0 - off / np.pi) + s.clearance * clear / s.reach_m
        score += s.velocity * speed / robot.speed_m_s
        return int(np.argmax(np.where(is_admissible, score, -np.inf)))


def _thinned(ends: BeamEnds, reach: float, num: int = 180) -> np.ndarray:
    """Return the nearest point of each of `num` directions, shape (M, 2), m."""
    distance = np.hypot(*ends.points.T)
    points, distance = ends.points[distance < reach], distance[distance < reach]
    order = np.argsort(-distance, kind="stable")
    entry = np.floor(np.arctan2(points[:, 1], points[:, 0]) * (num / (2.0 * np.pi))).astype(int)
    nearest = np.full(num, -1)
    nearest[entry[order] % num] = order
    return points[nearest[nearest >= 0]]


def _clearance(
    vx: np.ndarray, vy: np.ndarray, w: np.ndarray, points: np.ndarray, radius: float
) -> np.ndarray:
    """Return how far each velocity's arc goes until the robot touches a point, shape (V,), m."""
    speed = np.hypot(vx, vy)
    safe = np.maximum(speed, 1e-9)
    c, s = (vx / safe)[:, None], (vy / safe)[:, None]
    along = c * points[:, 0] + s * points[:, 1]
    aside = c * points[:, 1] - s * points[:, 0]
    curvature = np.where(np.abs(w / safe) < 1e-4, 1e-4, w / safe)[:, None]
    turn = 1.0 / np.abs(curvature)
    aside = aside * np.sign(curvature) - turn
    rho = np.maximum(np.hypot(along, aside), 1e-9)
    cosine = (turn**2 + rho**2 - radius**2) / (2.0 * turn * rho)
    half = np.arccos(np.clip(cosine, -1.0, 1.0))
    hit = turn * np.remainder(np.arctan2(along, -aside) - half, 2.0 * np.pi)
    is_inside = np.hypot(*points.T) <= radius
    hit = np.where(is_inside, np.where(along > 0.0, 0.0, np.inf), hit)
    hit = np.where((np.abs(cosine) < 1.0) | is_inside, hit, np.inf)
    return hit.min(axis=1, initial=np.inf)


PEERS: dict[str, Callable[[LocalPlannerConfig], Method]] = {"orca": OrcaPeer, "dwa": DwaPeer}
