"""What the stereo localizer says: a pose, how sure it is, and which other poses it may be."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate


class StereoState(Enum):
    """How much is known of the pose.

    `BRIDGED`: known a moment ago; the views do not fit near it, and it is carried by odometry.
    """

    LOST = "lost"
    BRIDGED = "bridged"
    AMBIGUOUS = "ambiguous"
    KNOWN = "known"


@dataclass(frozen=True)
class StereoHypothesis:
    """A pose that may be the robot's.

    Attributes:
        estimate: The pose of base_link and its covariance.
        share: Of the belief, 0 to 1.
        score: How unlike the views are there; the method's own scale, less is better.
    """

    estimate: PoseEstimate
    share: float
    score: float


@dataclass(frozen=True)
class StereoPose:
    """Where the robot is.

    Attributes:
        state: Whether that is known.
        hypotheses: Poses that may be the robot's, the likeliest first; empty if there is none.
        reason: Why the pose is not known; "" if it is.
    """

    state: StereoState
    hypotheses: tuple[StereoHypothesis, ...]
    reason: str = ""

    @property
    def pose(self) -> SE2 | None:
        """The likeliest pose of base_link, known or not; None if there is none."""
        return self.hypotheses[0].estimate.pose if self.hypotheses else None

    @property
    def cov(self) -> np.ndarray | None:
        """Covariance of the likeliest pose, (3, 3); None if there is none."""
        return self.hypotheses[0].estimate.cov if self.hypotheses else None

    @property
    def score(self) -> float | None:
        """How unlike the views are at the likeliest pose; None if there is none."""
        return self.hypotheses[0].score if self.hypotheses else None
