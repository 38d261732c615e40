"""Time from the floor mask to the pose, with nothing known, with a guess, and when all is searched.

The mask is floor_detector's, of one of the seeded pictures of the small-size field. Peer: the
published steps on the same mask, in NumPy. Floor: reading every pixel of the mask once (counting
those of the floor with OpenCV). The paper's whole loop, pictures and driving included, took 45 ms.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from experiments.floor_pose_runs import POSITIONS_MM, views_at
from experiments.floor_pose_scenes import FieldCamera
from experiments.timing import Case, median_and_p99, take_turns
from multi_localizer.floor_fit import fit_published
from multi_localizer.floor_fitter import FloorShapeFitter
from multi_localizer.floor_plan import load_plan
from multi_localizer.pose_estimate import PoseEstimate

SIZES = ((256, 220), (640, 480))
NUM_CALLS = 100
PEER = "published steps"


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return a case for each size, and its parts."""
    cv2.setNumThreads(1)
    plan, cases = load_plan("small_size_field"), []
    for size in SIZES:
        say(f"floor_localization: {size[0]} x {size[1]}")
        field = FieldCamera(size, seed=seed)
        views = [views_at(field, position, 1, plan, seed)[0] for position in POSITIONS_MM]
        fitter = FloorShapeFitter(field.camera, plan)
        times: dict[str, list[np.ndarray]] = {}
        for view in views:
            calls = _calls(fitter, view.mask)
            for name, ms in take_turns(calls, NUM_CALLS).items():
                times.setdefault(name, []).append(ms)
        cases += _cases(f"{size[0]}x{size[1]}", {n: np.concatenate(ms) for n, ms in times.items()})
    return cases


def _calls(fitter: FloorShapeFitter, mask: np.ndarray) -> dict[str, Callable[[], object]]:
    plan, camera = fitter.plan, fitter.camera
    border = fitter.scanner.scan(mask)
    known = fitter.fit(mask)
    guess: PoseEstimate | None = known.candidates[0] if known.candidates else None
    return {
        "whole": lambda: fitter.fit(mask),
        "with a guess": lambda: fitter.fit(mask, guess),
        "border": lambda: fitter.scanner.scan(mask),
        "search of the whole plan": lambda: fitter.search.starts(border.values),
        "published": lambda: fit_published(mask, camera, plan),
        "bare": lambda: cv2.countNonZero(mask),
    }


def _cases(size: str, ms: dict[str, np.ndarray]) -> list[Case]:
    median, p99 = median_and_p99(ms["whole"])
    peer, floor = float(np.median(ms["published"])), float(np.median(ms["bare"]))
    whole = Case(size, median, p99, PEER, peer, floor, {"paper_loop_ms": 45.0})
    names = ("with a guess", "border", "search of the whole plan")
    return [whole, *(Case(f"{size} {name}", *median_and_p99(ms[name])) for name in names)]
