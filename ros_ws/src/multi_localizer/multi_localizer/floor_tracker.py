"""Which of the poses that a floor fits is the robot's: by goals, time and odometry (step 7).

A floor that looks the same turned by 180 degrees fits in two poses (eq. 23). Each is kept as a
hypothesis with its share of the belief. Motion carries hypotheses from mask to mask, so what was
settled once stays settled; goals seen at their bearings settle it first, and turn it over if it was
wrong. What no goal and no motion tells is said to be open, and no pose is given.

A mask whose poses do not follow from the motion is doubted; if that goes on the robot was carried
away, and all poses that fit are hypotheses again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.floor_motion import motion_between
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.goal_evidence import GoalsSeen, goal_likelihood
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis, propagate

_S = 1_000_000_000
_MAX_WAITING = 50


class TrackState(Enum):
    """How much is known of the pose."""

    LOST = "lost"
    OPEN = "open"
    KNOWN = "known"


@dataclass(frozen=True)
class Hypothesis:
    """A pose that may be the robot's, and its share of the belief."""

    estimate: PoseEstimate
    share: float


class FloorTracker:
    """Keeps the poses that may be the robot's.

    Args:
        goals: Places of goals by class, m.
        config: Shares, deviations and times.

    Attributes:
        config: May be replaced while it runs.
        reason: Why there is no pose; "" if there is.
        num_carried: How often the robot was taken to have been carried away.
    """

    def __init__(self, goals: Mapping[str, tuple[float, float]], config: FloorTrackConfig) -> None:
        self.config = config
        self.num_carried = 0
        self._goals = goals
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.reason = "no mask of the floor yet"
        self._hypotheses: list[Hypothesis] = []
        self._fresh = False
        self._stamp_ns: int | None = None
        self._T_odom_base: SE2 | None = None
        self._followed_ns = 0
        self._strange_since_ns: int | None = None
        self._waiting: list[GoalsSeen] = []
        self._counted: dict[str, int] = {}

    @property
    def state(self) -> TrackState:
        """How much is known."""
        if not self._hypotheses or not self._fresh:
            return TrackState.LOST
        is_known = self._hypotheses[0].share >= self.config.settle_share
        return TrackState.KNOWN if is_known else TrackState.OPEN

    @property
    def estimate(self) -> PoseEstimate | None:
        """The robot's pose; None if it is not known."""
        return self._hypotheses[0].estimate if self.state is TrackState.KNOWN else None

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All poses that may be the robot's, the likeliest first."""
        return tuple(self._hypotheses)

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the newest mask; None before the first."""
        return self._stamp_ns

    def guess(self, stamp_ns: int, T_odom_base: SE2 | None) -> PoseEstimate | None:
        """Return where the likeliest hypothesis is at a moment, for the fit to begin there."""
        moved = self._moved(stamp_ns, T_odom_base)
        return moved[0].estimate if moved else None

    def update(
        self,
        stamp_ns: int,
        candidates: Sequence[PoseEstimate],
        problem: str,
        T_odom_base: SE2 | None,
    ) -> None:
        """Take what a mask fits.

        Args:
            stamp_ns: Its stamp.
            candidates: Poses of base_link that fit it, at least one unless there is a problem.
            problem: Why there are none; "" if there are.
            T_odom_base: Where odometry has the robot at the stamp; None without odometry.
        """
        self._hypotheses = self._moved(stamp_ns, T_odom_base)
        if T_odom_base is None and self._silent_s(stamp_ns) > self.config.lost_after_s:
            self.num_carried += self._strange_since_ns is not None
            self._hypotheses, self._strange_since_ns = [], None  # by now it may be anywhere
        self._stamp_ns, self._T_odom_base = stamp_ns, T_odom_base
        if not candidates:
            self._fresh, self.reason = False, problem
            return
        followed = self._followed(candidates)
        if followed:
            self._strange_since_ns = None
        else:
            followed = self._begun_anew(stamp_ns, candidates)
        if followed:
            self._hypotheses, self._fresh, self._followed_ns = followed, True, stamp_ns
            self._take_waiting()
        self._say()

    def see_goals(self, seen: GoalsSeen) -> None:
        """Take the bearings of one class of goal: now, or with the mask of their moment."""
        if seen.kind not in self._goals or self._counted.get(seen.kind, -1) == seen.stamp_ns:
            return
        if self._is_of_now(seen):
            self._weigh(seen)
            self._say()
        elif self._stamp_ns is None or seen.stamp_ns > self._stamp_ns:
            self._waiting = [*self._waiting, seen][-_MAX_WAITING:]

    def relocate(self, estimate: PoseEstimate) -> None:
        """Believe somebody who says where the robot is: the nearest of what fits."""
        if not self._hypotheses:
            return
        off = np.array([mahalanobis(h.estimate, estimate) for h in self._hypotheses])
        shares = np.exp(-0.5 * (off - off.min()))
        self._set_shares(shares / shares.sum())
        self._say()

    def _silent_s(self, stamp_ns: int) -> float:
        """Return how long no mask has shown where the robot is."""
        return abs(stamp_ns - self._followed_ns) / _S

    def _moved(self, stamp_ns: int, T_odom_base: SE2 | None) -> list[Hypothesis]:
        if self._stamp_ns is None or not self._hypotheses:
            return list(self._hypotheses)
        dt = abs(stamp_ns - self._stamp_ns) / _S
        motion, cov = motion_between(self._T_odom_base, T_odom_base, dt, self.config)
        return [Hypothesis(propagate(h.estimate, motion, cov), h.share) for h in self._hypotheses]

    def _followed(self, candidates: Sequence[PoseEstimate]) -> list[Hypothesis]:
        """Return the candidates that follow from the hypotheses; none if the best has none."""
        gate = self.config.gate_sd**2
        shares = np.zeros(len(candidates))
        for rank, old in enumerate(self._hypotheses):
            off = np.array([mahalanobis(old.estimate, new) for new in candidates])
            fit = np.where(off < gate, np.exp(-0.5 * off), 0.0)
            if fit.sum() > 0.0:
                shares += old.share * fit / fit.sum()
            elif rank == 0:
                return []
        if shares.sum() <= 0.0:
            return []
        return self._ranked(candidates, shares / shares.sum())

    def _begun_anew(self, stamp_ns: int, candidates: Sequence[PoseEstimate]) -> list[Hypothesis]:
        """Return all candidates, alike, if there is nothing to follow from, or not any more."""
        if self._strange_since_ns is None:
            self._strange_since_ns = stamp_ns
        strange_s = abs(stamp_ns - self._strange_since_ns) / _S
        if self._hypotheses and strange_s < self.config.lost_after_s:
            self._fresh = False
            return []
        self.num_carried += bool(self._hypotheses)
        self._strange_since_ns = None
        return self._ranked(candidates, np.full(len(candidates), 1.0 / len(candidates)))

    def _ranked(self, estimates: Sequence[PoseEstimate], shares: np.ndarray) -> list[Hypothesis]:
        least = min(self.config.least_share, 0.5 / len(estimates))
        kept = np.maximum(shares, least)
        kept = kept / kept.sum()
        found = [Hypothesis(e, float(s)) for e, s in zip(estimates, kept, strict=True)]
        return sorted(found, key=lambda h: -h.share)

    def _set_shares(self, shares: np.ndarray) -> None:
        self._hypotheses = self._ranked([h.estimate for h in self._hypotheses], shares)

    def _is_of_now(self, seen: GoalsSeen) -> bool:
        if self._stamp_ns is None or not self._fresh:
            return False
        return abs(seen.stamp_ns - self._stamp_ns) <= self.config.max_skew_s * _S

    def _take_waiting(self) -> None:
        for seen in self._waiting:
            if self._is_of_now(seen):
                self._weigh(seen)
        now_ns = self._stamp_ns or 0
        self._waiting = [seen for seen in self._waiting if seen.stamp_ns > now_ns]

    def _weigh(self, seen: GoalsSeen) -> None:
        """Let a goal seen speak for the hypotheses in which it is where the plan has it."""
        self._counted[seen.kind] = seen.stamp_ns
        bearings = seen.bearings[np.isfinite(seen.bearings)]
        if not len(bearings) or not self._hypotheses:
            return
        c, goal = self.config, self._goals[seen.kind]
        weights = [
            goal_likelihood(h.estimate.pose @ seen.T_base_sensor, float(bearings[0]), goal, c)
            for h in self._hypotheses
        ]
        shares = np.array([h.share for h in self._hypotheses]) * np.array(weights)
        self._set_shares(shares / shares.sum())

    def _say(self) -> None:
        if self.state is TrackState.LOST:
            self.reason = "the pose does not follow from the motion"
        elif self.state is TrackState.OPEN:
            self.reason = f"{len(self._hypotheses)} poses fit alike: {self._what_tells()}"
        else:
            self.reason = ""

    def _what_tells(self) -> str:
        if not self._goals:
            return "the plan names no goal that tells, and nobody sent initialpose"
        names = " or ".join(self._goals)
        return f"no goal ({names}) has told them apart yet"
