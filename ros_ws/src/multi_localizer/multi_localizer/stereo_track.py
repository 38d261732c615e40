"""The pose from view to view: poses that may be the robot's carried by odometry and fitted anew.

What the paper names as the remedy for places that look alike, the pose before (section 4). All
poses that may be the robot's are kept; each is fitted to the views near where the motion has it,
and the two are put together (`stereo_fusion`). Those whose views cost more lose belief, the more
the farther the robot has come since: a view from the same place says nothing new. Where views and
motion contradict each other the motion is not believed for a while. Views that fit nowhere near
(somebody before the cameras, the robot carried away) move nothing, and the pose is bridged by
odometry; if that goes on the robot is lost and looked for in the whole map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference, propagate
from multi_localizer.stereo_fit_near import SLACK, FitNear, NearFits
from multi_localizer.stereo_fusion import Fused, fused
from multi_localizer.stereo_hypotheses import hypotheses_of, judged
from multi_localizer.stereo_judge import doubts, judge, known_part, polished
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_motion import NewView, motion_covariance
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.stereo_refine import Target
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_view import ViewCamera, VoxelScene

_SLIP_M = 0.02  # so much slip is worth a word


class Locate(Protocol):
    """Finds a robot without a guess, or near where somebody says it is."""

    def __call__(
        self, views: Sequence[StereoView | None], near: PoseEstimate | None = None
    ) -> StereoPose:
        """Return the pose by one view of each pair, None where one is missing."""


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
        self._new = NewView(config)
        self._near = FitNear(scene, cameras, config)
        self.reset()

    def reset(self) -> None:
        """Forget where the robot is."""
        self._hypotheses: tuple[StereoHypothesis, ...] = ()
        self._told: PoseEstimate | None = None
        self._refusal = ""
        self._strange_s, self._since_locate_s = 0.0, math.inf
        self._slip = np.zeros((3, 3))

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; the pose stays."""
        self._config = self._new.config = self._near.config = config

    def relocate(self, told: PoseEstimate) -> None:
        """Look for the robot, with the next views, where somebody says that it is."""
        self._told = told

    def take_refusal(self) -> str:
        """Return once why a told pose was not believed; "" if nothing is to be said."""
        refusal, self._refusal = self._refusal, ""
        return refusal

    def update(
        self, views: Sequence[StereoView | None], motion: SE2 | None, dt: float
    ) -> StereoPose:
        """Return the pose after a motion; see `StereoLocalizer.track`."""
        self._since_locate_s += dt
        found = self._found_as_told(views)
        if found is not None:
            return found
        if not self._hypotheses:
            return self._look_everywhere(views)
        carried = self._went_on(dt) if motion is None else motion
        self._slip *= math.exp(-dt / self._config.lost_after_s) if self._config.lost_after_s else 0
        cov = motion_covariance(motion, dt, self._config) + self._slip
        moved = [replace(h, estimate=propagate(h.estimate, carried, cov)) for h in self._hypotheses]
        return self._follow(views, moved, carried, dt)

    def _went_on(self, dt: float) -> SE2:
        """Return the motion that goes on as the views showed it last."""
        step, took = self._step
        part = dt / took if took > 0.0 else 0.0
        return SE2(part * step.x, part * step.y, part * step.yaw)

    def _follow(
        self, views: Sequence[StereoView | None], moved: Sequence[StereoHypothesis], carried: SE2,
        dt: float,
    ) -> StereoPose:  # fmt: skip
        new = self._new.share(carried)
        near = self._near.fit(views, moved)
        after, pose = self._put_together(moved, near, new, dt)
        doubted = self._near.doubted(near, pose.hypotheses[0].score, dt)
        if doubted is not None:
            after, pose = self._put_together(moved, doubted, new, dt)
        if pose.state is StereoState.LOST:
            self._step = SE2.identity(), 0.0
            self._new.pass_by(carried)
            return self._bridge(views, moved, pose.reason, dt)
        step = self._hypotheses[0].estimate.pose.inverse() @ after[0].estimate.pose
        self._step = step, dt
        self._new.look(new, step)
        self._hypotheses, self._strange_s = pose.hypotheses, 0.0
        self._near.note(pose.hypotheses[0].score, dt)
        self._slip = self._slip + _isotropic(after[0].gap)
        slip_m = math.sqrt(self._slip[0, 0])
        if pose.state is StereoState.KNOWN and slip_m > _SLIP_M:
            text = f"the views contradict the motion: of late by {100.0 * slip_m:.0f} cm"
            return replace(pose, reason=text)
        return pose

    def _bridge(
        self, views: Sequence[StereoView | None], moved: Sequence[StereoHypothesis], why: str,
        dt: float,
    ) -> StereoPose:  # fmt: skip
        self._hypotheses, self._strange_s = tuple(moved), self._strange_s + dt
        if self._strange_s > self._config.lost_after_s:
            return self._look_everywhere(views)
        return StereoPose(StereoState.BRIDGED, self._hypotheses, f"by odometry alone: {why}")

    def _found_as_told(self, views: Sequence[StereoView | None]) -> StereoPose | None:
        if self._told is None:
            return None
        told, self._told = self._told, None
        found = self._locate(views, told)
        if found.state is not StereoState.LOST:
            return self._begun(found)
        self._refusal = f"nothing in the map fits there: {found.reason}"
        return None

    def _look_everywhere(self, views: Sequence[StereoView | None]) -> StereoPose:
        if self._since_locate_s < self._config.locate_period_s:
            return StereoPose(StereoState.LOST, self._hypotheses, "looked for in the whole map")
        self._since_locate_s = 0.0
        found = self._locate(views)
        return found if found.state is StereoState.LOST else self._begun(found)

    def _begun(self, found: StereoPose) -> StereoPose:
        self._hypotheses, self._strange_s = found.hypotheses, 0.0
        self._step = SE2.identity(), 0.0
        self._slip = np.zeros((3, 3))
        self._new.begin()
        self._near.begin(found.hypotheses[0].score)
        return found

    def _put_together(
        self, moved: Sequence[StereoHypothesis], near: NearFits, new: float, dt: float
    ) -> tuple[list[Fused], StereoPose]:
        after = []
        for hypothesis, pose, hessian in zip(
            moved, near.fits.poses, near.evidence * near.fits.hessians, strict=True
        ):
            before = hypothesis.estimate
            off = difference(SE2(*pose.tolist()), before.pose)
            pull = (hessian + np.linalg.inv(before.cov + SLACK)) @ off
            after.append(fused(before, pull, hessian, new, dt, self._config))
        return after, self._weighed(near.fine, moved, after, new)

    def _weighed(
        self, fine: Sequence[Target], moved: Sequence[StereoHypothesis], after: Sequence[Fused],
        new: float,
    ) -> StereoPose:  # fmt: skip
        c = self._config
        poses = np.array([a.estimate.pose.as_array() for a in after])
        if len(poses) > 1:
            poses = polished(self._scene, fine, poses, c)
        costs = judge(self._scene, fine, poses, c)
        shares = np.log(np.maximum([h.share for h in moved], c.least_share))
        covs = [a.estimate.cov for a in after]
        found = hypotheses_of(poses, covs, costs, shares - new * doubts(costs, c), c)
        return judged(found, known_part(fine), c)


def _isotropic(cov: np.ndarray) -> np.ndarray:
    """Return a covariance that is as wide along x and y, whichever way the robot is turned."""
    way = max(cov[0, 0], cov[1, 1])
    return np.diag([way, way, cov[2, 2]])
