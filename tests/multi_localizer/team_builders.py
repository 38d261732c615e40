"""Teams whose views follow from known poses, for the tests of the team's localizer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_views import RobotView

GOALS = {"yellow": np.array([[4.0, 0.0]]), "blue": np.array([[-4.0, 0.0]])}
TRIANGLE = np.array([[0.0, 0.0, 0.3], [2.0, 0.0, 2.0], [1.0, 1.5, -1.2]])
SIX = np.array([
    [-3.0, -1.2, 0.4], [-1.1, 1.3, 2.9], [0.2, -1.6, -2.0], [1.3, 0.3, 1.1],
    [2.9, -0.7, -0.6], [3.1, 1.7, -2.8],
])  # fmt: skip


def wrapped(angles: np.ndarray) -> np.ndarray:
    return (np.asarray(angles) + np.pi) % (2.0 * np.pi) - np.pi


def bearing(pose: np.ndarray, place: np.ndarray) -> float:
    return float(wrapped(np.arctan2(place[1] - pose[1], place[0] - pose[0]) - pose[2]))


def team(
    poses: np.ndarray,
    *,
    seed: int = 0,
    noise: float = 0.01,
    rough_sd: Sequence[float] | None = (0.2, 0.2, 0.15),
    landmarks: Mapping[str, np.ndarray] = GOALS,
    objects: Mapping[str, np.ndarray] | None = None,
) -> tuple[list[RobotView], list[np.ndarray]]:
    """Return every robot's view of all others, shuffled, and the true identities."""
    rng = np.random.default_rng(seed)
    views, truth = [], []
    for i, pose in enumerate(poses):
        others = rng.permutation([j for j in range(len(poses)) if j != i])
        seen = np.array([bearing(pose, poses[j, :2]) for j in others])
        rough = None
        if rough_sd is not None:
            shift = rng.normal(0.0, 1.0, 3) * rough_sd
            rough = PoseEstimate(SE2(*(pose + shift)), np.diag(np.square(rough_sd)))
        views.append(
            RobotView(
                f"r{i}",
                wrapped(seen + rng.normal(0.0, noise, len(seen))),
                _sights(pose, landmarks, noise, rng),
                _sights(pose, objects or {}, noise, rng),
                rough,
                bearing_sd=max(noise, 1e-4),
            )
        )
        truth.append(others)
    return views, truth


def _sights(
    pose: np.ndarray, places: Mapping[str, np.ndarray], noise: float, rng: np.random.Generator
) -> dict[str, np.ndarray]:
    return {
        kind: wrapped([bearing(pose, p) + rng.normal(0.0, noise) for p in points])
        for kind, points in places.items()
    }
