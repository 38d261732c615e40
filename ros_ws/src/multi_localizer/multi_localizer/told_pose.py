"""What somebody says of where the robot is, until there are poses to choose among."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multi_localizer.pose_estimate import PoseEstimate, difference, mahalanobis


class ToldPose:
    """Chooses among poses by what somebody said; what is near none of them is not believed.

    Attributes:
        waiting: What was said and not used yet; None if nothing.
    """

    def __init__(self) -> None:
        self.waiting: PoseEstimate | None = None
        self._refusal = ""

    def choose(self, poses: Sequence[PoseEstimate], gate_sd: float) -> np.ndarray | None:
        """Return how likely each of the poses is, (N,); None if nothing is said, or nothing true.

        Args:
            poses: At least one.
            gate_sd: Deviations that the nearest may be off.
        """
        told, self.waiting = self.waiting, None
        if told is None:
            return None
        off = np.array([mahalanobis(pose, told) for pose in poses])
        if off.min() < gate_sd**2:
            return np.asarray(np.exp(-0.5 * (off - off.min())))
        x, y, yaw = np.abs(difference(poses[int(off.argmin())].pose, told.pose))
        self._refusal = (
            f"none of the {len(off)} poses that fit is where the robot is said to be: the "
            f"nearest is {np.hypot(x, y):.2f} m and {yaw:.2f} rad off"
        )
        return None

    def take_refusal(self) -> str:
        """Return once why what was said is not believed; "" if nothing is to be said."""
        refusal, self._refusal = self._refusal, ""
        return refusal
