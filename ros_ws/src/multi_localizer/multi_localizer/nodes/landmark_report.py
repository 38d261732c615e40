"""What the landmark localizer says of itself on /diagnostics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.watchdog import Watchdog
from floornav_common.time_watch import Deadline
from multi_localizer.landmark_localizer import LandmarkAnswer
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.stamp_groups import StampGroups

HELD_NS = 500_000_000
"""A pose sent counts for so long: a view without one between others is no news."""


class LandmarkReport:
    """Part `landmark pose` of the diagnostics.

    Args:
        node: The node.
        watchdog: That of the bearings.
        outputs: What was sent.
        groups: What is put together.
        timeout_s: Without a view for so long there is no pose.
        kinds: Classes of landmarks that are listened for.
    """

    def __init__(
        self, node: FloornavNode, watchdog: Watchdog, outputs: LocalizerOutputs,
        groups: StampGroups, timeout_s: float, kinds: Sequence[str],
    ) -> None:  # fmt: skip
        self._node, self._views = node, Deadline(round(timeout_s * 1e9))
        node.time.on_restart(self._forget)
        self._watchdog, self._outputs, self._groups = watchdog, outputs, groups
        self._answer: LandmarkAnswer | None = None
        self._held = Deadline(HELD_NS)
        self._masks: Watchdog | None = None
        self._refusal, self._ms, self._num_views = "", 0.0, 0
        self._timeout_s, self._kinds = timeout_s, ", ".join(kinds)

    def watch_masks(self, topic: str) -> None:
        """Begin to look for masks of the floor."""
        self._masks = Watchdog(self._node, topic, self._timeout_s)

    def note_mask(self) -> None:
        """Note a mask of the floor."""
        if self._masks is not None:
            self._masks.feed()

    def refuse_mask(self, why: str) -> None:
        """Note a mask that cannot be used."""
        if self._masks is not None:
            self._masks.refuse(why)
            self.refuse(f"{self._masks.topic}: {why}")

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose now."""
        is_fresh = self._watchdog.is_fresh and not self._has_no_view
        return not is_fresh or bool(self._refusal) or not self._is_held

    @property
    def _is_held(self) -> bool:
        return self._held.has_heard and not self._held.is_over(self._node.time.read_ns())

    @property
    def _has_no_view(self) -> bool:
        return self._answer is not None and self._views.is_over(self._node.time.read_ns())

    def _forget(self) -> None:
        self._answer, self._refusal = None, ""
        self._views.restart()
        self._held = Deadline(HELD_NS)

    def note(self, answer: LandmarkAnswer, ms: float) -> None:
        """Note what came of a view, and the time it took."""
        self._answer, self._ms, self._refusal = answer, ms, ""
        self._num_views += 1
        self._views.feed(self._node.time.read_ns())
        if answer.pose is not None:
            self._held.feed(self._node.time.read_ns())

    def refuse(self, why: str) -> None:
        """Note input that cannot be used."""
        self._refusal = why
        self._views.feed(self._node.time.read_ns())

    def status(self) -> Status:
        """Return whether the pose is known, or why not."""
        values = self._values()
        if not self._watchdog.is_fresh:
            why = f"no pose is sent; `landmarks` has {self._kinds}"
            return Status(STALE, f"no bearings: {why}", values)
        if self._has_no_view:
            why = "no moment of the bearings is whole, or their stamps were set back"
            return Status(STALE, f"no pose is sent: {why}", values)
        if self._refusal:
            return Status(ERROR, f"no pose is sent: {self._refusal}", values)
        if self._answer is None:
            return Status(STALE, f"nothing seen yet{self._without_masks()}", values)
        problem = self._answer.fix.problem
        if not self._is_held and (problem or self._answer.why_not):
            why = f"{problem or self._answer.why_not}{self._without_masks()}"
            return Status(ERROR if problem else WARN, f"no pose is sent: {why}", values)
        note = self._answer.fix.note
        if note and not problem:
            return Status(WARN, f"the pose is known, but {note}", values)
        if self._without_masks():
            return Status(WARN, f"the pose is known, but by bearings alone{self._without_masks()}",
                          values)  # fmt: skip
        return Status(OK, "the pose is known", values)

    def _without_masks(self) -> str:
        """Return in words that masks are waited for; "" if they come, or are not asked for."""
        if self._masks is None or self._masks.is_fresh:
            return ""
        return f"; no distances without {self._masks.topic}: {self._masks.status().message}"

    def _values(self) -> dict[str, object]:
        values: dict[str, object] = {
            "views": self._num_views,
            "poses sent": self._outputs.num_sent,
            "came too late": self._groups.num_late,
            "processing (ms)": f"{self._ms:.2f}",
        }
        if self._answer is not None:
            fix = self._answer.fix
            values["landmarks used"], values["bearings left out"] = fix.num_used, len(fix.left_out)
            if fix.left_out:
                values["left out, and why"] = "; ".join(fix.left_out)
            newest = fix.problem or self._answer.why_not
            if newest:
                values["newest view gives no pose"] = newest
            if fix.note:
                values["left out before"] = fix.note
            if fix.estimate is not None:
                x, y, yaw = np.sqrt(np.diag(fix.estimate.cov))
                values["deviation x, y (mm), yaw (deg)"] = (
                    f"{1e3 * x:.0f}, {1e3 * y:.0f}, {math.degrees(yaw):.2f}"
                )
            values.update({f"{kind} seen": num for kind, num in self._answer.num_seen.items()})
        return values
