"""What the stereo localizer says of itself on /diagnostics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.watchdog import Watchdog
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.stamp_groups import StampGroups
from multi_localizer.stereo_pose import StereoPose, StereoState

_SINGLE_AFTER = 3


class StereoReport:
    """Part `stereo pose` of the diagnostics.

    Args:
        watchdogs: Of each pair's disparities, by name.
        outputs: What was sent.
        groups: What is put together.
    """

    def __init__(
        self, watchdogs: dict[str, Watchdog], outputs: LocalizerOutputs, groups: StampGroups
    ) -> None:
        self._watchdogs, self._outputs, self._groups = watchdogs, outputs, groups
        self._ms, self._worst_ms, self._num_views = 0.0, 0.0, 0
        self.forget()

    def forget(self) -> None:
        """Begin anew: the clock was set back."""
        self._pose: StereoPose | None = None
        self._refusal, self._singles, self._seen = "", 0, ()

    @property
    def is_fresh(self) -> bool:
        """Whether disparities of any pair came of late."""
        return any(watchdog.is_fresh for watchdog in self._watchdogs.values())

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose now."""
        is_known = self._pose is not None and self._pose.state is StereoState.KNOWN
        return not self.is_fresh or bool(self._problem) or not is_known

    def note(self, pose: StereoPose, seen: Sequence[str], ms: float) -> None:
        """Note what came of a moment, which pairs it was from, and the time it took."""
        self._pose, self._seen, self._ms = pose, tuple(seen), ms
        self._worst_ms = max(self._worst_ms, ms)
        self._num_views += 1
        self._refusal, self._singles = "", 0

    def note_single(self) -> None:
        """Note a moment of which no pair is whole."""
        self._singles += 1

    def refuse(self, why: str) -> None:
        """Note input that cannot be used."""
        self._refusal, self._singles = why, 0

    @property
    def _problem(self) -> str:
        if self._singles >= _SINGLE_AFTER:
            return "disparities and left images have different stamps"
        return self._refusal

    def status(self) -> Status:
        """Return whether the pose is known, or why not."""
        values = self._values()
        if not self.is_fresh:
            return Status(STALE, "no disparities: no pose is sent", values)
        if self._problem:
            return Status(ERROR, f"no pose is sent: {self._problem}", values)
        if self._pose is None:
            return Status(STALE, "nothing seen yet", values)
        if self._pose.state is StereoState.LOST:
            return Status(ERROR, f"lost: {self._pose.reason}", values)
        if self._pose.state is StereoState.AMBIGUOUS:
            return Status(WARN, f"no pose is sent: {self._pose.reason}", values)
        silent = [name for name, dog in self._watchdogs.items() if not dog.is_fresh]
        if silent:
            text = f"the pose is known, but by {', '.join(self._seen)} alone: no disparities of "
            return Status(WARN, text + ", ".join(silent), values)
        return Status(OK, "the pose is known", values)

    def _values(self) -> dict[str, object]:
        values: dict[str, object] = {
            "moments": self._num_views,
            "poses sent": self._outputs.num_sent,
            "came too late": self._groups.num_late,
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
