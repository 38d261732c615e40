"""The third matcher, beyond the paper: DP from three sides, held against the right image, smoothed.

What it adds to the published rows: coherence from row to row (`stereo_paths`), a check that no two
left pixels want the same right one at different distances, disparities between pixels
(`stereo_winners`), small islands dropped, and a median and a mean over what is left.
"""

from __future__ import annotations

import cv2
import numba
import numpy as np

from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_fill import fill_from_farther
from multi_localizer.stereo_paths import from_above, from_both_sides, jump_prices
from multi_localizer.stereo_smooth import drop_islands, mean_within
from multi_localizer.stereo_winners import pick_winners


def match_ours(
    costs: np.ndarray, gray: np.ndarray, first_right: int, config: StereoMatcherConfig
) -> np.ndarray:
    """Return disparities of the left image, (H, W), float32.

    Args:
        costs: (H, W, D), uint8.
        gray: Left image, (H, W), uint8.
        first_right: First column of the right image that shows anything.
        config: Its prices, and whether holes are filled; if not they are NaN.
    """
    found = np.empty(gray.shape, dtype=np.float32)
    prices = jump_prices(config.large_step, config.small_step, config.gray_scale)
    small, most = np.uint8(config.small_step), config.max_difference
    _sum_and_pick(costs, gray, small, prices, most, first_right, found)
    found = drop_islands(found, config.island_px)
    is_hole = np.isnan(found)
    smooth = fill_from_farther(found)
    if config.median_px > 1:
        smooth = cv2.medianBlur(smooth, config.median_px)
    smooth = mean_within(smooth, config.mean_px // 2, 1.0)
    smooth[is_hole] = np.nan
    return fill_from_farther(smooth) if config.fill_holes else smooth


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _sum_and_pick(  # type: ignore[no-untyped-def]
    costs, gray, small, prices, max_difference, first_right, out
):
    height, width, num = costs.shape
    wall = np.uint8(255)
    above, here = np.zeros((2, width, num + 3), dtype=np.uint8)
    sides = np.full((2, width + 1, num + 2), wall, dtype=np.uint8)
    for rows in (above, here):
        rows[:, 0] = wall
        rows[:, num + 1] = wall
    sums = np.empty((width, num), dtype=np.uint16)
    seen_right = np.empty(width + num, dtype=np.uint32)
    for y in range(height):
        from_above(costs[y], gray[y], gray[max(y - 1, 0)], small, prices, above, here, sums)
        from_both_sides(costs[y], gray[y], small, prices, sides[0], sides[1], sums)
        pick_winners(sums, max_difference, first_right, seen_right, out[y])
        above, here = here, above
