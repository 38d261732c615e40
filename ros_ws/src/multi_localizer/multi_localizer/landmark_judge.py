"""Whether a pose among landmarks is sure enough to be sent, or why it is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from floornav_common.se2 import wrap_angle
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import (
    PoseFit,
    Sighting,
    estimate_of,
    is_curved,
    open_geometry,
    residuals,
    without_distance,
)
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis

NEED = 3  # numbers for three unknowns
CONTRADICTING = "the bearings contradict each other: no place fits most of them"
_SAME_CHI2 = 9.0
_CLEARLY_OTHER_M, _CLEARLY_OTHER_RAD = 0.3, 0.3
_RARELY = 1e-3  # how often true bearings of the stated deviation may be refused
Assignment = tuple[tuple[Sighting, Landmark] | None, ...]
"""Of each sighting what is used of it, with or without its distance, and the landmark it is of."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """A pose and what it makes of the sightings.

    Attributes:
        fit: The pose.
        marks: What each sighting is of.
        cost: Squared deviations, and what is left out.
    """

    fit: PoseFit
    marks: Assignment
    cost: float


@dataclass(frozen=True)
class Verdict:
    """What is thought of the best explanation.

    Attributes:
        estimate: The pose; None if it is not to be sent.
        problem: Why not; "" if it is.
        note: What is to be said with it.
        is_sound: Whether nothing speaks against it but others that fit as well.
    """

    estimate: PoseEstimate | None
    problem: str = ""
    note: str = ""
    is_sound: bool = False


def judge(found: Sequence[Explanation], num_seen: int, config: LandmarkConfig) -> Verdict:
    """Judge explanations, the best first; `num_seen` numbers are to be explained."""
    best = found[0]
    used = [pair for pair in best.marks if pair is not None]
    num_values = sum(s.num_values for s, _ in used)
    problem = _contradiction(best, len(used), num_values, num_seen)
    if problem:
        return Verdict(None, problem)
    estimate = estimate_of(best.fit)
    marks = [m for _, m in used]
    if estimate is None:
        return Verdict(None, open_geometry(best.fit.pose, marks))
    problem = _doubt(estimate, best, [s for s, _ in used], marks, config) or _unconfirmed(
        num_values, config
    )
    if problem:
        return Verdict(None, problem)
    rival = _rival(found, config)
    if rival:
        return Verdict(None, rival, is_sound=True)
    note = "nothing confirms it" if num_values == NEED else ""
    return Verdict(estimate, note=note, is_sound=True)


def as_expected(
    found: Sequence[Explanation], expected: PoseEstimate | None, config: LandmarkConfig
) -> list[Explanation]:
    """Return explanations, the best first; of those that fit alike the expected ones alone."""
    likely = [e for e in found if e.cost - found[0].cost < config.ambiguity_sd**2]
    near = [e for e in likely if expected is not None and is_near(e, expected, config)]
    return [e for e in found if e in near or e not in likely] if near else list(found)


def is_near(one: Explanation, expected: PoseEstimate, config: LandmarkConfig) -> bool:
    """Return whether an explanation is of the expected pose."""
    estimate = estimate_of(one.fit)
    return estimate is not None and mahalanobis(estimate, expected) < config.gate_sd**2


def are_apart(a: Explanation, b: Explanation) -> bool:
    """Return whether two explanations are of different poses."""
    first, second = estimate_of(a.fit), estimate_of(b.fit)
    if first is not None and second is not None:
        return mahalanobis(first, second) > _SAME_CHI2
    apart = math.hypot(a.fit.pose.x - b.fit.pose.x, a.fit.pose.y - b.fit.pose.y)
    turned = abs(wrap_angle(a.fit.pose.yaw - b.fit.pose.yaw))
    return apart > _CLEARLY_OTHER_M or turned > _CLEARLY_OTHER_RAD


def why_left_out(best: Explanation, seen: Sequence[Sighting], known: Landmarks) -> tuple[str, ...]:
    """Return in words, of each sighting that the best explanation leaves out, what is wrong."""
    return tuple(
        f"{s.kind} at {math.degrees(wrap_angle(s.bearing)):.0f} deg: {_off(best, s, known)}"
        for s, pair in zip(seen, best.marks, strict=True)
        if pair is None
    )


def _off(best: Explanation, sighting: Sighting, known: Landmarks) -> str:
    seen_there = [pair[1] for pair in best.marks if pair is not None]
    free = [m for m in known[sighting.kind] if all(m is not other for other in seen_there)]
    if not free:
        return f"every {sighting.kind} is seen at another bearing"
    alone = without_distance(sighting)
    sds = min(abs(residuals(best.fit.pose, [alone], [mark])[0][0]) for mark in free)
    off = math.degrees(sds * sighting.bearing_sd)
    return f"{off:.1f} deg beside the nearest {sighting.kind} not yet seen"


def _contradiction(best: Explanation, num_used: int, num_values: int, num_seen: int) -> str:
    """Return in words that the sightings do not agree; "" if they do."""
    if num_values < NEED or num_used < len(best.marks) / 2.0:
        return CONTRADICTING
    if num_values == NEED < num_seen:
        return f"{CONTRADICTING}, and nothing confirms those that do"
    if num_values > NEED and best.fit.chi2 > chdtri(num_values - NEED, _RARELY):
        times = math.sqrt(best.fit.chi2 / (num_values - NEED))
        return f"the bearings contradict each other: {times:.1f} times as much as bearing_sd_rad"
    return ""


def _doubt(
    estimate: PoseEstimate, best: Explanation, seen: Sequence[Sighting],
    marks: Sequence[Landmark], config: LandmarkConfig,
) -> str:  # fmt: skip
    """Return in words that the geometry leaves the pose badly known; "" if it does not."""
    sd_m = math.sqrt(np.linalg.eigvalsh(estimate.cov[:2, :2])[1])
    sd_yaw = math.sqrt(estimate.cov[2, 2])
    if sd_m > config.max_position_sd_m or sd_yaw > config.max_yaw_sd_rad:
        why = open_geometry(best.fit.pose, marks)
        return f"{why}: known to {sd_m:.2f} m and {sd_yaw:.2f} rad only"
    if is_curved(estimate, best.fit.chi2, seen, marks):
        return f"{open_geometry(best.fit.pose, marks)}: not known well enough"
    return ""


def _unconfirmed(num_values: int, config: LandmarkConfig) -> str:
    """Return in words that a false bearing would not show; "" if it would."""
    if num_values - NEED >= config.min_spare:
        return ""
    return (
        f"{num_values} bearings and distances, {NEED} are needed and {config.min_spare} more to "
        "confirm them (min_spare)"
    )


def _rival(found: Sequence[Explanation], config: LandmarkConfig) -> str:
    """Return in words that another pose fits as well; "" if none does."""
    best, margin = found[0], config.ambiguity_sd**2
    for other in found[1:]:
        if other.cost - best.cost < margin and are_apart(other, best):
            first, second = best.fit.pose, other.fit.pose
            return (
                f"ambiguous: ({first.x:.2f}, {first.y:.2f}) m, {first.yaw:.2f} rad and "
                f"({second.x:.2f}, {second.y:.2f}) m, {second.yaw:.2f} rad fit alike"
            )
    return ""
