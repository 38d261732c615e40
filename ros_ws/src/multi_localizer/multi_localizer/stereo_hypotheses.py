"""Poses that may be the robot's: how sure each is, which are the same, whether one is known.

A pose whose views cost less by c is surer by exp(evidence * c). `evidence` says how many pixels'
errors there are that do not hang together; the same number makes the covariance of the fit's
Hessian, and is chosen so that both come true on places that no figure is from.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState

WIDEST = 1.0
"""Deviation in m and rad of what the views say nothing about."""


def covariance(information: np.ndarray, config: StereoLocalizerConfig) -> np.ndarray:
    """Return the covariance of x, y, yaw, (3, 3), of what is known of them, not below a floor."""
    cov = np.linalg.inv(information + np.eye(3) / WIDEST**2) + least_covariance(config)
    return np.asarray(0.5 * (cov + cov.T))


def least_covariance(config: StereoLocalizerConfig) -> np.ndarray:
    """Return what no covariance of x, y, yaw is below, (3, 3)."""
    least = np.array([config.least_error_m, config.least_error_m, config.least_error_rad])
    return np.asarray(np.diag(least**2))


def hypotheses_of(
    poses: np.ndarray,
    covs: Sequence[np.ndarray],
    costs: np.ndarray,
    log_shares: np.ndarray,
    config: StereoLocalizerConfig,
) -> tuple[StereoHypothesis, ...]:
    """Return poses as hypotheses, the likeliest first.

    Args:
        poses: (N, 3).
        covs: Of each, (3, 3).
        costs: Of each, (N,).
        log_shares: Logarithms of their parts of the belief, (N,), of any sum.
        config: What is the same, and what is dropped.

    Returns:
        No two of them the same, their shares summing to 1.
    """
    kept: list[int] = []
    for n in np.argsort(-log_shares, kind="stable").tolist():
        if not any(_is_same(poses[n], poses[k], config) for k in kept):
            kept.append(n)
    kept = kept[: config.max_hypotheses]
    shares = np.exp(log_shares[kept] - log_shares.max())
    shares /= shares.sum()
    chosen = [(n, s) for n, s in zip(kept, shares, strict=True) if s >= config.least_share]
    total = sum(s for _, s in chosen)
    return tuple(
        StereoHypothesis(
            PoseEstimate(SE2(*poses[n].tolist()), covs[n]), float(s / total), float(costs[n])
        )
        for n, s in chosen
    )


def judged(
    hypotheses: tuple[StereoHypothesis, ...], known: float, config: StereoLocalizerConfig
) -> StereoPose:
    """Return what can be said: a known pose, several that look alike, or that there is none.

    Args:
        hypotheses: The likeliest first.
        known: Share of the pixels whose distance is known.
        config: What is lost and what is settled.
    """
    if not hypotheses:
        return StereoPose(StereoState.LOST, (), "no place in the map is free")
    if known < config.least_seen:
        return StereoPose(StereoState.LOST, hypotheses, "the cameras see too little")
    most = config.judge_color + (1.0 - config.judge_color) * known  # a cost can be no greater
    wrong = min(h.score for h in hypotheses) / most
    if wrong > config.lost_cost:
        text = f"the views fit nowhere: {wrong:.0%} of them is wrong at the best pose"
        return StereoPose(StereoState.LOST, hypotheses, text)
    if hypotheses[0].share < config.settle_share:
        return StereoPose(StereoState.AMBIGUOUS, hypotheses, f"{len(hypotheses)} poses look alike")
    return StereoPose(StereoState.KNOWN, hypotheses)


def _is_same(a: np.ndarray, b: np.ndarray, config: StereoLocalizerConfig) -> bool:
    is_near = np.hypot(*(a[:2] - b[:2])) < config.same_m
    return bool(is_near and abs(wrap_angle(a[2] - b[2])) < config.same_rad)
