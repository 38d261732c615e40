"""Where a robot with stereo pairs is in a voxel map, without a guess and from view to view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.stereo_search import PublishedSearch
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera, VoxelScene


class StereoLocalizer:
    """Finds and follows the pose of base_link.

    Args:
        voxels: The map.
        cameras: The left camera of each pair; views are given in their order.
        config: Method and tuning.
        num_threads: Threads that share the work; the result does not depend on it.
    """

    def __init__(
        self,
        voxels: VoxelMap,
        cameras: Sequence[ViewCamera],
        config: StereoLocalizerConfig | None = None,
        num_threads: int = 1,
    ) -> None:
        if not cameras:
            raise ValueError("cameras must hold at least one, got none")
        self.config = StereoLocalizerConfig() if config is None else config
        self._cameras = tuple(cameras)
        self._scene = VoxelScene(voxels, num_threads)
        self._published = PublishedSearch(self._scene, self._cameras, self.config)
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is."""
        self._last: StereoPose | None = None

    def locate(self, views: Sequence[StereoView | None]) -> StereoPose:
        """Return the pose by one view of each pair (None where one is missing), without a guess."""
        self._check(views)
        weight = 0.0 if self.config.method == "color_only" else self.config.distance_weight
        poses, scores = self._published.search(views, weight)
        if not len(poses):
            return StereoPose(StereoState.LOST, (), "no place in the map is free")
        estimate = PoseEstimate(SE2(*poses[0].tolist()), np.diag([0.01**2, 0.01**2, 0.02**2]))
        return StereoPose(StereoState.KNOWN, (StereoHypothesis(estimate, 1.0, float(scores[0])),))

    def track(self, views: Sequence[StereoView | None], motion: SE2, dt: float) -> StereoPose:
        """Return the pose after a motion.

        Args:
            views: One of each pair, None where one is missing.
            motion: The robot's pose seen from the one before, by odometry.
            dt: Time since the views before, s.
        """
        self._last = self.locate(views)
        return self._last

    def _check(self, views: Sequence[StereoView | None]) -> None:
        if len(views) != len(self._cameras):
            raise ValueError(f"views must be {len(self._cameras)}, one a camera, got {len(views)}")
        if all(view is None for view in views):
            raise ValueError("views must hold at least one, got none")
