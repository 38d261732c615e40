"""What the floor localizer says of itself on /diagnostics."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.watchdog import Watchdog
from multi_localizer.floor_localizer import FloorLocalizer
from multi_localizer.floor_tracker import TrackState
from multi_localizer.goal_evidence import GoalsSeen
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs


class FloorReport:
    """Part `floor pose` of the diagnostics.

    Args:
        localizer: Whose state it is.
        watchdog: That of the masks.
        outputs: What was sent.
    """

    def __init__(
        self, localizer: FloorLocalizer, watchdog: Watchdog, outputs: LocalizerOutputs
    ) -> None:
        self._localizer, self._watchdog, self._outputs = localizer, watchdog, outputs
        self._num_masks, self._ms, self._worst_ms = 0, 0.0, 0.0
        self._refusal = ""
        self._goals: dict[str, int] = {}

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose now: no masks, or none that is known."""
        is_known = self._localizer.tracker.state is TrackState.KNOWN
        return not self._watchdog.is_fresh or bool(self._refusal) or not is_known

    def note_mask(self, ms: float) -> None:
        """Note a mask and the time it took."""
        self._watchdog.feed()
        self._num_masks += 1
        self._ms, self._worst_ms, self._refusal = ms, max(self._worst_ms, ms), ""

    def note_goals(self, seen: GoalsSeen) -> None:
        """Note how many goals of a class are seen, and what is no number among them."""
        self._goals[seen.kind] = int(np.isfinite(seen.bearings).sum())
        num_void = len(seen.bearings) - self._goals[seen.kind]
        self._goals[f"{seen.kind}, no numbers"] = num_void

    def refuse(self, why: str) -> None:
        """Note a mask that cannot be used."""
        self._watchdog.refuse(why)
        self._refusal = why

    def status(self) -> Status:
        """Return whether the pose is known, or why not."""
        tracker, values = self._localizer.tracker, self._values()
        if not self._watchdog.is_fresh:
            return Status(STALE, "no masks of the floor: no pose is sent", values)
        if self._refusal:
            return Status(ERROR, f"the mask is refused: {self._refusal}", values)
        doubt = self._localizer.misfit.reason
        if tracker.state is TrackState.LOST:
            why = f"{tracker.reason}; {doubt}" if doubt else tracker.reason
            return Status(ERROR, f"lost: {why}", values)
        if tracker.state is TrackState.OPEN:
            return Status(WARN, f"no pose is sent: {tracker.reason}", values)
        if doubt:
            return Status(WARN, f"the pose is known, but may be wrong: {doubt}", values)
        return Status(OK, "the pose is known", values)

    def _values(self) -> dict[str, object]:
        tracker = self._localizer.tracker
        values: dict[str, object] = {
            "state": tracker.state.value,
            "masks": self._num_masks,
            "poses sent": self._outputs.num_sent,
            "poses that fit": len(tracker.hypotheses),
            "carried away": tracker.num_carried,
            "processing (ms)": f"{self._ms:.2f}",
            "longest processing (ms)": f"{self._worst_ms:.2f}",
        }
        if tracker.hypotheses:
            best = tracker.hypotheses[0]
            pose = best.estimate.pose
            values["best x, y (m), yaw (deg)"] = (
                f"{pose.x:.3f}, {pose.y:.3f}, {math.degrees(pose.yaw):.1f}"
            )
            x, y, yaw = np.sqrt(np.diag(best.estimate.cov))
            values["belief in the best"] = f"{best.share:.3f}"
            values["deviation x, y (mm), yaw (deg)"] = (
                f"{1e3 * x:.1f}, {1e3 * y:.1f}, {math.degrees(yaw):.2f}"
            )
        values.update(self._newest_values())
        values.update({f"{kind} seen": num for kind, num in self._goals.items()})
        return values

    def _newest_values(self) -> dict[str, object]:
        """Return what the newest mask fits."""
        fit = self._localizer.newest
        values: dict[str, object] = {}
        if fit is not None:
            values["border pixels on walls"] = fit.num_points
            values["residual (px)"] = f"{fit.residual_px:.2f}"
            values["hidden (share)"] = f"{fit.hidden_share:.2f}"
            behind = max(0.0, fit.first_cost - max(fit.costs[:1], default=0.0))
            values["floor behind walls (weighted share)"] = f"{behind:.2f}"
            values["border inside the walls (px)"] = f"{fit.offset_px:.2f}"
        if self._localizer.size_doubt:
            values["size of the masks"] = self._localizer.size_doubt
        return values
