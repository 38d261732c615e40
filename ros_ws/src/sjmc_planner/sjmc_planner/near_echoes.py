"""Glass that a sonar hears close by, before any map knows it.

A map takes its time: a pane is one once it was heard from several places. A robot that comes near
listens to its sonars itself. An echo from close by that nothing in the scan explains, once a second
one came from there (what only one reading heard may be another sonar's sound), stands for a piece
of a pane for a while: glass is flat and answers squarely, so it lies across the way of the sound
(`pane_direction` tells how exactly), and it goes on to either side, to the next post that the scan
shows. The laser sees the pane itself only where it looks squarely at it: that is no post. Without
that a robot that comes at a slant would touch with a corner what its sonars meet only beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from sjmc_planner.known_config import KnownConfig
from sjmc_planner.pane_direction import PaneLine, pane_line
from sjmc_planner.planning import Obstacles

Heard = tuple[RangeReading, SE2]
_UNSAID_RAD = math.pi / 9.0  # opening of a cone that no message says
_EDGE_RAD = 0.05  # what the scan shows this far beside a cone explains its echo too
_ABOUT = 0.15  # ... and this near to its range: people move, and bulge at other heights, m
_APART = 0.04  # between points, m
_AGREE = 0.1  # echoes whose cones end this near to each other are of one thing, m
_POST = 0.1  # what the scan shows this near to a pane ends it, m
_WIDTH = 0.06  # ... if it shows more than one place no farther apart than this, m
_TOLD = 2  # other echoes that tell a line
_SHARE_UNTOLD = 0.5  # of its reach that a pane has without them: it may lie awry
_GLINT = math.tan(0.26)  # glass shines to a laser this near to its normal


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
        self._is_heard = np.zeros(0, dtype=bool)  # within the cone, not beside it
        self._is_sure = np.zeros(0, dtype=bool)
        self._num = 0
        self._places, self._ranges = np.zeros((0, 2)), np.zeros(0)  # of sonars, as they heard
        self._place_age = np.zeros(0)

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
        self._pass(moved, dt)
        ends = seen.T_base_sensor @ seen.scan.points()
        for reading, T_base_sonar in heard:
            r = distance_heard(reading)
            if r <= self._config.echo_m:
                line = pane_line(r, T_base_sonar, self._places, self._ranges)
                laser = seen.T_base_sensor
                args = reading.field_of_view, T_base_sonar, ends, self._config.pane_m
                points, is_heard = pane_of(r, *args, line, np.array([laser.x, laser.y]))
                if len(points):
                    self._note(r, T_base_sonar)
                shows = _before(points, seen)
                self._add(points[shows], is_heard[shows])
        return self._points[self._is_sure]

    def _pass(self, moved: SE2, dt: float) -> None:
        """Let time pass and the robot move."""
        self._age, self._place_age = self._age + dt, self._place_age + dt
        self._keep(self._age <= self._config.echo_hold_s)
        self._points = moved.inverse() @ self._points
        lately = self._place_age <= self._config.echo_hold_s
        self._places = moved.inverse() @ self._places[lately]
        self._ranges, self._place_age = self._ranges[lately], self._place_age[lately]

    def _note(self, r: float, T_base_sonar: SE2) -> None:
        place = [[T_base_sonar.x, T_base_sonar.y]]
        self._places = np.concatenate((self._places, place))
        self._ranges, self._place_age = np.append(self._ranges, r), np.append(self._place_age, 0.0)

    def _keep(self, which: np.ndarray) -> None:
        self._points, self._age = self._points[which], self._age[which]
        self._echo, self._is_sure = self._echo[which], self._is_sure[which]
        self._is_heard = self._is_heard[which]

    def _add(self, points: np.ndarray, is_heard: np.ndarray) -> None:
        """Add an echo; it and those that agree with it are sure."""
        old, new = self._points[self._is_heard], points[is_heard]
        if not len(new):
            return
        near = np.hypot(*(old[:, None] - new[None]).transpose(2, 0, 1)) <= _AGREE
        agrees = np.isin(self._echo, self._echo[self._is_heard][near.any(axis=1)])
        self._is_sure |= agrees
        self._num += 1
        num = len(points)
        self._points = np.concatenate((self._points, points))
        self._age = np.concatenate((self._age, np.zeros(num)))
        self._echo = np.concatenate((self._echo, np.full(num, self._num)))
        self._is_heard = np.concatenate((self._is_heard, is_heard))
        self._is_sure = np.concatenate((self._is_sure, np.full(num, bool(agrees.any()))))


def distance_heard(reading: RangeReading) -> float:
    """Return how far off an echo came from, m; inf for none. Too near to measure is `min_range`."""
    if reading.is_hit:
        return reading.range
    return reading.min_range if reading.range == -math.inf else math.inf


def pane_of(
    r: float, opening: float, T_base_sonar: SE2, ends: np.ndarray, reach: float,
    line: PaneLine, laser: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the piece of a pane that an echo stands for, and which of its points are in the cone.

    No points if something that the scan shows stands there in the cone; but on a line that other
    echoes told already, what the scan shows may be the pane itself, which shines where the laser
    looks squarely at it.

    Args:
        r: How far off the echo came from, m.
        opening: Of the cone, rad; as the message says.
        T_base_sonar: The sonar, which looks along its x axis.
        ends: What the scan shows, in the base frame, shape (M, 2), m.
        reach: How far the pane goes on to either side, m; half of it where no others tell its line.
        line: On which it lies.
        laser: Where the scan is from, in the base frame, shape (2,), m.

    Returns:
        Points in the base frame, shape (K, 2), m, and a mask of them, shape (K,).
    """
    half = 0.5 * (opening if 0.0 < opening <= math.pi else _UNSAID_RAD)
    T_base_foot = T_base_sonar @ SE2(0.0, 0.0, line.tilt)
    along, across = (T_base_foot.inverse() @ ends).T
    is_known, is_on = line.num_others >= _TOLD, np.abs(along - r) <= _POST
    x, y = (T_base_sonar.inverse() @ ends).T
    is_there = np.abs(np.hypot(x, y) - r) <= _ABOUT
    is_there &= np.abs(np.arctan2(y, x)) <= half + _EDGE_RAD
    if (is_there & ~(is_known & is_on)).any():
        return np.zeros((0, 2)), np.zeros(0, dtype=bool)
    if is_known:
        ((far, aside),) = T_base_foot.inverse() @ laser[None]
        is_on &= np.abs(across - aside) > _GLINT * abs(r - far)
    else:
        reach *= _SHARE_UNTOLD
    heard = r * math.sin(half)
    posts = _posts(across[is_on])
    low = max(-max(reach, heard), posts[posts < 0.0].max(initial=-math.inf))
    high = min(max(reach, heard), posts[posts > 0.0].min(initial=math.inf))
    y = np.linspace(low, high, max(3, math.ceil((high - low) / _APART) + 1))
    points = T_base_foot @ np.column_stack((np.full(len(y), r), y))
    return points, np.abs(y) <= heard + _APART


def _posts(across: np.ndarray) -> np.ndarray:
    """Return those places on a line that are not seen alone, as specks of dirt on glass are."""
    places = np.sort(across)
    is_next = np.diff(places, prepend=-np.inf, append=np.inf) <= _WIDTH
    return places[is_next[1:] | is_next[:-1]]


def _before(points: np.ndarray, seen: Obstacles) -> np.ndarray:
    """Tell which points do not lie behind what the scan shows, shape (K,), bool."""
    scan = seen.scan
    x, y = (seen.T_base_sensor.inverse() @ points).T
    beams = np.rint((np.arctan2(y, x) - scan.angle_min) / scan.angle_increment).astype(int)
    beams %= round(2.0 * math.pi / abs(scan.angle_increment))
    far = np.full(len(points), np.nan)
    is_looked = beams < len(scan.ranges)
    far[is_looked] = np.asarray(scan.ranges, dtype=float)[beams[is_looked]]
    with np.errstate(invalid="ignore"):
        return np.asarray(~(far < np.hypot(x, y) - _ABOUT))
