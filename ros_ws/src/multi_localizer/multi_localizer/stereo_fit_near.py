"""Where views fit best near poses that are expected, and how much they say there.

The cost of a view has hills, and who follows may be left on the wrong side of one: the views then
fit much worse than they did all the time. So if they do, the likeliest pose is begun anew all
around; and as long as they do, be it for people before the cameras, they say less.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multi_localizer.stereo_judge import judge
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_locator import COARSE, FINE, scattered
from multi_localizer.stereo_pose import StereoHypothesis
from multi_localizer.stereo_refine import Fits, Prior, Target, refine, targets_of
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_view import ViewCamera, VoxelScene

SLACK = np.diag([0.1, 0.1, 0.1]) ** 2
"""Covariance, m and rad, by which fits are drawn to where the motion has them: hardly."""
_LOOSE, _ROUGH_STEPS, _STEPS = 3.0, 2, 3
_LESS_LOOSE, _AROUND_STEPS, _NUM_AROUND = 2.0, 5, 2
_WORSE, _WORSE_BY, _USUAL_S = 1.3, 0.02, 5.0


@dataclass(frozen=True, eq=False)
class NearFits:
    """Fits near poses.

    Attributes:
        fine: What was seen, as poses are judged by it.
        fits: One for each pose.
        evidence: What their Hessians count, so that they are information.
    """

    fine: list[Target]
    fits: Fits
    evidence: float


class FitNear:
    """Fits views near poses, and knows how well they usually fit.

    Args:
        scene: The map.
        cameras: One for each pair.
        config: Scales and times.
    """

    def __init__(
        self, scene: VoxelScene, cameras: Sequence[ViewCamera], config: StereoLocalizerConfig
    ) -> None:
        self._scene, self._cameras, self.config = scene, tuple(cameras), config
        self.begin(1.0)

    def begin(self, cost: float) -> None:
        """Take a cost of views as usual."""
        self._usual, self._since_around_s = cost, math.inf

    def fit(
        self, views: Sequence[StereoView | None], expected: Sequence[StereoHypothesis]
    ) -> NearFits:
        """Return where the views fit best near poses, the likeliest first, almost by themselves."""
        c = self.config
        poses = np.array([h.estimate.pose.as_array() for h in expected])
        known = np.linalg.inv(np.array([h.estimate.cov for h in expected]) + SLACK)
        prior = Prior(poses, known / c.evidence)
        coarse, fine = (targets_of(views, self._cameras, size, c) for size in (COARSE, FINE))
        near = refine(self._scene, coarse, poses, c, _ROUGH_STEPS, c.fit_color, _LOOSE, prior)
        fits = refine(self._scene, fine, near.poses, c, _STEPS, c.fit_color, 1.0, prior)
        return NearFits(fine, fits, c.evidence)

    def doubted(self, near: NearFits, cost: float, dt: float) -> NearFits | None:
        """Return fits to be taken instead, where these cost much more than usual; else None.

        Args:
            near: Fits.
            cost: Mean cost of a pixel at the likeliest pose, as `judge` has it.
            dt: Time since the views before, s.
        """
        c, most = self.config, _WORSE * self._usual + _WORSE_BY
        self._since_around_s += dt
        if cost <= most:
            return None
        fits = near.fits
        if self._since_around_s >= c.locate_period_s:
            fits, cost = self._looked_around(near.fine, fits)
        return NearFits(near.fine, fits, c.evidence * min(1.0, most / max(cost, 1e-9)) ** 2)

    def note(self, cost: float, dt: float) -> None:
        """Take a cost into what is usual: a lower one at once, a higher one in time."""
        worse = cost - self._usual
        self._usual += worse if worse < 0.0 else worse * -math.expm1(-dt / _USUAL_S)

    def _looked_around(self, fine: list[Target], fits: Fits) -> tuple[Fits, float]:
        """Return the fits, that of the likeliest pose begun anew if that is better; its cost."""
        c = self.config
        self._since_around_s = 0.0
        around = scattered(fits.poses[:1])
        rough = refine(self._scene, fine, around, c, _AROUND_STEPS, c.fit_color, _LESS_LOOSE)
        order = np.argsort(judge(self._scene, fine, rough.poses, c))[:_NUM_AROUND]
        again = refine(self._scene, fine, rough.poses[order], c, _STEPS, c.fit_color)
        first = fits.part(slice(1)).joined(again)
        costs = judge(self._scene, fine, first.poses, c)
        best = int(np.argmin(costs))
        joined = first.part(slice(best, best + 1)).joined(fits.part(slice(1, None)))
        return joined, float(costs[best])
