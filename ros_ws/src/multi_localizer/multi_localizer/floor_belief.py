"""Poses that may be the robot's and how much of the belief each has: carried, followed, ranked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from multi_localizer.floor_misfit import ODD_COST
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis

MIN_FOLLOWED = 0.1  # with less of the belief followed, it is the robot that has gone, not rivals


@dataclass(frozen=True)
class Hypothesis:
    """A pose that may be the robot's, its share of the belief, and in how many masks it was.

    Masks that mostly contradict it do not count before one that does not: 0.
    """

    estimate: PoseEstimate
    share: float
    num_masks: int = 1


def ranked(hypotheses: Sequence[Hypothesis], least_share: float) -> list[Hypothesis]:
    """Return the likeliest first, shares of sum 1; what is against the others leaves them a share.

    Args:
        hypotheses: With shares of any sum.
        least_share: What all but the likeliest keep together at least.
    """
    shares = np.array([h.share for h in hypotheses])
    least = least_share / max(1, len(shares) - 1)
    kept = np.maximum(shares / shares.sum(), least)
    return sorted(with_shares(hypotheses, kept / kept.sum()), key=lambda h: -h.share)


def with_shares(hypotheses: Sequence[Hypothesis], shares: np.ndarray) -> list[Hypothesis]:
    """Return the same with other shares, (N,)."""
    return [replace(h, share=float(s)) for h, s in zip(hypotheses, shares, strict=True)]


def drifted(hypotheses: Sequence[Hypothesis], unseen_s: float, rate: float) -> list[Hypothesis]:
    """Return the belief after a time unseen, in which somebody may have moved the robot."""
    keep = math.exp(-rate * unseen_s)
    even = (1.0 - keep) / max(1, len(hypotheses))
    return [replace(h, share=keep * h.share + even) for h in hypotheses]


def fit_likelihoods(
    costs: Sequence[float], num: int, newness: float, config: FloorTrackConfig
) -> np.ndarray:
    """Return how likely each of the poses that fit is, by how much of the border fits it, (num,).

    Args:
        costs: Share of the border that does not fit; empty if nobody says.
        num: How many poses there are.
        newness: How much of a new image this one is, 0 to 1.
        config: How much it says.
    """
    if not len(costs):
        return np.ones(num)
    worse = np.maximum(np.asarray(costs) - min(costs) - config.alike_share, 0.0)
    likelihoods = np.maximum(np.exp(-config.fit_weight * worse), config.worst_fit)
    return np.asarray(likelihoods**newness)


def sound_ones(costs: Sequence[float], num: int, first_cost: float) -> list[bool]:
    """Return which of the poses that fit most of the border does not contradict, (num,).

    Args:
        costs: Share of the border that does not fit; empty if nobody says.
        num: How many poses there are.
        first_cost: That of the best before what lies behind walls was left out.
    """
    return [max(cost, first_cost) <= ODD_COST for cost in costs] if len(costs) else [True] * num


def begun(
    candidates: Sequence[PoseEstimate], likelihoods: np.ndarray, are_sound: Sequence[bool]
) -> list[Hypothesis]:
    """Return poses that follow from nothing, seen in a mask that fits them soundly or not."""
    each = zip(candidates, likelihoods, are_sound, strict=True)
    return [Hypothesis(c, float(s), int(is_sound)) for c, s, is_sound in each]


def followed(
    old: Sequence[Hypothesis],
    candidates: Sequence[PoseEstimate],
    likelihoods: np.ndarray,
    newness: float,
    config: FloorTrackConfig,
    are_sound: Sequence[bool],
) -> list[Hypothesis]:
    """Return the candidates that follow from the belief; none if most of it has no follower.

    What has no follower was not looked for or fits worse than what was found: it stays for some
    masks, with less and less of the belief.

    Args:
        old: Where the motion has the hypotheses.
        candidates: Poses that fit.
        likelihoods: Of the candidates.
        newness: How much of a new image this one is, 0 to 1.
        config: Gate and shares.
        are_sound: Of the candidates, whether the mask fits them well enough to begin with.
    """
    shares, nums = np.zeros(len(candidates)), np.zeros(len(candidates), dtype=int)
    gone = []
    for h in old:
        off = np.array([mahalanobis(h.estimate, new) for new in candidates])
        fit = np.where(off < config.gate_sd**2, np.exp(-0.5 * off), 0.0)
        if fit.sum() > 0.0:
            shares += h.share * fit / fit.sum()
            nums[fit > 0.0] = np.maximum(nums[fit > 0.0], h.num_masks)
        else:
            gone.append(h)
    if shares.sum() < MIN_FOLLOWED:
        return []
    each = zip(candidates, shares * likelihoods, nums, are_sound, strict=True)
    new = [
        Hypothesis(c, float(s), int(n) + 1 if n or is_sound else 0) for c, s, n, is_sound in each
    ]
    faded = config.worst_fit**newness
    rest = [replace(h, share=faded * h.share) for h in gone]
    return new + [h for h in rest if h.share > config.least_share]


def why_open(hypotheses: Sequence[Hypothesis], goals: Sequence[str], settle_masks: int) -> str:
    """Return what keeps the likeliest pose from being known, and what would tell."""
    if hypotheses[0].num_masks == 0:
        return f"more than {ODD_COST:.0%} of the border has not fitted it in any mask yet"
    if len(hypotheses) == 1:
        return f"{hypotheses[0].num_masks} of {settle_masks} masks have shown it yet"
    alike = f"{'2' if len(hypotheses) == 2 else 'several'} poses fit alike"  # not all in each mask
    if not goals:
        return f"{alike}: the plan names no goal that tells, and nobody sent initialpose"
    return f"{alike}: no goal ({' or '.join(goals)}) has told them apart yet"
