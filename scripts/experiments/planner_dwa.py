"""The dynamic window approach (Fox, Burgard, Thrun 1997) in numpy, from the paper.

Made for comparison over the points of a scan: no library of it installs everywhere. Velocities that
can be reached soon are scored by heading, clearance and speed; those from which the robot could
not stop before it touches something are not admissible. A holonomic robot samples its velocity
vector, a differential one speed and yaw rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from experiments.planner_peer import Peer
from sjmc_planner.beam_ends import BeamEnds
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.free_way import can_stop
from sjmc_planner.limited_motion import ramped
from sjmc_planner.planning import (
    BLOCKED,
    BRAKING,
    DRIVING,
    STILL,
    Decision,
    Goal,
    Obstacles,
    RobotState,
    Velocity,
)


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


class DwaPeer(Peer):
    """The dynamic window over the points of a scan.

    Args:
        config: Robot, rhythm and tolerance.
        settings: Of the method.
    """

    def __init__(self, config: LocalPlannerConfig, settings: DwaSettings | None = None) -> None:
        super().__init__(config)
        self._settings = DwaSettings() if settings is None else settings

    def _drive(
        self, state: RobotState, obstacles: Obstacles, ends: BeamEnds, goal: Goal
    ) -> Decision:
        """Return the command for now: window, admissible velocities, objective."""
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
