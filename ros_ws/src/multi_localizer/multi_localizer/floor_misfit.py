"""Whether masks fit the plan as badly as those of another floor, or of another camera, would.

One mask may fit badly because much is hidden. If nearly all do for seconds, plan or camera are in
doubt: a wrong one often fits somewhere, with a border that scatters, or lies off as a whole.
"""

from __future__ import annotations

from collections import deque

from multi_localizer.floor_fitter import FloorFit

WINDOW_NS, MIN_MASKS = 5_000_000_000, 10
MOST, LEAST = 0.8, 0.5  # share of odd masks that raises doubt, and that ends it
# Over 500 masks of the right plan and camera, up to 40 % hidden: 0.45 px, 0.9 px, 0.57.
ODD_RMS_PX, ODD_OFFSET_PX, ODD_COST = 0.55, 1.5, 0.55
ODD_BEHIND = 0.08  # of the cost that is left out because it lies behind walls
LIKELY = (
    "`plan` is of another floor, `camera_model` is another camera's (its mirror, center, height), "
    "or more than half of the border is hidden"
)


class FloorMisfit:
    """Looks at the fits of some seconds.

    Attributes:
        reason: What fits badly and what may be wrong; "" if all is well.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget what was seen."""
        self.reason = ""
        self._seen: deque[tuple[int, str]] = deque()

    def note(self, stamp_ns: int, fit: FloorFit) -> None:
        """Take the fit of a mask; one that shows no border at all says nothing."""
        if self._seen and stamp_ns < self._seen[-1][0]:
            self.clear()  # time has jumped back
        if fit.num_points == 0:
            return
        self._seen.append((stamp_ns, oddness(fit)))
        if stamp_ns - self._seen[0][0] < WINDOW_NS:
            return
        while stamp_ns - self._seen[1][0] >= WINDOW_NS:
            self._seen.popleft()
        self._judge()

    def _judge(self) -> None:
        odd = [what for _, what in self._seen if what]
        share = len(odd) / len(self._seen)
        if len(self._seen) >= MIN_MASKS and share >= MOST:
            often = max(sorted(set(odd)), key=odd.count)
            self.reason = f"for {WINDOW_NS // 10**9} s {often}: {LIKELY}"
        elif share < LEAST:
            self.reason = ""


def oddness(fit: FloorFit) -> str:
    """Return in words what a fit of the right plan and camera hardly shows; "" for nothing."""
    if fit.problem:
        return "masks have fitted no pose on the plan"
    if abs(fit.offset_px) > ODD_OFFSET_PX:
        return "the border has lain beside the walls all around"
    if fit.residual_px > ODD_RMS_PX:
        return "the border has scattered about the walls"
    cost = max(fit.costs[:1], default=0.0)
    if fit.first_cost - cost > ODD_BEHIND:
        return "floor has been seen behind the plan's walls"
    return "little of the border has fitted the plan" if cost > ODD_COST else ""
