"""One real pair of images with its true disparities through every stereo matcher.

Every method gets the pair with as many columns added on the left as disparities are searched, so
that it can search every column of the picture; what is then without a value counts as bad, and is
judged a second time with all holes filled by one rule.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from floornav_common.reporting import UserError
from multi_localizer.stereo_config import METHODS, StereoMatcherConfig
from multi_localizer.stereo_fill import fill_from_farther
from multi_localizer.stereo_matcher import StereoMatcher
from multi_localizer.stereo_opencv import match_sgbm

SGBM_GRID = {
    "blockSize": (1, 3, 5), "P1": (4, 8, 16, 24), "P2": (16, 32, 64, 100),
    "disp12MaxDiff": (1, 1000), "preFilterCap": (5, 15, 31, 63),
}  # fmt: skip
"""Settings that are tried for the pair; P1 and P2 for each channel and pixel of a block."""


@dataclass(frozen=True)
class Pair:
    """A rectified pair.

    Attributes:
        left: (H, W, 3), RGB, uint8.
        right: The same.
        truth: Disparities of the left image, (H, W), NaN where unknown.
    """

    left: np.ndarray
    right: np.ndarray
    truth: np.ndarray


def read_pair(left: str, right: str, truth: str, scale: float) -> Pair:
    """Read a pair; the truth's pixels are disparities times `scale`, 0 where unknown.

    Raises:
        UserError: If a file is no image, or their sizes differ.
    """
    images = [_read(path, cv2.IMREAD_COLOR) for path in (left, right)]
    known = _read(truth, cv2.IMREAD_UNCHANGED)
    if known.ndim != 2:
        raise UserError(f"--gt {truth}: not a gray image")
    if not images[0].shape[:2] == images[1].shape[:2] == known.shape:
        sizes = " and ".join(f"{i.shape[1]} x {i.shape[0]}" for i in (*images, known))
        raise UserError(f"images and truth must be of one size, got {sizes}")
    if not known.any():
        raise UserError(f"--gt {truth}: no pixel is known")
    disparities = np.where(known > 0, known / np.float32(scale), np.nan).astype(np.float32)
    rgb = [cv2.cvtColor(image, cv2.COLOR_BGR2RGB) for image in images]
    return Pair(rgb[0], rgb[1], disparities)


def _read(path: str, flags: int) -> np.ndarray:
    image = cv2.imread(path, flags) if Path(path).is_file() else None
    if image is None:
        raise UserError(f"{path}: no image that can be read")
    return image


def judge(found: np.ndarray, truth: np.ndarray) -> dict[str, float | None]:
    """Return percentages over all known pixels; one without a value is bad.

    `bad1` and `bad2` are off by more than 1 and 2 px, `mean_px` is the mean error with holes
    filled from the farther neighbor, `valid` the share with a value, `bad1_valid` of those alone,
    `bad1_filled` and `bad2_filled` with the holes filled.
    """
    known = ~np.isnan(truth)
    errors, has_value = np.abs(found - truth)[known], ~np.isnan(found[known])
    filled = np.abs(fill_from_farther(found) - truth)[known]

    def bad(of: np.ndarray, limit: float) -> float | None:
        return 100.0 * float(np.mean(~(of <= limit))) if of.size else None

    return {
        "bad1": bad(errors, 1.0), "bad2": bad(errors, 2.0),
        "mean_px": float(np.mean(filled)) if has_value.any() else None,
        "valid": 100.0 * float(has_value.mean()), "bad1_valid": bad(errors[has_value], 1.0),
        "bad1_filled": bad(filled, 1.0), "bad2_filled": bad(filled, 2.0),
    }  # fmt: skip


def match_padded(
    match: Callable[[np.ndarray, np.ndarray], np.ndarray], pair: Pair, num_disparities: int
) -> np.ndarray:
    """Return the disparities with columns added on the left for the search, and cut off again."""
    wide = [
        cv2.copyMakeBorder(image, 0, 0, num_disparities, 0, cv2.BORDER_REPLICATE)
        for image in (pair.left, pair.right)
    ]
    return match(*wide)[:, num_disparities:]


def matchers(num_disparities: int) -> dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]:
    """Return every method, as it is used on rendered and on real pairs alike."""
    configs = {m: StereoMatcherConfig(method=m, num_disparities=num_disparities) for m in METHODS}
    return {name: StereoMatcher(config).match for name, config in configs.items()}


def one_row_matchers(
    num_disparities: int,
) -> dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]:
    """Return the published methods without the costs of the rows beside (`support_rows` 1)."""
    config = StereoMatcherConfig(num_disparities=num_disparities, support_rows=1)
    return {
        f"{name}_one_row": StereoMatcher(replace(config, method=name)).match
        for name in ("interval_dp", "monotone_dp")
    }


def judge_all(pair: Pair, num_disparities: int) -> Iterator[tuple[str, dict[str, Any], np.ndarray]]:
    """Yield each method's name, measures and disparities; last SGBM tuned on this very pair.

    Ours stands there twice, with its own filling of holes and as it is sent. So does the tuned
    SGBM: with the settings that leave the fewest bad pixels as found, and the fewest when filled.
    """
    dense = StereoMatcherConfig(method="ours", num_disparities=num_disparities, fill_holes=True)
    methods = matchers(num_disparities)
    methods["ours_with_holes"], methods["ours"] = methods["ours"], StereoMatcher(dense).match
    for name, match in methods.items():
        found = match_padded(match, pair, num_disparities)
        yield name, judge(found, pair.truth), found
    for ending, (settings, found) in tuned_sgbm(pair, num_disparities).items():
        yield f"sgbm_tuned{ending}", {**judge(found, pair.truth), "settings": settings}, found


def tuned_sgbm(
    pair: Pair, num_disparities: int, grid: Mapping[str, Sequence[int]] = SGBM_GRID
) -> dict[str, tuple[dict[str, int], np.ndarray]]:
    """Return the settings of a grid that leave the fewest bad pixels, and what they give.

    Under "" those that are best as found, a hole being bad; under "_filled" those that are best
    with their holes filled.
    """
    best: dict[str, tuple[dict[str, int], np.ndarray]] = {}
    fewest = {"": math.inf, "_filled": math.inf}
    for values in itertools.product(*grid.values()):
        settings = dict(zip(grid, values, strict=True))
        for penalty in ("P1", "P2"):
            settings[penalty] *= 3 * settings["blockSize"] ** 2
        found = match_sgbm(pair.left, pair.right, num_disparities, **settings)
        measures = judge(found, pair.truth)
        for ending, least in fewest.items():
            bad = measures[f"bad1{ending}"]
            assert bad is not None
            if bad < least:
                fewest[ending], best[ending] = bad, (settings, found)
    return best
