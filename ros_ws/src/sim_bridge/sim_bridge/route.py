"""Following a polyline with a differential drive: pure pursuit (Coulter 1992), turns on the spot.

Stands in for a planner in the demo: it knows the way and looks at no sensor.
"""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from sim_bridge.config import RouteConfig
from sim_bridge.drive import STOP, Velocity

_SAMPLE = 0.02
_WINDOW = 0.6
_ARRIVED = 0.1
_SLOW_DOWN = 0.8
_TURNS_BACK = 2.3
_BRAKING_FACTOR = 2.5
_SLOWEST = 0.35


class RouteFollower:
    """Where on the route the robot is, and what to command next.

    Args:
        config: The route and how to drive it.
    """

    def __init__(self, config: RouteConfig) -> None:
        """Start at the first waypoint."""
        self._config = config
        self._legs = [_resampled(leg) for leg in _legs(np.reshape(config.route_m, (-1, 2)))]
        self._index = 0

    def step(self, pose: SE2) -> Velocity | None:
        """Return the command at a pose in the route's frame; None at the end."""
        here = np.array([pose.x, pose.y])
        while self._legs and self._is_at_end(here):
            self._legs, self._index = self._legs[1:], 0
        if not self._legs:
            return None
        points = self._legs[0]
        near, far = (
            pose.inverse() @ points[None, min(self._index + round(d / _SAMPLE), len(points) - 1)]
            for d in (self._config.lookahead_m, _BRAKING_FACTOR * self._config.lookahead_m)
        )
        return self._steer(near[0], far[0], float(np.hypot(*(points[-1] - here))))

    def _is_at_end(self, here: np.ndarray) -> bool:
        # Only a window ahead is searched, so that a crossing is not taken for a short cut.
        points = self._legs[0]
        window = points[self._index : self._index + round(_WINDOW / _SAMPLE)]
        self._index += int(np.argmin(np.hypot(*(window - here).T)))
        left = (len(points) - 1 - self._index) * _SAMPLE
        return left < _WINDOW and float(np.hypot(*(points[-1] - here))) < _ARRIVED

    def _steer(self, near: np.ndarray, far: np.ndarray, left: float) -> Velocity:
        """Return the command for two points of the route in the base frame, (2,) each.

        Args:
            near: The point it steers for.
            far: A point farther on; the more it lies aside, the slower it drives.
            left: Distance to the end of the leg.
        """
        config, limit = self._config, self._config.max_yaw_rate_rad_s
        distance, error = float(np.hypot(*near)), math.atan2(near[1], near[0])
        if distance < 1e-3:
            return STOP
        if abs(error) > config.turn_on_spot_rad:
            return Velocity(0.0, math.copysign(min(limit, 2.0 * abs(error)), error))
        bend = max(math.cos(math.atan2(far[1], far[0])), _SLOWEST)
        speed = config.speed_m_s * bend * min(1.0, 0.1 + left / _SLOW_DOWN)
        curvature = 2.0 * math.sin(error) / distance
        if abs(curvature) * speed > limit:
            speed = limit / abs(curvature)
        return Velocity(speed, speed * curvature)


def _legs(waypoints: np.ndarray) -> list[np.ndarray]:
    """Split a route where it turns back on itself, so that no corner is cut there."""
    directions = np.arctan2(*np.diff(waypoints, axis=0).T[::-1])
    turns = np.abs([wrap_angle(float(turn)) for turn in np.diff(directions)])
    cuts = [0, *(np.flatnonzero(turns > _TURNS_BACK) + 1).tolist(), len(waypoints) - 1]
    return [waypoints[a : b + 1] for a, b in zip(cuts[:-1], cuts[1:], strict=True)]


def _resampled(waypoints: np.ndarray) -> np.ndarray:
    """Return points every `_SAMPLE` along the line through the waypoints, (N, 2)."""
    lengths = np.hypot(*np.diff(waypoints, axis=0).T)
    along = np.concatenate(([0.0], np.cumsum(lengths)))
    at = np.append(np.arange(0.0, along[-1], _SAMPLE), along[-1])
    return np.column_stack([np.interp(at, along, waypoints[:, k]) for k in (0, 1)])
