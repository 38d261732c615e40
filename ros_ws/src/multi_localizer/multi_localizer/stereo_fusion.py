"""A pose carried by odometry and the pose that a view wants, put together.

Views from nearly the same place have nearly the same errors: those of the map, and of matching the
same texture. What of a view is new adds to what was known; the rest of it can only take its place,
as covariance intersection has it, so that looking on from one place never makes a pose surer than
one look does. The less was known the more of it is replaced.

Where the view wants another pose than the motion allows, the motion is not believed: wheels slip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_hypotheses import WIDEST, least_covariance
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig


@dataclass(frozen=True, eq=False)
class Fused:
    """A pose by motion and view.

    Attributes:
        estimate: The pose.
        gap: Covariance of what the motion is wrong by, (3, 3); 0 while the two agree.
    """

    estimate: PoseEstimate
    gap: np.ndarray


def fused(
    before: PoseEstimate, pull: np.ndarray, hessian: np.ndarray, new: float, dt: float,
    config: StereoLocalizerConfig,
) -> Fused:  # fmt: skip
    """Return the pose after a view.

    Args:
        before: Where the motion has it.
        pull: The view's information times how far from there it wants the pose, (3,).
        hessian: The view's information, (3, 3).
        new: Share of the view that is new, 0 to 1.
        dt: Time since the view before, s.
        config: Times and limits.
    """
    c = config
    view = hessian + np.eye(3) / WIDEST**2
    wanted = np.linalg.solve(view, pull)
    apart = float(wanted @ np.linalg.solve(before.cov + np.linalg.inv(view), wanted))
    gap = max(0.0, 1.0 - c.slip_sd**2 / max(apart, 1e-9)) * np.outer(wanted, wanted)
    cov = before.cov + gap
    known = np.linalg.inv(cov)
    renewed = 1.0 - math.exp(-dt / c.renewal_s)
    odds = renewed / max(1.0 - renewed, 1e-9) * float(np.trace(cov @ view)) / 3.0
    gain = max(new, odds / (1.0 + odds))
    information = (1.0 - gain + new) * known + gain * view
    x, y, yaw = np.linalg.solve(information, gain * view @ wanted).tolist()
    pose = SE2(before.pose.x + x, before.pose.y + y, before.pose.yaw + yaw)
    cov = np.linalg.inv(information) + least_covariance(c) + gap
    return Fused(PoseEstimate(pose, 0.5 * (cov + cov.T)), gap)
