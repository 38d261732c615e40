"""What can be said of the candidates that the published search leaves.

The paper gives the best one, and of alike ones that near the pose before (section 4). It has no
word for a robot that is not in the map, or may be in two places, and none for how wrong a pose is:
the limits and deviations here are those of places that no figure is from. Colors alone are right at
one place of five, in the paper as well, so that by them a pose is only followed, not found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.stereo_view import StereoView

_NEAR_M, _NEAR_RAD = 0.5, 0.5
_BY_COLOR = 10.0  # so many times as wrong are poses by color alone


def judged_candidates(
    poses: np.ndarray,
    scores: np.ndarray,
    views: Sequence[StereoView | None],
    expected: SE2 | None,
    config: StereoLocalizerConfig,
) -> StereoPose:
    """Return what can be said of where the robot is.

    Args:
        poses: Candidates, the best first, (N, 3).
        scores: Eq. 1 of each, (N,).
        views: What was seen.
        expected: Where the pose before and the motion have it; None at first.
        config: Method, limits and deviations.
    """
    c = config
    if not len(poses):
        return StereoPose(StereoState.LOST, (), "no place in the map is free")
    alike = np.flatnonzero(scores <= scores[0] + c.alike_score).tolist()
    near = [k for k in alike if expected is not None and _are_near(poses[k], expected)]
    apart = near[:1]
    for k in alike:
        if not any(_are_near(poses[k], SE2(*poses[other].tolist())) for other in apart):
            apart.append(k)
    found = _hypotheses(poses[apart], scores[apart], config)
    seen = [float(view.weight.mean()) for view in views if view is not None]
    if sum(seen) < c.least_seen * len(seen):
        return StereoPose(StereoState.LOST, found, "the cameras see too little")
    if scores[0] > c.lost_score:
        text = f"the views fit nowhere: eq. 1 is {scores[0]:.3f} at the best pose"
        return StereoPose(StereoState.LOST, found, text)
    if near:
        return StereoPose(StereoState.KNOWN, found[:1])
    if len(found) > 1:
        return StereoPose(StereoState.AMBIGUOUS, found, f"{len(found)} poses look alike")
    if c.method == "color_only":
        text = "colors alone follow a pose, but do not find one: give it by initialpose"
        return StereoPose(StereoState.AMBIGUOUS, found, text)
    return StereoPose(StereoState.KNOWN, found)


def _hypotheses(
    poses: np.ndarray, scores: np.ndarray, config: StereoLocalizerConfig
) -> tuple[StereoHypothesis, ...]:
    wrong = _BY_COLOR if config.method == "color_only" else 1.0
    sd = wrong * np.array([config.mesh_error_m, config.mesh_error_m, config.mesh_error_rad])
    shares = np.exp(-(scores - scores.min()) / config.alike_score)
    shares /= shares.sum()
    found = tuple(
        StereoHypothesis(PoseEstimate(SE2(*pose), np.diag(sd**2)), share, score)
        for pose, share, score in zip(poses.tolist(), shares.tolist(), scores.tolist(), strict=True)
    )
    return found[: config.max_hypotheses]


def _are_near(pose: np.ndarray, other: SE2) -> bool:
    is_there = math.hypot(pose[0] - other.x, pose[1] - other.y) < _NEAR_M
    return is_there and abs(wrap_angle(float(pose[2]) - other.yaw)) < _NEAR_RAD
