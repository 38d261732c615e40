"""What each method found at a place, and the figures over all places."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from experiments.stereo_look_alike import FAR_M, LookAlikes
from experiments.stereo_places import TRUE, Place
from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.pose_estimate import normalized_error
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_pose import StereoPose, StereoState

Values = dict[str, Any]
METHODS = {  # name: where distances are from, how the pose is searched
    "interval_dp": ("interval_dp", "published"),
    "monotone_dp": ("monotone_dp", "published"),
    "color_only": ("interval_dp", "color_only"),
    "ours": ("ours", "ours"),
    "true_disparity": (TRUE, "ours"),
    "published_true": (TRUE, "published"),
}


def judge_place(
    place: Place, localizers: Mapping[str, StereoLocalizer], alike: LookAlikes
) -> Values:
    """Return the place, what every method found there, and the place that looks most like it."""
    twin = alike.twin(place.pose)
    row: Values = {
        "pose": _listed(place.pose), "twin": _listed(twin.pose), "twin_score": twin.score,
        "score": alike.score(place.pose, place.views["interval_dp"]), "found": {},
    }  # fmt: skip
    for name, (source, kind) in METHODS.items():
        localizers[kind].reset()
        started = time.perf_counter()
        found = localizers[kind].locate(place.views[source])
        ms = 1e3 * (time.perf_counter() - started)
        row["found"][name] = {**_errors(found, place), "ms": ms}
    return row


def _errors(found: StereoPose, place: Place) -> Values:
    pose, state = found.pose, found.state.value
    if pose is None:
        return {
            "pose": None, "state": state, "x_m": None, "y_m": None, "yaw_rad": None, "nees": None,
        }  # fmt: skip
    assert found.cov is not None
    return {
        "pose": _listed(pose), "state": state, "x_m": abs(pose.x - place.pose.x),
        "y_m": abs(pose.y - place.pose.y),
        "yaw_rad": abs(float(wrap_angle(pose.yaw - place.pose.yaw))),
        "nees": normalized_error(pose, place.pose, found.cov),
    }  # fmt: skip


def _listed(pose: SE2) -> list[float]:
    return [pose.x, pose.y, pose.yaw]


def summarized(places: list[Values], name: str) -> Values:
    """Return a method's figures; a place without a pose is outside 8 cm and in no mean."""
    found = [place["found"][name] for place in places]
    given = [f for f in found if f["pose"] is not None]
    off = np.array([math.hypot(f["x_m"], f["y_m"]) for f in given])
    yaw = np.degrees([f["yaw_rad"] for f in given])
    is_known = np.array([f["state"] == StereoState.KNOWN.value for f in given], dtype=bool)

    def mean(values: Any) -> float | None:
        return float(np.mean(values)) if len(values) else None

    return {
        "within_8cm": 100.0 * float((off <= 0.08).sum()) / len(found),
        "mean_x_cm": mean([100.0 * f["x_m"] for f in given]),
        "mean_y_cm": mean([100.0 * f["y_m"] for f in given]),
        "mean_theta_deg": mean(yaw),
        "median_cm": 100.0 * float(np.median(off)) if len(off) else None,
        "median_theta_deg": float(np.median(yaw)) if len(yaw) else None,
        "over_1m": 100.0 * float((off > 1.0).sum()) / len(found),
        "known": 100.0 * float(is_known.sum()) / len(found),
        "known_within_8cm": 100.0 * float(np.mean(off[is_known] <= 0.08)) if is_known.any()
        else None,
        "mean_nees": mean([f["nees"] for f, known in zip(given, is_known, strict=True) if known]),
        "median_ms": float(np.median([f["ms"] for f in found])),
    }  # fmt: skip


def look_alike_values(places: list[Values]) -> Values:
    """Return the noise of eq. 1 and which share of places has a twin within it."""
    scores, twins = (np.array([p[key] for p in places]) for key in ("score", "twin_score"))
    noise = float(scores.std())
    return {
        "noise": noise, "mean_score": float(scores.mean()), "farther_than_m": FAR_M,
        "share": 100.0 * float(np.mean(twins < noise)),
        "share_below_mean_score": 100.0 * float(np.mean(twins < scores.mean())),
    }  # fmt: skip
