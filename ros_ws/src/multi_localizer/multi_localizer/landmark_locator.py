"""From what is seen of landmarks to a pose: who is who, and what is false."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting, fit_pose, residuals, without_distance
from multi_localizer.landmark_judge import (
    CONTRADICTING,
    NEED,
    Assignment,
    Explanation,
    are_apart,
    as_expected,
    is_near,
    judge,
    why_left_out,
)
from multi_localizer.landmark_starts import choices, refined_poses, rough_costs
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.pose_estimate import PoseEstimate

_KEPT = 6  # best tries that are fitted to the end
_SAME_START_M, _SAME_START_RAD = 0.1, 0.1


@dataclass(frozen=True)
class LandmarkFix:
    """Where the sensor is, by landmarks.

    Attributes:
        estimate: Its pose; None if there is none to be had.
        problem: Why there is none; "" if there is.
        num_used: Sightings that made it.
        left_out: What fits no landmark, and why: a sighting each, in words.
        note: What was left out before, or is missing, in words.
        is_elsewhere: Whether what was seen is explained well, but by no pose near the expected one.
    """

    estimate: PoseEstimate | None
    problem: str = ""
    num_used: int = 0
    left_out: tuple[str, ...] = ()
    note: str = ""
    is_elsewhere: bool = False


class LandmarkLocator:
    """Finds poses among known landmarks.

    Args:
        landmarks: By class.
        config: Deviations and gates.
    """

    def __init__(self, landmarks: Landmarks, config: LandmarkConfig) -> None:
        self._landmarks, self._config = landmarks, config
        corners = [c for marks in landmarks.values() for m in marks for c in m.corners]
        self._middle = np.array(corners).mean(axis=0)

    def locate(
        self, sightings: Sequence[Sighting], expected: PoseEstimate | None = None
    ) -> LandmarkFix:
        """Return the one pose that explains what was seen, or why there is none.

        Args:
            sightings: What is seen at one moment.
            expected: Where the sensor should be; tells poses apart that fit alike.
        """
        usable, note = self._usable(sightings)
        if sum(s.num_values for s in usable) < NEED:
            return LandmarkFix(None, _too_few(usable), note=note)
        tries = self._tries(usable)
        if not tries:
            return LandmarkFix(None, self._no_start(usable), note=note)
        tries = as_expected(tries, expected, self._config)
        best = tries[0]
        used = [pair for pair in best.marks if pair is not None]
        out = why_left_out(best, usable, self._landmarks)
        verdict = judge(tries, sum(s.num_values for s in usable), self._config)
        is_there = expected is None or is_near(best, expected, self._config)
        is_elsewhere = verdict.is_sound and not is_there
        if verdict.problem:
            return LandmarkFix(None, verdict.problem, 0, out, note, is_elsewhere)
        notes = "; ".join(words for words in (note, verdict.note) if words)
        return LandmarkFix(verdict.estimate, "", len(used), out, notes, is_elsewhere)

    def _usable(self, sightings: Sequence[Sighting]) -> tuple[list[Sighting], str]:
        finite = [s for s in sightings if math.isfinite(s.bearing)]
        known = [s for s in finite if s.kind in self._landmarks]
        notes = []
        if len(finite) < len(sightings):
            notes.append(f"{len(sightings) - len(finite)} bearings are not numbers")
        if len(known) < len(finite):
            notes.append(f"{len(finite) - len(known)} bearings of no known class")
        return known, "; ".join(notes)

    def _tries(self, seen: list[Sighting]) -> list[Explanation]:
        """Return fitted explanations, the best first."""
        starts = list(self._starts(seen))
        tries: list[Explanation] = []
        for pose in self._promising(starts, seen):
            found = self._settle(pose, seen)
            if found is not None and all(are_apart(found, t) for t in tries):
                tries.append(found)
        return sorted(tries, key=lambda t: t.cost)

    def _settle(self, pose: SE2, seen: list[Sighting]) -> Explanation | None:
        """Fit and assign in turn until nothing changes."""
        marks, _ = self._assign(pose, seen, wide=4.0)
        for _ in range(4):
            used = [pair for pair in marks if pair is not None]
            if sum(s.num_values for s, _ in used) < NEED:
                return None
            fit = fit_pose(pose, [s for s, _ in used], [m for _, m in used])
            if fit is None:
                return None
            pose = fit.pose
            new, cost = self._assign(pose, seen)
            if new == marks:
                return Explanation(fit, marks, cost)
            marks = new
        return None

    def _assign(
        self, pose: SE2, seen: Sequence[Sighting], wide: float = 1.0
    ) -> tuple[Assignment, float]:
        """Return the nearest landmark of each sighting, each taken once, and what it costs.

        A distance that does not fit costs less than a bearing: something stands before the foot.
        """
        limit = (wide * self._config.gate_sd) ** 2
        limit_far = 0.5 * limit
        pairs = []
        for k, s in enumerate(seen):
            for n, mark in enumerate(self._landmarks[s.kind]):
                off = (residuals(pose, [s], [mark])[0] ** 2).tolist()
                if off[0] < limit:
                    pairs.append((off[0], sum(off[1:]), k, n))
        marks: list[tuple[Sighting, Landmark] | None] = [None] * len(seen)
        taken: set[tuple[str, int]] = set()
        cost = sum(limit + (s.num_values - 1) * limit_far for s in seen)
        for near, far, k, n in sorted(pairs, key=lambda pair: pair[0] + min(pair[1], limit_far)):
            if marks[k] is None and (seen[k].kind, n) not in taken:
                has_far = far < limit_far
                used = seen[k] if has_far else without_distance(seen[k])
                marks[k] = (used, self._landmarks[seen[k].kind][n])
                taken.add((seen[k].kind, n))
                cost += near - limit + (used.num_values - 1) * (far - limit_far)
        return tuple(marks), cost

    def _promising(self, starts: list[SE2], seen: list[Sighting]) -> list[SE2]:
        """Return the starts that all sightings like best, not two of nearly the same pose."""
        if not starts:
            return []
        costs = rough_costs(starts, seen, self._landmarks, (2.0 * self._config.gate_sd) ** 2)
        kept: list[SE2] = []
        for k in np.argsort(costs, kind="stable"):
            pose = starts[k]
            if not any(_is_same_start(pose, other) for other in kept):
                kept.append(pose)
            if len(kept) == _KEPT:
                break
        return kept

    def _starts(self, seen: list[Sighting]) -> Iterator[SE2]:
        """Yield poses that few sightings give."""
        num = 0
        for chosen in choices(seen):
            few = [seen[k] for k in chosen]
            for marks in self._combinations(few):
                num += 1
                if num > self._config.max_tries:
                    return
                yield from refined_poses(few, marks, self._middle)

    def _combinations(self, seen: list[Sighting]) -> Iterator[tuple[Landmark, ...]]:
        for marks in itertools.product(*(self._landmarks[s.kind] for s in seen)):
            if len({id(m) for m in marks}) == len(marks):
                yield marks

    def _no_start(self, seen: list[Sighting]) -> str:
        """Return why no pose came out at all."""
        places = {tuple(m.position) for s in seen for m in self._landmarks[s.kind]}
        bearings = np.array([s.bearing for s in seen])
        if np.abs(np.sin(bearings[:, None] - bearings)).max() < 1e-3:
            return "robot and landmarks lie on one line"
        if len(places) < NEED:
            return f"{len(places)} landmarks leave a circle open, not a pose"
        return CONTRADICTING


def sightings_of(bearings: Mapping[str, np.ndarray], config: LandmarkConfig) -> list[Sighting]:
    """Return bearings by class, (K,) each, rad, as sightings without distances."""
    return [
        Sighting(kind, float(bearing), config.bearing_sd_rad)
        for kind, values in bearings.items()
        for bearing in values
    ]


def _is_same_start(a: SE2, b: SE2) -> bool:
    is_near = math.hypot(a.x - b.x, a.y - b.y) < _SAME_START_M
    return is_near and abs(wrap_angle(a.yaw - b.yaw)) < _SAME_START_RAD


def _too_few(seen: Sequence[Sighting]) -> str:
    if not seen:
        return "no landmark is seen"
    if len(seen) == 1:
        return "one landmark is seen: not enough for a pose"
    return "two landmarks leave a circle open, not a pose"
