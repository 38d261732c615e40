"""The pose without a guess, by the best of ours: all candidates, then the best of them refined."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_hypotheses import covariance, hypotheses_of, judged
from multi_localizer.stereo_judge import doubts, judge, known_part, polished
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoPose
from multi_localizer.stereo_refine import Fits, Target, refine, targets_of
from multi_localizer.stereo_search_all import SearchAll
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_view import ViewCamera, VoxelScene

COARSE, FINE = (40, 8), (80, 8)
"""Columns and rows of the views that poses are roughly fitted by, and fitted and judged."""
_LOOSE, _LESS_LOOSE, _ROUGH_STEPS, _STEPS = 4.0, 2.0, 4, 3
_NUM_SCATTERED, _SCATTER_M = 3, 0.08
_SPARE = 3  # so many times the hypotheses that may stay are fitted


class StereoLocator:
    """Finds a robot anywhere in a map.

    Args:
        scene: The map.
        cameras: One for each pair.
        config: Mesh and scales.
    """

    def __init__(
        self, scene: VoxelScene, cameras: Sequence[ViewCamera], config: StereoLocalizerConfig
    ) -> None:
        self._scene, self._cameras, self._config = scene, tuple(cameras), config
        self._search = SearchAll(scene, cameras, config)

    def locate(
        self, views: Sequence[StereoView | None], near: PoseEstimate | None = None
    ) -> StereoPose:
        """Return the pose by one view of each pair, None where one is missing.

        With `near` only poses are looked for that are near it by its covariance.
        """
        c = self._config
        poses = self._search.search(views, c.num_refined, near)
        if not len(poses):
            return judged((), 1.0, c)
        coarse = targets_of(views, self._cameras, COARSE, c)
        rough = refine(self._scene, coarse, poses, c, _ROUGH_STEPS, c.fit_color, _LOOSE)
        fine = targets_of(views, self._cameras, FINE, c)
        order = np.argsort(judge(self._scene, fine, rough.poses, c), kind="stable")
        best = rough.poses[order[: _SPARE * c.max_hypotheses]]
        better = refine(self._scene, fine, best, c, _STEPS, c.fit_color, _LESS_LOOSE)
        fits = self._fitted(fine, better.poses)
        costs = judge(self._scene, fine, fits.poses, c)
        again = self._fitted(fine, scattered(fits.poses[np.argsort(costs)[:_NUM_SCATTERED]]))
        fits = fits.joined(again)
        costs = np.concatenate((costs, judge(self._scene, fine, again.poses, c)))
        covs = [covariance(c.evidence * h, c) for h in fits.hessians]
        rivals = hypotheses_of(fits.poses, covs, costs, -costs, c)
        poses = np.array([h.estimate.pose.as_array() for h in rivals])
        poses = polished(self._scene, fine, poses, c)
        costs = judge(self._scene, fine, poses, c)
        covs = [h.estimate.cov for h in rivals]
        found = hypotheses_of(poses, covs, costs, -doubts(costs, c), c)
        return judged(found, known_part(fine), c)

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; what is read-only must be as it was."""
        self._config = config
        self._search.reconfigure(config)

    def _fitted(self, targets: Sequence[Target], poses: np.ndarray) -> Fits:
        c = self._config
        return refine(self._scene, targets, poses, c, _STEPS, c.fit_color)


def scattered(poses: np.ndarray) -> np.ndarray:
    """Return places around poses, (8 N, 3).

    Where distances are partly wrong, as those of what is too near, the least cost around may lie
    beyond a hill.
    """
    angles = np.arange(8) * np.pi / 4.0
    around = _SCATTER_M * np.stack((np.cos(angles), np.sin(angles), np.zeros(8)), axis=1)
    return np.asarray((poses[:, None] + around).reshape(-1, 3))
