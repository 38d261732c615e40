"""Which of the poses that a floor fits is the robot's: by goals, time and odometry (step 7).

A floor that looks the same turned by 180 degrees fits in two poses (eq. 23). Each is kept as a
hypothesis with its share of the belief. Motion carries hypotheses from mask to mask, so what was
settled once stays settled; goals seen at their bearings settle it first, and turn it over if it was
wrong. What no goal and no motion tells is said to be open, and no pose is given.

A mask whose poses do not follow from the motion is doubted; if that goes on the robot was carried
away, and all poses that fit are hypotheses again. While nothing is seen it may be turned by hand:
the belief evens out with time, and what was settled opens again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer import floor_belief as belief
from multi_localizer.floor_belief import Hypothesis
from multi_localizer.floor_motion import motion_between
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.goal_evidence import GoalsSeen, goal_likelihood
from multi_localizer.goals_waiting import GoalsWaiting
from multi_localizer.pose_estimate import PoseEstimate, propagate
from multi_localizer.told_pose import ToldPose

_S = 1_000_000_000


class TrackState(Enum):
    """How much is known of the pose."""

    LOST = "lost"
    OPEN = "open"
    KNOWN = "known"


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
        self._waiting = GoalsWaiting()
        self._told = ToldPose()

    @property
    def state(self) -> TrackState:
        """How much is known."""
        if not self._hypotheses or not self._fresh:
            return TrackState.LOST
        is_alone = self._hypotheses[0].share >= self.config.settle_share
        return TrackState.KNOWN if is_alone and self.has_agreed else TrackState.OPEN

    @property
    def estimate(self) -> PoseEstimate | None:
        """The robot's pose; None if it is not known."""
        return self._hypotheses[0].estimate if self.state is TrackState.KNOWN else None

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All poses that may be the robot's, the likeliest first."""
        return tuple(self._hypotheses)

    @property
    def has_agreed(self) -> bool:
        """Whether enough masks have shown the likeliest pose."""
        return bool(self._hypotheses) and self._hypotheses[0].num_masks >= self.config.settle_masks

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the newest mask; None before the first."""
        return self._stamp_ns

    def guess(self, stamp_ns: int, T_odom_base: SE2 | None) -> PoseEstimate | None:
        """Return where the likeliest hypothesis is at a moment, for the fit to begin there."""
        if not self._hypotheses:
            return None
        return self._moved(self._hypotheses[0].estimate, stamp_ns, T_odom_base)

    def update(
        self, stamp_ns: int, candidates: Sequence[PoseEstimate], problem: str,
        T_odom_base: SE2 | None, costs: Sequence[float] = (), first_cost: float = 0.0,
    ) -> None:  # fmt: skip
        """Take what a mask fits.

        Args:
            stamp_ns: Its stamp.
            candidates: Poses of base_link that fit it, at least one unless there is a problem.
            problem: Why there are none; "" if there are.
            T_odom_base: Where odometry has the robot at the stamp; None without odometry.
            costs: Of each candidate, the share of the border that does not fit; none: not known.
            first_cost: That of the best before what lies behind walls was left out.
        """
        newness = self._go_on(stamp_ns, T_odom_base)
        if T_odom_base is None and self._silent_s(stamp_ns) > self.config.lost_after_s:
            self.num_carried += self._strange_since_ns is not None
            self._hypotheses, self._strange_since_ns = [], None  # by now it may be anywhere
        self._stamp_ns, self._T_odom_base = stamp_ns, T_odom_base
        if not candidates:
            self._fresh, self.reason = False, problem
            return
        c = self.config
        likelihoods = belief.fit_likelihoods(costs, len(candidates), newness, c)
        are_sound = belief.sound_ones(costs, len(candidates), first_cost)
        new = belief.followed(self._hypotheses, candidates, likelihoods, newness, c, are_sound)
        if new:
            self._strange_since_ns = None
        elif self._is_anew(stamp_ns):
            new = belief.begun(candidates, likelihoods, are_sound)
        if new:
            self._hypotheses, self._fresh = belief.ranked(new, c.least_share), True
            self._followed_ns = stamp_ns
            self._take_waiting()
        self._say()

    def see_goals(self, seen: GoalsSeen) -> None:
        """Take the bearings of one class of goal: now, or with the mask of their moment."""
        if seen.kind not in self._goals:
            return
        if self._is_of_now(seen):
            self._weigh(seen)
            self._say()
        elif self._stamp_ns is None or seen.stamp_ns > self._stamp_ns:
            self._waiting.add(seen)

    def relocate(self, estimate: PoseEstimate) -> None:
        """Believe somebody who says where the robot is: the nearest of what fits, now or next."""
        self._told.waiting = estimate
        if self._hypotheses and self._fresh:
            self._believe_told()
            self._say()

    def take_refusal(self) -> str:
        """Return once why somebody was not believed; "" if nothing is to be said."""
        return self._told.take_refusal()

    def _believe_told(self) -> None:
        poses = [h.estimate for h in self._hypotheses]
        shares = self._told.choose(poses, self.config.gate_sd)
        if shares is not None:
            self._set_shares(shares)
            best, *rest = self._hypotheses
            self._hypotheses = [replace(best, num_masks=max(1, best.num_masks)), *rest]

    def _silent_s(self, stamp_ns: int) -> float:
        """Return how long no mask has shown where the robot is."""
        return abs(stamp_ns - self._followed_ns) / _S

    def _go_on(self, stamp_ns: int, T_odom_base: SE2 | None) -> float:
        """Carry the belief to a mask's moment; return how much of a new image the mask is."""
        c = self.config
        if self._stamp_ns is None:
            return 1.0
        if stamp_ns < self._stamp_ns - c.lost_after_s * _S:  # time has jumped back
            self._waiting.clear()
        self._hypotheses = [
            replace(h, estimate=self._moved(h.estimate, stamp_ns, T_odom_base))
            for h in self._hypotheses
        ]
        if self._told.waiting is not None:
            self._told.waiting = self._moved(self._told.waiting, stamp_ns, T_odom_base)
        before = max(self._silent_s(self._stamp_ns), c.lost_after_s)
        unseen_s = max(self._silent_s(stamp_ns) - before, 0.0)
        self._hypotheses = belief.drifted(self._hypotheses, unseen_s, c.carried_per_s)
        return min(abs(stamp_ns - self._stamp_ns) / (c.new_after_s * _S), 1.0)

    def _moved(
        self, estimate: PoseEstimate, stamp_ns: int, T_odom_base: SE2 | None
    ) -> PoseEstimate:
        """Return where an estimate of the newest mask's moment is at another."""
        if self._stamp_ns is None:
            return estimate
        dt = abs(stamp_ns - self._stamp_ns) / _S
        motion, cov = motion_between(self._T_odom_base, T_odom_base, dt, self.config)
        return propagate(estimate, motion, cov)

    def _is_anew(self, stamp_ns: int) -> bool:
        """Return whether there is nothing to follow from, or not any more: carried away."""
        if self._strange_since_ns is None:
            self._strange_since_ns = stamp_ns
        strange_s = abs(stamp_ns - self._strange_since_ns) / _S
        if self._hypotheses and strange_s < self.config.lost_after_s:
            self._fresh = False
            return False
        self.num_carried += bool(self._hypotheses)
        self._strange_since_ns = None
        return True

    def _set_shares(self, shares: np.ndarray) -> None:
        weighed = belief.with_shares(self._hypotheses, shares)
        self._hypotheses = belief.ranked(weighed, self.config.least_share)

    def _is_of_now(self, seen: GoalsSeen) -> bool:
        is_near = abs(seen.stamp_ns - (self._stamp_ns or 0)) <= self.config.max_skew_s * _S
        return self._stamp_ns is not None and self._fresh and is_near

    def _take_waiting(self) -> None:
        """Let goals and people speak who came before the mask."""
        for seen in self._waiting.take(self._stamp_ns or 0, self.config.max_skew_s):
            self._weigh(seen)
        self._believe_told()

    def _weigh(self, seen: GoalsSeen) -> None:
        """Let a goal seen speak for the hypotheses in which it is where the plan has it."""
        c, goal = self.config, self._goals[seen.kind]
        bearings = seen.bearings[np.isfinite(seen.bearings)]
        if not len(bearings):
            return
        weight = c.goal_weight * self._waiting.count(seen, c.new_after_s)
        sensors = [h.estimate.pose @ seen.T_base_sensor for h in self._hypotheses]
        likely = np.array([goal_likelihood(sensor, bearings, goal, c) for sensor in sensors])
        self._set_shares(np.array([h.share for h in self._hypotheses]) * likely**weight)

    def _say(self) -> None:
        if self.state is TrackState.LOST:
            self.reason = "the pose does not follow from the motion"
        elif self.state is TrackState.OPEN:
            self.reason = belief.why_open(
                self._hypotheses, tuple(self._goals), self.config.settle_masks
            )
        else:
            self.reason = ""
