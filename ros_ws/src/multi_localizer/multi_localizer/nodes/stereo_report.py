"""What the stereo localizer says of itself on /diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.watchdog import Watchdog
from multi_localizer.newest_worker import NewestWorker
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.nodes.stereo_view_input import LEFT
from multi_localizer.stamp_groups import StampGroups
from multi_localizer.stereo_pose import StereoPose, StereoState

_SINGLE_AFTER = 3


class StereoReport:
    """Part `stereo pose` of the diagnostics.

    Args:
        watchdogs: Of each pair's disparities, by name.
        outputs: What was sent.
        groups: What is put together.
        worker: Who looks for the pose.
        doing: Returns what takes seconds just now, or "".
    """

    def __init__(
        self,
        watchdogs: dict[str, Watchdog],
        outputs: LocalizerOutputs,
        groups: StampGroups,
        worker: NewestWorker,
        doing: Callable[[], str],
    ) -> None:
        self._watchdogs, self._outputs, self._groups = watchdogs, outputs, groups
        self._worker, self._doing = worker, doing
        self._ms, self._worst_ms, self._num_views = 0.0, 0.0, 0
        self.forget()

    def forget(self) -> None:
        """Begin anew: the clock was set back."""
        self._pose: StereoPose | None = None
        self._refusal, self._singles, self._seen = "", 0, ()
        self._alone: set[str] = set()
        self._late_before = 0

    @property
    def is_fresh(self) -> bool:
        """Whether disparities of any pair came of late."""
        return any(watchdog.is_fresh for watchdog in self._watchdogs.values())

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose now, nor odometry to carry the last one."""
        states = StereoState.KNOWN, StereoState.BRIDGED
        is_known = self._pose is not None and self._pose.state in states
        return not self.is_fresh or bool(self._problem) or not is_known

    def note(self, pose: StereoPose, seen: Sequence[str], ms: float) -> None:
        """Note what came of a moment, which pairs it was from, and the time it took."""
        self._pose, self._seen, self._ms = pose, tuple(seen), ms
        self._worst_ms = max(self._worst_ms, ms)
        self._num_views += 1
        self._refusal, self._singles = "", 0

    def note_single(self, parts: Iterable[str]) -> None:
        """Note a moment of which no pair is whole, and what there is of it."""
        if self._singles == 0:
            self._alone, self._late_before = set(), self._groups.num_parted
        self._singles += 1
        self._alone.update(parts)

    def refuse(self, why: str) -> None:
        """Note input that cannot be used."""
        self._refusal, self._singles = why, 0

    @property
    def _problem(self) -> str:
        return self._why_single if self._singles >= _SINGLE_AFTER else self._refusal

    @property
    def _why_single(self) -> str:
        """Why no pair is whole: one side is not there, is late, or is of another camera run."""
        if not any(part.endswith(f"/{LEFT}") for part in self._alone):
            return f"no left images come beside the disparities of {', '.join(self._watchdogs)}"
        if self._groups.num_parted > self._late_before:
            return "the machine is too slow: disparities come too late for their left images"
        return "disparities and left images have different stamps"

    def status(self) -> Status:
        """Return whether the pose is known, or why not."""
        values = self._values()
        if not self.is_fresh:
            return Status(STALE, "no disparities: no pose is sent", values)
        if self._problem:
            return Status(ERROR, f"no pose is sent: {self._problem}", values)
        if self._pose is None:
            return Status(STALE, self._doing() or "nothing seen yet", values)
        if self._pose.state is StereoState.LOST:
            return Status(ERROR, f"lost: {self._pose.reason}", values)
        if self._pose.state is StereoState.AMBIGUOUS:
            return Status(WARN, f"no pose is sent: {self._pose.reason}", values)
        if self._pose.state is StereoState.BRIDGED:
            text = f"no pose is sent, it goes on by odometry alone: {self._pose.reason}"
            return Status(WARN, text, values)
        if self._pose.reason:
            return Status(WARN, f"the pose is known, but {self._pose.reason}", values)
        silent = [name for name, dog in self._watchdogs.items() if not dog.is_fresh]
        alone = [name for name in self._seen if name not in silent]
        if silent and alone:
            text = f"the pose is known, but by {', '.join(alone)} alone: no disparities of "
            return Status(WARN, text + ", ".join(silent), values)
        return Status(OK, "the pose is known", values)

    def _values(self) -> dict[str, object]:
        values: dict[str, object] = {
            "moments": self._num_views,
            "poses sent": self._outputs.num_sent,
            "came too late": self._groups.num_late,
            "passed over": self._worker.num_passed_over,
            "pairs seen": ", ".join(self._seen),
            "processing (ms)": f"{self._ms:.1f}",
            "longest processing (ms)": f"{self._worst_ms:.1f}",
        }
        if self._pose is not None and self._pose.hypotheses:
            best = self._pose.hypotheses[0]
            pose, deviation = best.estimate.pose, np.sqrt(np.diag(best.estimate.cov))
            values["state"] = self._pose.state.value
            values["poses that fit"] = len(self._pose.hypotheses)
            values["belief in the best"] = f"{best.share:.3f}"
            values["best x, y (m), yaw (deg)"] = (
                f"{pose.x:.3f}, {pose.y:.3f}, {math.degrees(pose.yaw):.1f}"
            )
            values["deviation x, y (mm), yaw (deg)"] = (
                f"{1e3 * deviation[0]:.1f}, {1e3 * deviation[1]:.1f}, "
                f"{math.degrees(deviation[2]):.2f}"
            )
            values["unlike the map"] = f"{best.score:.4f}"
        return values
