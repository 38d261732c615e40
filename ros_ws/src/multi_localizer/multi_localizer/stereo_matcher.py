"""Disparity of every pixel of the left image of a rectified pair, by the method asked for."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_cost import features, fill_costs, first_column, gray_of
from multi_localizer.stereo_dp import match_monotone
from multi_localizer.stereo_intervals import match_intervals
from multi_localizer.stereo_opencv import match_bm, match_sgbm
from multi_localizer.stereo_ours import match_ours
from multi_localizer.stereo_winners import refine


class StereoMatcher:
    """Matches pairs; the memory of the costs is kept from one pair to the next.

    Args:
        config: Method and tuning.
        num_threads: Threads that share the rows, for ours those of the costs alone; the result does
            not depend on it.
    """

    def __init__(self, config: StereoMatcherConfig | None = None, num_threads: int = 1) -> None:
        self.config = StereoMatcherConfig() if config is None else config
        self._num_threads = num_threads
        self._pool = ThreadPoolExecutor(num_threads) if num_threads > 1 else None
        self._costs = np.empty((0, 0, 0), dtype=np.uint8)
        self._averaged = self._costs

    def match(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Return the disparity of each pixel of the left image.

        Args:
            left: (H, W) gray or (H, W, 3) RGB, uint8.
            right: Of the same shape, rectified: a point lies in the same row of both, in the right
                image at its column in the left one less its disparity.

        Returns:
            Pixels, (H, W), float32; NaN where the method gives none.

        Raises:
            ValueError: If the images are not of one shape and kind.
        """
        _check(left, right)
        # Copies: kernels are compiled for arrays that may be written to, views on messages may not.
        left, right = np.array(left, order="C"), np.array(right, order="C")
        num, method = self.config.num_disparities, self.config.method
        if method == "bm":
            return match_bm(left, right, num)
        if method == "sgbm":
            return match_sgbm(left, right, num)
        first_right = first_column(right)
        costs = self._match_costs(left, right, first_right)
        if method == "ours":
            return match_ours(costs, gray_of(left), first_right, self.config)
        costs = self._average(costs)
        is_monotone = method == "monotone_dp"
        found = self._monotone(costs) if is_monotone else self._intervals(costs, left)
        self._over_rows(refine, len(found), costs, found)
        return found

    def warm_up(self) -> None:
        """Compile what matching needs, if it is not compiled yet."""
        image = np.random.default_rng(0).integers(0, 256, (24, 80, 3), dtype=np.uint8)
        self.match(image, np.roll(image, -3, axis=1))

    def _match_costs(self, left: np.ndarray, right: np.ndarray, first_right: int) -> np.ndarray:
        shape = (*left.shape[:2], self.config.num_disparities)
        if self._costs.shape != shape:
            self._costs = np.empty(shape, dtype=np.uint8)
        seen = (*features(left), *features(right))
        self._over_rows(fill_costs, shape[0], *seen, first_right, self._costs)
        return self._costs

    def _average(self, costs: np.ndarray) -> np.ndarray:
        if self.config.support_rows == 1:
            return costs
        if self._averaged.shape != costs.shape:
            self._averaged = np.empty_like(costs)
        column, flat = (1, self.config.support_rows), (len(costs), -1)
        cv2.blur(costs.reshape(flat), column, dst=self._averaged.reshape(flat))
        return self._averaged

    def _monotone(self, costs: np.ndarray) -> np.ndarray:
        found = np.empty(costs.shape[:2], dtype=np.float32)
        step = np.int32(self.config.monotone_step)
        self._over_rows(match_monotone, len(found), costs, step, found)
        return found

    def _intervals(self, costs: np.ndarray, left: np.ndarray) -> np.ndarray:
        found = np.empty(costs.shape[:2], dtype=np.float32)
        is_hidden = np.empty(found.shape, dtype=bool)
        c = self.config
        regions = cv2.medianBlur(left, c.cut_median_px) if c.cut_median_px > 1 else left
        self._over_rows(
            match_intervals, len(found), costs, regions.reshape(*found.shape, -1), c.cut_change,
            np.int32(c.stretch), c.hidden_score, found, is_hidden,
        )  # fmt: skip
        return found

    def _over_rows(self, do: Callable[..., None], num_rows: int, *args: object) -> None:
        """Call do(start, stop, *args) for parts of the rows that together are all of them."""
        if self._pool is None:
            do(0, num_rows, *args)
            return
        edges = np.linspace(0, num_rows, self._num_threads + 1).astype(int).tolist()
        parts = zip(edges[:-1], edges[1:], strict=True)
        for done in [self._pool.submit(do, start, stop, *args) for start, stop in parts]:
            done.result()


def _check(left: np.ndarray, right: np.ndarray) -> None:
    if left.dtype != np.uint8 or right.dtype != np.uint8:
        raise ValueError(f"both images must be uint8, got {left.dtype} and {right.dtype}")
    if left.shape != right.shape:
        raise ValueError(f"both images must be of one shape, got {left.shape} and {right.shape}")
    is_image = left.ndim == 2 or (left.ndim == 3 and left.shape[2] == 3)
    if not is_image or 0 in left.shape:
        raise ValueError(f"images must be (H, W) or (H, W, 3), got {left.shape}")
