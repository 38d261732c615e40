"""The pose from view to view: poses that may be the robot's carried by odometry and fitted anew.

What the paper names as the remedy for places that look alike, the pose before (section 4). All
poses that may be the robot's are kept; each is fitted near where the motion has it, and those whose
views cost more lose belief, the more the farther the robot has come since: a view from the same
place says nothing new. Views that fit nowhere near (somebody before the cameras, the robot carried
away) move nothing; if that goes on the robot is lost and looked for in the whole map.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import propagate
from multi_localizer.stereo_hypotheses import covariance, hypotheses_of, judged
from multi_localizer.stereo_judge import judge, known_part, polished
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_locator import COARSE, FINE
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.stereo_refine import Prior, refine, targets_of
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_view import ViewCamera, VoxelScene

_LOOSE, _ROUGH_STEPS, _STEPS = 3.0, 2, 3
_LEAST_NEW = 0.05

Locate = Callable[[Sequence[StereoView | None]], StereoPose]


class StereoTracker:
    """Follows a robot in a map.

    Args:
        scene: The map.
        cameras: One for each pair.
        config: Scales and times.
        locate: Finds it without a guess.
    """

    def __init__(
        self, scene: VoxelScene, cameras: Sequence[ViewCamera], config: StereoLocalizerConfig,
        locate: Locate,
    ) -> None:  # fmt: skip
        self._scene, self._cameras, self._config = scene, tuple(cameras), config
        self._locate = locate
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is."""
        self._hypotheses: tuple[StereoHypothesis, ...] = ()
        self._strange_s = 0.0
        self._since_locate_s = math.inf

    def update(self, views: Sequence[StereoView | None], motion: SE2, dt: float) -> StereoPose:
        """Return the pose after a motion; see `StereoLocalizer.track`."""
        self._since_locate_s += dt
        if not self._hypotheses:
            return self._look_everywhere(views)
        cov = motion_covariance(motion, dt, self._config)
        moved = tuple(
            replace(h, estimate=propagate(h.estimate, motion, cov)) for h in self._hypotheses
        )
        fitted = self._fitted(views, moved, newness(motion, self._config))
        if fitted.state is not StereoState.LOST:
            self._hypotheses, self._strange_s = fitted.hypotheses, 0.0
            return fitted
        self._hypotheses, self._strange_s = moved, self._strange_s + dt
        if self._strange_s > self._config.lost_after_s:
            return self._look_everywhere(views)
        state = StereoState.KNOWN
        if moved[0].share < self._config.settle_share:
            state = StereoState.AMBIGUOUS
        return StereoPose(state, moved, f"by odometry: {fitted.reason}")

    def _look_everywhere(self, views: Sequence[StereoView | None]) -> StereoPose:
        if self._since_locate_s < self._config.locate_period_s:
            return StereoPose(StereoState.LOST, self._hypotheses, "looked for in the whole map")
        self._since_locate_s = 0.0
        found = self._locate(views)
        if found.state is not StereoState.LOST:
            self._hypotheses, self._strange_s = found.hypotheses, 0.0
        return found

    def _fitted(
        self, views: Sequence[StereoView | None], moved: Sequence[StereoHypothesis], new: float
    ) -> StereoPose:
        """Return the hypotheses where the views fit best near them, with what that says of them."""
        c = self._config
        poses = np.array([h.estimate.pose.as_array() for h in moved])
        known = np.linalg.inv(np.array([h.estimate.cov for h in moved]))
        prior = Prior(poses, known / (new * c.evidence))
        coarse, fine = (targets_of(views, self._cameras, size, c) for size in (COARSE, FINE))
        near = refine(self._scene, coarse, poses, c, _ROUGH_STEPS, c.fit_color, _LOOSE, prior)
        fits = refine(self._scene, fine, near.poses, c, _STEPS, c.fit_color, 1.0, prior)
        poses = fits.poses
        if len(poses) > 1:
            poses = polished(self._scene, fine, poses, c)
        costs = judge(self._scene, fine, poses, c)
        covs = [
            covariance(k + new * c.evidence * h, c)
            for k, h in zip(known, fits.hessians, strict=True)
        ]
        shares = np.log(np.maximum([h.share for h in moved], c.least_share))
        found = hypotheses_of(poses, covs, costs, shares - new * c.evidence * costs, c)
        return judged(found, known_part(fine), c)


def newness(motion: SE2, config: StereoLocalizerConfig) -> float:
    """Return how much of a new view there is after a motion, above 0 to 1."""
    way = motion.distance / config.new_view_m + abs(motion.yaw) / config.new_view_rad
    return max(_LEAST_NEW, 1.0 - math.exp(-way))


def motion_covariance(motion: SE2, dt: float, config: StereoLocalizerConfig) -> np.ndarray:
    """Return the covariance of a motion's x, y, yaw by odometry, (3, 3)."""
    share = config.odometry_error
    way = (share * motion.distance) ** 2 + (config.drift_m_s * dt) ** 2 + 1e-8
    turn = (share * motion.yaw) ** 2 + (config.drift_rad_s * dt) ** 2 + 1e-8
    return np.diag([way, way, turn + (0.1 * share * motion.distance) ** 2])
