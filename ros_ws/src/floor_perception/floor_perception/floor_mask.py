"""Step 1 of the floor paper: from an image to the floor region, cleaned by opening and closing.

Opening (section 4) takes specks of the floor's color off obstacles; closing (section 3.1) bridges
lines and stains on the floor. A closing with a square of k pixels fills what holds no such square:
k is the width of a mark, in pixels where the floor is seen largest, so every narrower mark is
bridged and whatever is wider, there and anywhere farther out, is not. What the robot hides counts
as floor meanwhile, or a line that runs under the robot would end in it.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from floor_perception.color_table import classify


def closing_px(mark_m: float, px_per_m: float) -> int:
    """Return the kernel, odd, that bridges marks up to a width where the floor is seen largest.

    One pixel more, for the mark's blurred edges; 1, which does nothing, for a width of 0.
    """
    if mark_m == 0.0:
        return 1
    return 2 * math.ceil(0.5 * mark_m * px_per_m) + 1


class FloorMasker:
    """Makes the floor mask of one image after another of the same size.

    Args:
        spans: First and past-last column of each row that may be floor, (H, 2).
        is_used: The pixels that may be floor, (H, W), bool.
        is_robot: The pixels that see the robot where floor would be, (H, W), bool.
        speck_px: Edge of the opening's square.
        bridge_px: Edge of the closing's square.
    """

    def __init__(
        self,
        spans: np.ndarray,
        is_used: np.ndarray,
        is_robot: np.ndarray,
        speck_px: int,
        bridge_px: int,
    ) -> None:
        self._spans = spans
        rows = np.flatnonzero(spans[:, 1] > spans[:, 0])
        first, last = int(rows[0]), int(rows[-1]) + 1
        left, right = int(spans[first:last, 0].min()), int(spans[first:last, 1].max())
        self._box = slice(first, last), slice(left, right)
        self._keep = np.where(is_used, 255, 0).astype(np.uint8)[self._box]
        self._robot = np.where(is_robot, 255, 0).astype(np.uint8)
        self._speck = np.ones((speck_px, speck_px), np.uint8)
        self._bridge = np.ones((bridge_px, bridge_px), np.uint8)
        self._raw = self._robot.copy()

    def raw_mask(self, image: np.ndarray, table: np.ndarray) -> np.ndarray:
        """Return which pixels have the floor's color, 255 or 0, (H, W); valid until the next.

        Those that see the robot count as floor here.
        """
        classify(image, table, self._spans, self._robot, self._raw)
        return self._raw

    def mask(self, image: np.ndarray, table: np.ndarray) -> np.ndarray:
        """Return the floor region, 255 or 0, (H, W), uint8.

        Args:
            image: (H, W, 3), uint8.
            table: Of its channels' order, from `color_table`.
        """
        return self.cleaned(self.raw_mask(image, table))

    def cleaned(self, raw: np.ndarray) -> np.ndarray:
        """Return a mask opened, closed and cut to the pixels that may be floor."""
        box = cv2.morphologyEx(raw[self._box], cv2.MORPH_CLOSE, self._bridge)
        if self._speck.size > 1:
            box = cv2.morphologyEx(box, cv2.MORPH_OPEN, self._speck)
        mask = np.zeros_like(raw)
        cv2.bitwise_and(box, self._keep, dst=mask[self._box])
        return mask
