"""Errors of distance in cm, as the stereo paper's Table 1 has them."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from multi_localizer.stereo_fill import fill_from_farther

REACH_PX, CHANGE_M = 8, 0.32
PAPER = {
    "interval_dp": {"mean_cm": 17.90, "changing_cm": 33.90, "smooth_cm": 17.58},
    "monotone_dp": {"mean_cm": 19.85, "changing_cm": 69.00, "smooth_cm": 18.83},
}


def changing(depth: np.ndarray) -> np.ndarray:
    """Return where the distance changes by 32 cm or more within 8 px to the left and right."""
    row = np.ones((1, 2 * REACH_PX + 1), dtype=np.uint8)
    exact = depth.astype(np.float64)
    return np.asarray(cv2.dilate(exact, row) - cv2.erode(exact, row) >= CHANGE_M)


def depth_of(
    disparities: np.ndarray, focal_px: float, baseline_m: float, farthest_m: float
) -> np.ndarray:
    """Return distances, (H, W), m; holes are filled from the farther neighbor.

    Nothing is farther than `farthest_m`: where the disparity says so, or there is none at all, that
    is the answer.
    """
    filled = np.nan_to_num(fill_from_farther(disparities).astype(float), nan=0.0)
    least = focal_px * baseline_m / farthest_m
    return focal_px * baseline_m / np.maximum(filled, least)


@dataclass
class DepthErrors:
    """Sums of errors over views; all pixels count alike."""

    sums: dict[str, float] = field(default_factory=lambda: dict.fromkeys(("changing", "smooth"), 0))
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(("changing", "smooth"), 0))
    num_valid: int = 0

    def add(self, disparities: np.ndarray, found: np.ndarray, depth: np.ndarray) -> None:
        """Take a view: its disparities, the distances made of them, and the true ones."""
        errors, is_changing = np.abs(found - depth), changing(depth)
        for name, chosen in (("changing", is_changing), ("smooth", ~is_changing)):
            self.sums[name] += float(errors[chosen].sum())
            self.counts[name] += int(chosen.sum())
        self.num_valid += int(np.count_nonzero(~np.isnan(disparities)))

    def as_dict(self) -> dict[str, float | None]:
        """Return `mean_cm`, `changing_cm`, `smooth_cm`, and the percentages of valid pixels."""
        total = sum(self.counts.values())

        def mean(names: tuple[str, ...]) -> float | None:
            count = sum(self.counts[n] for n in names)
            return 100.0 * sum(self.sums[n] for n in names) / count if count else None

        return {
            "mean_cm": mean(("changing", "smooth")), "changing_cm": mean(("changing",)),
            "smooth_cm": mean(("smooth",)),
            "valid": 100.0 * self.num_valid / total if total else None,
        }  # fmt: skip

    @property
    def changing_share(self) -> float | None:
        """Percentage of pixels in regions that change strongly."""
        total = sum(self.counts.values())
        return 100.0 * self.counts["changing"] / total if total else None
