"""Whether a pose by landmarks follows from those before and the motion: several views confirm it.

A false bearing among four gives way too often to be seen in one view. A wrong pose seldom comes
again where odometry says that the right one would: so none is given before some views, one after
the other, have shown it, and later only what follows from it. What a false thing that stands still
makes of a robot that stands still no time can tell.

Where poses fit alike the known one tells which is right, but only while it is known well: unseen
for some time, or contradicted by views, the robot may have been carried or pushed round, and its
mate may stand where the motion has it. Then only a view that no other pose fits settles it again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from floornav_common.se2 import SE2
from multi_localizer.floor_motion import motion_between
from multi_localizer.landmark_config import LandmarkTrackConfig
from multi_localizer.pose_estimate import PoseEstimate, mahalanobis, propagate

_S = 1_000_000_000
_MOST_ELSEWHERE = 1  # views that may have shown other poses than the known one: false bearings


@dataclass(frozen=True)
class Run:
    """Poses that follow from each other.

    Attributes:
        estimate: The newest, moved on to the newest view.
        num: How many views have shown it without one between that did not.
        seen_ns: When it was shown last.
    """

    estimate: PoseEstimate
    num: int
    seen_ns: int


class LandmarkTracker:
    """Keeps poses that may be the robot's.

    Args:
        config: Gates and times; may be replaced while it runs.
    """

    def __init__(self, config: LandmarkTrackConfig) -> None:
        self.config = config
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._known: Run | None = None
        self._runs: list[Run] = []
        self._num_elsewhere = 0
        self._stamp_ns: int | None = None
        self._T_odom_base: SE2 | None = None

    def expected(self, stamp_ns: int, T_odom_base: SE2 | None) -> PoseEstimate | None:
        """Return where the robot should be at a moment; None if that may tell no poses apart."""
        known = self._known
        if known is None or self._num_elsewhere > _MOST_ELSEWHERE:
            return None
        if stamp_ns - known.seen_ns > self.config.lost_after_s * _S:
            return None  # by now somebody may have carried it
        return self._moved(known, stamp_ns, T_odom_base)

    def update(
        self,
        stamp_ns: int,
        estimate: PoseEstimate | None,
        T_odom_base: SE2 | None,
        is_elsewhere: bool = False,
    ) -> str:
        """Take what a view gives; return why it is not to be given, "" if it is.

        Args:
            stamp_ns: Of the view.
            estimate: Of base_link; None if the view gives none.
            T_odom_base: Where odometry has the robot then; None without odometry.
            is_elsewhere: Whether the view is of poses, but of none near the expected one.
        """
        self._go_on(stamp_ns, T_odom_base)
        self._num_elsewhere += is_elsewhere
        if estimate is None:
            self._runs = []
            return ""
        if self._known is not None and self._is_one(self._known.estimate, estimate):
            self._settle(Run(estimate, self._known.num + 1, stamp_ns))
            return ""
        run = self._continued(estimate, stamp_ns)
        if not self._is_believed(run, stamp_ns):
            self._runs = [run]
            return self._why_not(run)
        self._settle(run)
        return ""

    def _settle(self, known: Run) -> None:
        self._known, self._runs, self._num_elsewhere = known, [], 0

    def _continued(self, estimate: PoseEstimate, stamp_ns: int) -> Run:
        before = [r.num for r in self._runs if self._is_one(r.estimate, estimate)]
        return Run(estimate, max(before, default=0) + 1, stamp_ns)

    def _is_believed(self, run: Run, stamp_ns: int) -> bool:
        if run.num < self.config.settle_views:
            return False
        if self._known is None:
            return True
        return stamp_ns - self._known.seen_ns >= self.config.lost_after_s * _S

    def _why_not(self, run: Run) -> str:
        num = self.config.settle_views
        if self._known is None:
            return f"not confirmed yet: {run.num} of {num} views in a row have shown it"
        return "does not follow from the last pose and the motion"

    def _is_one(self, a: PoseEstimate, b: PoseEstimate) -> bool:
        return mahalanobis(a, b) < self.config.gate_sd**2

    def _go_on(self, stamp_ns: int, T_odom_base: SE2 | None) -> None:
        """Move what is known to the moment of a view."""
        if self._stamp_ns is not None and stamp_ns < self._stamp_ns:
            self.clear()  # stamps were set back
        runs = [replace(r, estimate=self._moved(r, stamp_ns, T_odom_base)) for r in self._runs]
        self._runs = runs
        known = self._known
        if known is not None and stamp_ns - known.seen_ns > self.config.forget_s * _S:
            known = None
        if known is not None:
            known = replace(known, estimate=self._moved(known, stamp_ns, T_odom_base))
        self._known, self._stamp_ns, self._T_odom_base = known, stamp_ns, T_odom_base

    def _moved(self, run: Run, stamp_ns: int, T_odom_base: SE2 | None) -> PoseEstimate:
        if self._stamp_ns is None:
            return run.estimate
        dt = (stamp_ns - self._stamp_ns) / _S
        motion, cov = motion_between(self._T_odom_base, T_odom_base, abs(dt), self.config)
        return propagate(run.estimate, motion, cov)
