"""Places that look alike: whether another place more than 1 m away shows nearly the same view.

Noise is what eq. 1 varies by from place to place where nothing but images and matching differ: the
deviation of its value for what the cameras saw against the map's view at the very place. Two places
look alike where eq. 1 of one's view in the map against the other's is less than that.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_score import published_scores
from multi_localizer.stereo_search import first_candidates
from multi_localizer.stereo_view import VIEW_COLUMNS, VIEW_ROWS, StereoView
from multi_localizer.voxel_view import ViewCamera, VoxelScene

FAR_M = 1.0
_COARSE, _MIDDLE, _FINE = (20, 2), (80, 4), (VIEW_COLUMNS, VIEW_ROWS)
_RAYS = (2, 2)
_NUM_SEEDS = 6
_STEPS = ((0.08, math.radians(11.25)), (0.04, math.radians(5.6)), (0.02, math.radians(2.8)),
          (0.01, math.radians(1.4)), (0.005, math.radians(0.7)))  # fmt: skip


@dataclass(frozen=True)
class Twin:
    """The place farther than 1 m away that looks most like another one.

    Attributes:
        pose: Of base_link.
        score: Eq. 1 of the two views in the map.
    """

    pose: SE2
    score: float


class LookAlikes:
    """Finds twins of places in a map.

    Args:
        scene: The map.
        cameras: The left camera of each pair.

    Attributes:
        scene: The map.
    """

    def __init__(self, scene: VoxelScene, cameras: Sequence[ViewCamera]) -> None:
        self.scene, self._cameras = scene, tuple(cameras)
        config = StereoLocalizerConfig()
        self._weight = config.distance_weight
        poses = first_candidates(scene, config).poses
        self._mesh = poses[self._are_free(poses)]
        self._shown = [scene.render(self._mesh, c, _COARSE, (4, 4)) for c in self._cameras]

    def score(self, pose: SE2, views: Sequence[StereoView | None]) -> float:
        """Return eq. 1 of what the pairs saw against the map's view at a pose."""
        return float(self._scores(_row(pose), views, _FINE)[0])

    def twin(self, pose: SE2) -> Twin:
        """Return the place that looks most like a pose, farther than 1 m from it.

        Begins at the likest poses of a mesh and where half a turn about the map's middle leads.
        """
        coarse, middle, fine = (self._views(pose, size) for size in (_COARSE, _MIDDLE, _FINE))
        total = sum(
            published_scores(*shown, view, self._weight, self.scene.voxels.farthest_m)
            for shown, view in zip(self._shown, coarse, strict=True)
        )
        far = np.hypot(*(self._mesh[:, :2] - (pose.x, pose.y)).T) > FAR_M
        order = np.argsort(np.where(far, total, np.inf), kind="stable")[:_NUM_SEEDS]
        seeds = np.vstack((self._mesh[order], self._opposite(pose)))
        for step, turn in _STEPS:
            around = np.array(list(itertools.product((-1, 0, 1), repeat=3))) * (step, step, turn)
            poses = (seeds[:, None] + around).reshape(-1, 3)
            scores = self._scores(poses, middle, _MIDDLE)
            far = np.hypot(*(poses[:, :2] - (pose.x, pose.y)).T) > FAR_M
            scores = np.where(far & self._are_free(poses), scores, np.inf)
            best = scores.reshape(len(seeds), -1).argmin(axis=1)
            seeds = poses.reshape(len(seeds), -1, 3)[np.arange(len(seeds)), best]
        far = np.hypot(*(seeds[:, :2] - (pose.x, pose.y)).T) > FAR_M
        scores = np.where(far, self._scores(seeds, fine, _FINE), np.inf)
        best = int(scores.argmin())
        return Twin(SE2(*seeds[best].tolist()), float(scores[best]))

    def _opposite(self, pose: SE2) -> np.ndarray:
        m = self.scene.voxels
        middle = (m.origin_x_m + m.size_m[0] / 2.0, m.origin_y_m + m.size_m[1] / 2.0)
        return np.array([[2 * middle[0] - pose.x, 2 * middle[1] - pose.y, pose.yaw + math.pi]])

    def _are_free(self, poses: np.ndarray) -> np.ndarray:
        return np.all([self.scene.is_free(poses, camera) for camera in self._cameras], axis=0)

    def _views(self, pose: SE2, size: tuple[int, int]) -> list[StereoView]:
        views = []
        for camera in self._cameras:
            color, distance = self.scene.render(_row(pose), camera, size, _rays_of(size))
            known = np.isfinite(distance[0]).astype(np.float32)
            views.append(StereoView(color[0], distance[0], 1.0 / distance[0], known))
        return views

    def _scores(
        self, poses: np.ndarray, views: Sequence[StereoView | None], size: tuple[int, int]
    ) -> np.ndarray:
        total = np.zeros(len(poses))
        for camera, view in zip(self._cameras, views, strict=True):
            assert view is not None
            shown = self.scene.render(poses, camera, size, _rays_of(size))
            total += published_scores(*shown, view, self._weight, self.scene.voxels.farthest_m)
        return total / len(self._cameras)


def _rays_of(size: tuple[int, int]) -> tuple[int, int]:
    return (4, 4) if size == _COARSE else (1, 1) if size == _FINE else _RAYS


def _row(pose: SE2) -> np.ndarray:
    return np.array([[pose.x, pose.y, pose.yaw]])
