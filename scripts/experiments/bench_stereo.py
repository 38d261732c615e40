"""Time from a pair of images to disparities, 64 of them searched, beside OpenCV's matchers.

The pair is one of the stereo room, rendered at 320 x 240 and enlarged for 640 x 480; every matcher
gets the same color images and one thread. Peer: StereoSGBM with 5 directions; StereoBM stands
beside it. Floor: writing the costs of all disparities once.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from experiments.stereo_views import StereoRoom
from experiments.timing import Case, median_and_p99, take_turns
from multi_localizer.stereo_config import METHODS, StereoMatcherConfig
from multi_localizer.stereo_matcher import StereoMatcher
from multi_localizer.stereo_opencv import sgbm

SIZES = ((320, 240), (640, 480))
NUM_DISPARITIES, NUM_CALLS = 64, 60
PEER = "StereoSGBM"


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each size and method, and for SGBM on gray images."""
    cv2.setNumThreads(1)
    view = next(StereoRoom(seed).views(1, np.random.default_rng(seed)))
    cases = []
    for size in SIZES:
        say(f"stereo: {size[0]} x {size[1]}")
        pair = [cv2.resize(image, size) for image in (view.left, view.right)]
        cases += _cases(f"{size[0]}x{size[1]}", take_turns(_calls(*pair), NUM_CALLS))
    return cases


def _calls(left: np.ndarray, right: np.ndarray) -> dict[str, Callable[[], object]]:
    gray = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (left, right)]
    costs = np.empty((*left.shape[:2], NUM_DISPARITIES), dtype=np.uint8)
    own = [m for m in METHODS if m not in ("bm", "sgbm")]
    configs = [StereoMatcherConfig(method=m, num_disparities=NUM_DISPARITIES) for m in own]
    matchers = {c.method: StereoMatcher(c) for c in configs}
    color_sgbm, gray_sgbm = sgbm(3, NUM_DISPARITIES), sgbm(2, NUM_DISPARITIES, blockSize=5)
    bm = cv2.StereoBM_create(numDisparities=NUM_DISPARITIES, blockSize=9)
    return {
        **{n: (lambda m=m: m.match(left, right)) for n, m in matchers.items()},
        "bm": lambda: bm.compute(*gray),
        "sgbm": lambda: color_sgbm.compute(left, right),
        "sgbm_gray": lambda: gray_sgbm.compute(*gray),
        "floor": lambda: costs.fill(1),
    }


def _cases(size: str, ms: dict[str, np.ndarray]) -> list[Case]:
    peer, floor = (float(np.median(ms[name])) for name in ("sgbm", "floor"))
    gray = float(np.median(ms["sgbm_gray"]))
    cases = []
    for name in (n for n in ms if n != "floor"):
        extra = {"times_sgbm_on_gray": float(np.median(ms[name])) / gray}
        cases.append(Case(f"{size}_{name}", *median_and_p99(ms[name]), PEER, peer, floor, extra))
    return cases
