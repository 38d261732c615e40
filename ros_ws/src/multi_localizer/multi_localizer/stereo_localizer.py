"""Where a robot with stereo pairs is in a voxel map, without a guess and from view to view."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_locator import StereoLocator
from multi_localizer.stereo_pose import StereoPose, StereoState
from multi_localizer.stereo_published import judged_candidates
from multi_localizer.stereo_search import PublishedSearch
from multi_localizer.stereo_track import StereoTracker
from multi_localizer.stereo_view import VIEW_COLUMNS, VIEW_ROWS, StereoView
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera, VoxelScene


class StereoLocalizer:
    """Finds and follows the pose of base_link.

    By the published methods every view is searched for in the whole map; when tracking, of the
    candidates as good as the best that near the pose before is taken, if there is one: the paper's
    remedy for places that look alike.

    Args:
        voxels: The map, or the scene made of it, whose threads then share the work.
        cameras: The left camera of each pair; views are given in their order.
        config: Method and tuning.
        num_threads: Threads that share the work; the result does not depend on it.
    """

    def __init__(
        self,
        voxels: VoxelMap | VoxelScene,
        cameras: Sequence[ViewCamera],
        config: StereoLocalizerConfig | None = None,
        num_threads: int = 1,
    ) -> None:
        if not cameras:
            raise ValueError("cameras must hold at least one, got none")
        self.config = StereoLocalizerConfig() if config is None else config
        self._cameras = tuple(cameras)
        scene = voxels if isinstance(voxels, VoxelScene) else VoxelScene(voxels, num_threads)
        self._published: PublishedSearch | None = None
        if self.config.method == "ours":
            self._locator = StereoLocator(scene, self._cameras, self.config)
            self._tracker = StereoTracker(scene, self._cameras, self.config, self._locator.locate)
        else:
            self._published = PublishedSearch(scene, self._cameras, self.config)
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is."""
        self._last: SE2 | None = None
        if self._published is None:
            self._tracker.reset()

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; the pose stays.

        Raises:
            ValueError: If a value that is read-only is another one.
        """
        for f in fields(config):
            is_fixed = f.metadata.get("read_only", False)
            if is_fixed and getattr(config, f.name) != getattr(self.config, f.name):
                raise ValueError(f"{f.name} cannot be changed, got {getattr(config, f.name)}")
        self.config = config
        if self._published is None:
            self._locator.reconfigure(config)
            self._tracker.reconfigure(config)
        else:
            self._published.reconfigure(config)

    def relocate(self, told: PoseEstimate) -> None:
        """Believe somebody who says where the robot is: look for it there with the next views."""
        if self._published is None:
            self._tracker.relocate(told)
        else:
            self._last = told.pose

    def take_refusal(self) -> str:
        """Return once why a told pose was not believed; "" if nothing is to be said."""
        return "" if self._published is not None else self._tracker.take_refusal()

    def locate(self, views: Sequence[StereoView | None]) -> StereoPose:
        """Return the pose by one view of each pair (None where one is missing), without a guess.

        Raises:
            ValueError: If there is not one view a camera, or none at all.
        """
        self._check(views)
        if self._published is None:
            return self._locator.locate(views)
        return self._search(self._published, views, None)

    def track(
        self, views: Sequence[StereoView | None], motion: SE2 | None, dt: float
    ) -> StereoPose:
        """Return the pose after a motion; the first time, or when lost, without a guess.

        Args:
            views: One of each pair, None where one is missing.
            motion: The robot's pose seen from the one before, by odometry; None without.
            dt: Time since the views before, s.

        Raises:
            ValueError: If there is not one view a camera, none at all, or dt is below 0.
        """
        self._check(views)
        if not (math.isfinite(dt) and dt >= 0.0):
            raise ValueError(f"dt must be finite and at least 0, got {dt}")
        if self._published is None:
            return self._tracker.update(views, motion, dt)
        carried = SE2.identity() if motion is None else motion
        expected = None if self._last is None else self._last @ carried
        found = self._search(self._published, views, expected)
        self._last = found.pose if found.state is StereoState.KNOWN else None
        return found

    def warm_up(self) -> None:
        """Compile what locating and tracking need, if it is not compiled yet."""
        view = StereoView(
            np.full((VIEW_ROWS, VIEW_COLUMNS, 3), 100.0, dtype=np.float32),
            *(np.ones((VIEW_ROWS, VIEW_COLUMNS), dtype=np.float32) for _ in range(3)),
        )
        for _ in range(2):
            self.track([view] * len(self._cameras), SE2.identity(), 0.1)
        self.reset()

    def _search(
        self, published: PublishedSearch, views: Sequence[StereoView | None], expected: SE2 | None
    ) -> StereoPose:
        weight = 0.0 if self.config.method == "color_only" else self.config.distance_weight
        poses, scores = published.search(views, weight)
        return judged_candidates(poses, scores, views, expected, self.config)

    def _check(self, views: Sequence[StereoView | None]) -> None:
        if len(views) != len(self._cameras):
            raise ValueError(f"views must be {len(self._cameras)}, one a camera, got {len(views)}")
        if all(view is None for view in views):
            raise ValueError("views must hold at least one, got none")
