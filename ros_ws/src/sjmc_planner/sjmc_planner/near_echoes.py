"""Glass that a sonar hears close by, before any map knows it.

A map takes its time: a pane is one once it was heard from several places. A robot that comes near
listens to its sonars itself. An echo from close by that nothing in the scan explains stands for an
obstacle over the whole width of its cone, for a while, once a second echo came from there: what
only one reading heard may be another sonar's sound.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from sjmc_planner.known_config import KnownConfig
from sjmc_planner.planning import Obstacles

Heard = tuple[RangeReading, SE2]
_UNSAID_RAD = math.pi / 9.0  # opening of a cone that no message says
_EDGE_RAD = 0.05  # what the scan shows this far beside a cone explains its echo too
_ABOUT = 0.1  # ... and this near to its range, m
_APART = 0.04  # between points of an arc, m
_AGREE = 0.1  # echoes whose arcs come this near to each other are of one thing, m


class NearEchoes:
    """What was heard lately, moved along with the robot.

    Args:
        config: How near, and how long.
    """

    def __init__(self, config: KnownConfig) -> None:
        self._config = config
        self._points = np.zeros((0, 2))
        self._age = np.zeros(0)
        self._echo = np.zeros(0, dtype=np.int64)  # which one each point is of
        self._is_sure = np.zeros(0, dtype=bool)
        self._num = 0

    def update(
        self, heard: Sequence[Heard], seen: Obstacles, moved: SE2, dt: float
    ) -> np.ndarray:  # fmt: skip
        """Return what stands close by, in the base frame, shape (K, 2), m.

        Args:
            heard: New readings, each with its sonar's pose on the robot.
            seen: The newest scan.
            moved: The robot's motion since the last call.
            dt: Time since then, s.
        """
        self._age = self._age + dt
        self._keep(self._age <= self._config.echo_hold_s)
        self._points = moved.inverse() @ self._points
        ends = seen.T_base_sensor @ seen.scan.points()
        for reading, T_base_sonar in heard:
            if reading.is_hit and reading.range <= self._config.echo_m:
                arc = unexplained_arc(reading, T_base_sonar, ends)
                self._add(_before(arc, seen))
        return self._points[self._is_sure]

    def _keep(self, which: np.ndarray) -> None:
        self._points, self._age = self._points[which], self._age[which]
        self._echo, self._is_sure = self._echo[which], self._is_sure[which]

    def _add(self, arc: np.ndarray) -> None:
        """Add an echo; it and those that agree with it are sure."""
        if not len(arc):
            return
        near = np.hypot(*(self._points[:, None] - arc[None]).transpose(2, 0, 1)) <= _AGREE
        agrees = np.isin(self._echo, self._echo[near.any(axis=1)])
        self._is_sure |= agrees
        self._num += 1
        num = len(arc)
        self._points = np.concatenate((self._points, arc))
        self._age = np.concatenate((self._age, np.zeros(num)))
        self._echo = np.concatenate((self._echo, np.full(num, self._num)))
        self._is_sure = np.concatenate((self._is_sure, np.full(num, bool(agrees.any()))))


def unexplained_arc(reading: RangeReading, T_base_sonar: SE2, ends: np.ndarray) -> np.ndarray:
    """Return points over the width of a cone at its echo's range, shape (K, 2), m.

    None if something that the scan shows stands there in the cone.

    Args:
        reading: With an echo.
        T_base_sonar: The sonar, which looks along its x axis.
        ends: What the scan shows, in the base frame, shape (M, 2), m.
    """
    said = reading.field_of_view
    half = 0.5 * (said if 0.0 < said <= math.pi else _UNSAID_RAD)
    x, y = (T_base_sonar.inverse() @ ends).T
    is_there = np.abs(np.hypot(x, y) - reading.range) <= _ABOUT
    if (is_there & (np.abs(np.arctan2(y, x)) <= half + _EDGE_RAD)).any():
        return np.zeros((0, 2))
    num = max(3, math.ceil(2.0 * half * reading.range / _APART) + 1)
    angles = np.linspace(-half, half, num)
    return T_base_sonar @ (reading.range * np.column_stack((np.cos(angles), np.sin(angles))))


def _before(points: np.ndarray, seen: Obstacles) -> np.ndarray:
    """Return those points that do not lie behind what the scan shows."""
    scan = seen.scan
    x, y = (seen.T_base_sensor.inverse() @ points).T
    beams = np.rint((np.arctan2(y, x) - scan.angle_min) / scan.angle_increment).astype(int)
    beams %= round(2.0 * math.pi / abs(scan.angle_increment))
    far = np.full(len(points), np.nan)
    is_looked = beams < len(scan.ranges)
    far[is_looked] = np.asarray(scan.ranges, dtype=float)[beams[is_looked]]
    with np.errstate(invalid="ignore"):
        return points[~(far < np.hypot(x, y) - _ABOUT)]
