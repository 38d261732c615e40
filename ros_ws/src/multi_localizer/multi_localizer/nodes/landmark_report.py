"""What the landmark localizer says of itself on /diagnostics."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.watchdog import Watchdog
from floornav_common.time_watch import Deadline
from multi_localizer.landmark_locator import LandmarkFix
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.stamp_groups import StampGroups


class LandmarkReport:
    """Part `landmark pose` of the diagnostics.

    Args:
        node: The node.
        watchdog: That of the bearings.
        outputs: What was sent.
        groups: What is put together.
        timeout_s: Without a view for so long there is no pose.
    """

    def __init__(
        self, node: FloornavNode, watchdog: Watchdog, outputs: LocalizerOutputs,
        groups: StampGroups, timeout_s: float,
    ) -> None:  # fmt: skip
        self._node, self._views = node, Deadline(round(timeout_s * 1e9))
        node.time.on_restart(self._forget)
        self._watchdog, self._outputs, self._groups = watchdog, outputs, groups
        self._fix: LandmarkFix | None = None
        self._seen: dict[str, int] = {}
        self._refusal, self._ms, self._num_views = "", 0.0, 0

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose now."""
        is_known = self._fix is not None and self._fix.estimate is not None
        is_fresh = self._watchdog.is_fresh and not self._has_no_view
        return not is_fresh or bool(self._refusal) or not is_known

    @property
    def _has_no_view(self) -> bool:
        return self._fix is not None and self._views.is_over(self._node.time.read_ns())

    def _forget(self) -> None:
        self._fix, self._refusal = None, ""
        self._views.restart()

    def note(self, fix: LandmarkFix, bearings: Mapping[str, np.ndarray], ms: float) -> None:
        """Note what came of a view, and the time it took."""
        self._fix, self._ms, self._refusal = fix, ms, ""
        self._num_views += 1
        self._views.feed(self._node.time.read_ns())
        self._seen = {kind: len(values) for kind, values in bearings.items()}

    def refuse(self, why: str) -> None:
        """Note input that cannot be used."""
        self._refusal = why
        self._views.feed(self._node.time.read_ns())

    def status(self) -> Status:
        """Return whether the pose is known, or why not."""
        values = self._values()
        if not self._watchdog.is_fresh:
            return Status(STALE, "no bearings: no pose is sent", values)
        if self._has_no_view:
            why = "no moment of the bearings is whole, or their stamps were set back"
            return Status(STALE, f"no pose is sent: {why}", values)
        if self._refusal:
            return Status(ERROR, f"no pose is sent: {self._refusal}", values)
        if self._fix is None:
            return Status(STALE, "nothing seen yet", values)
        if self._fix.problem:
            return Status(ERROR, f"no pose is sent: {self._fix.problem}", values)
        if self._fix.note:
            return Status(WARN, f"the pose is known, but {self._fix.note}", values)
        return Status(OK, "the pose is known", values)

    def _values(self) -> dict[str, object]:
        values: dict[str, object] = {
            "views": self._num_views,
            "poses sent": self._outputs.num_sent,
            "came too late": self._groups.num_late,
            "processing (ms)": f"{self._ms:.2f}",
        }
        if self._fix is not None:
            values["landmarks used"] = self._fix.num_used
            values["landmarks left out"] = self._fix.num_left_out
            if self._fix.note:
                values["left out before"] = self._fix.note
            if self._fix.estimate is not None:
                x, y, yaw = np.sqrt(np.diag(self._fix.estimate.cov))
                values["deviation x, y (mm), yaw (deg)"] = (
                    f"{1e3 * x:.0f}, {1e3 * y:.0f}, {math.degrees(yaw):.2f}"
                )
        values.update({f"{kind} seen": num for kind, num in self._seen.items()})
        return values
