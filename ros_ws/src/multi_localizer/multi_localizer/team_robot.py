"""What the team's filter keeps of one robot beside its part of the joint Gaussian."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_start import Clue, Driven

_NS = 1_000_000_000
_START_EVERY_NS = _NS // 2
_SOONEST_S = 0.05


@dataclass(eq=False)
class RobotRecord:
    """The way of a robot, what it saw last and how well that fitted.

    Attributes:
        index: Its number in the joint Gaussian.
        driven: Its odometry so far.
        clues: What its place can be told from, oldest first.
        outcomes: Of the last bearings, whether each was used.
        seen_ns: When each thing was seen last.
        stamp_ns: Of the last motion; None before the first.
        is_located: Whether its pose is known.
    """

    index: int
    driven: Driven = field(default_factory=lambda: Driven(SE2.identity()))
    clues: deque[Clue] = field(default_factory=deque)
    outcomes: deque[bool] = field(default_factory=deque)
    seen_ns: dict[str, int] = field(default_factory=dict)
    stamp_ns: int | None = None
    is_located: bool = False
    _tried_ns: int | None = None

    def move(self, motion: SE2, stamp_ns: int) -> float:
        """Take a motion of the odometry; return the time since the last, s."""
        last_ns = stamp_ns if self.stamp_ns is None else self.stamp_ns
        if stamp_ns < last_ns:
            raise ValueError(f"stamp_ns must not go back, got {stamp_ns} after {last_ns}")
        self.stamp_ns = stamp_ns
        self.driven = self.driven.moved(motion)
        return (stamp_ns - last_ns) / _NS

    def start_anew(self) -> None:
        """Forget the way and all that was seen on it; the next motion may have any stamp."""
        self.driven = Driven(SE2.identity())
        self.clues.clear()
        self.outcomes.clear()
        self.seen_ns.clear()
        self.stamp_ns = self._tried_ns = None
        self.is_located = False

    def find(self) -> None:
        """Take the robot for located."""
        self.is_located = True
        self.outcomes.clear()

    def lose(self, config: TeamFilterConfig) -> None:
        """Take the robot for lost: it starts anew from what it saw last."""
        self.is_located = False
        while len(self.clues) > config.lost_looks:
            self.clues.popleft()

    def times_wider(self, meaning: str, stamp_ns: int, config: TeamFilterConfig) -> float:
        """Return what to multiply a variance with: the sooner a look repeats the last, the more."""
        if meaning not in self.seen_ns:
            return 1.0
        gap = max((stamp_ns - self.seen_ns[meaning]) / _NS, _SOONEST_S)
        return 1.0 + config.repeat_s / gap

    def bearing_var(self, meaning: str, stamp_ns: int, config: TeamFilterConfig) -> float:
        """Return the variance of a bearing, rad^2: the sooner it repeats the last, the wider."""
        return config.bearing_sd_rad**2 * self.times_wider(meaning, stamp_ns, config)

    def add_clue(
        self,
        stamp_ns: int,
        angle: float,
        var: float,
        points: np.ndarray,
        point_var: float = 0.0,
        is_seen: bool = False,
    ) -> None:
        """Keep a clue (see `Clue`) at the robot's present place."""
        d = self.driven
        clue = Clue(
            stamp_ns, d.T_odom_base, d.way, d.turned, angle, var, points, point_var, is_seen
        )
        self.clues.append(clue)

    def trim(self, stamp_ns: int, config: TeamFilterConfig) -> None:
        """Drop what is too old to count."""
        while self.clues and stamp_ns - self.clues[0].stamp_ns > config.start_window_s * _NS:
            self.clues.popleft()
        while len(self.outcomes) > config.lost_looks:
            self.outcomes.popleft()

    def is_lost(self, config: TeamFilterConfig) -> bool:
        """Return whether too many of the last bearings did not fit."""
        num_refused = len(self.outcomes) - sum(self.outcomes)
        return self.is_located and num_refused > config.lost_share * config.lost_looks

    def is_start_due(self, stamp_ns: int) -> bool:
        """Return whether to look for a start now, and note it: not at each picture."""
        if self.is_located:
            return False
        if self._tried_ns is not None and stamp_ns - self._tried_ns < _START_EVERY_NS:
            return False
        self._tried_ns = stamp_ns
        return True
