"""One false bearing among those of unlike posts: how often a wrong pose comes out as a sure one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floornav_common.reporting import Table
from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_locator import LandmarkLocator, sightings_of
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.pose_estimate import difference, normalized_error

VIEWS = 400
FALSE_RAD = (0.03, 0.5)
WRONG_CHI2 = 25.0  # of 3 numbers: once in 60 000
# Posts in the order in which they are added: the corners of goals, then of the field.
_ALL = (
    (4.11, 0.8), (4.11, -0.8), (-4.11, -0.8), (-4.11, 0.8), (0.0, 2.6), (0.0, -2.6), (4.5, 2.6),
    (-4.5, -2.6),
)  # fmt: skip
CASES = ((3, 0), (3, 1), (4, 1), (5, 1), (5, 2), (6, 1), (6, 2), (8, 1), (8, 2))


def fault_rows(seed: int, config: LandmarkConfig) -> list[dict[str, Any]]:
    """Return a row for each number of posts and of spare bearings asked for."""
    return [_row(seed, num, spare, config.bearing_sd_rad) for num, spare in CASES]


def fault_table(rows: list[dict[str, Any]]) -> Table:
    """Return the rows as a table."""
    header = [
        "posts", "min_spare", "sent, none false %", "sent, one false %", "wrong pose sent %",
        "worst error m",
    ]  # fmt: skip
    return Table(header, [
        [
            r["posts"], r["min_spare"], round(100.0 * r["sent_share"], 1),
            round(100.0 * r["false_sent_share"], 1), round(100.0 * r["wrong_share"], 1),
            round(r["worst_m"], 2),
        ]
        for r in rows
    ])  # fmt: skip


def _row(seed: int, num: int, spare: int, sd: float) -> dict[str, Any]:
    """Count poses sent, with and without a false bearing, and those over five deviations off."""
    posts: Landmarks = {f"post{k}": (Landmark((place,)),) for k, place in enumerate(_ALL[:num])}
    locator = LandmarkLocator(posts, LandmarkConfig(bearing_sd_rad=sd, min_spare=spare))
    rng = np.random.default_rng([seed, num])
    num_sent, num_false_sent, errors = 0, 0, []
    for _ in range(VIEWS):
        pose = SE2(rng.uniform(-3.3, 3.3), rng.uniform(-1.8, 1.8), rng.uniform(-3.1, 3.1))
        bearings = _bearings(pose, posts) + rng.normal(0.0, sd, num)
        num_sent += _located(locator, bearings, sd).estimate is not None
        bearings[rng.integers(num)] += rng.choice((-1.0, 1.0)) * rng.uniform(*FALSE_RAD)
        estimate = _located(locator, bearings, sd).estimate
        if estimate is not None:
            num_false_sent += 1
            if normalized_error(estimate.pose, pose, estimate.cov) > WRONG_CHI2:
                errors.append(float(np.hypot(*difference(estimate.pose, pose)[:2])))
    return {
        "posts": num, "min_spare": spare, "sent_share": num_sent / VIEWS,
        "false_sent_share": num_false_sent / VIEWS, "wrong_share": len(errors) / VIEWS,
        "worst_m": max(errors, default=0.0),
    }  # fmt: skip


def _bearings(pose: SE2, posts: Landmarks) -> np.ndarray:
    local = pose.inverse() @ np.array([mark.position for (mark,) in posts.values()])
    return np.asarray(np.arctan2(local[:, 1], local[:, 0]))


def _located(locator: LandmarkLocator, bearings: np.ndarray, sd: float) -> Any:
    config = LandmarkConfig(bearing_sd_rad=sd)
    seen = {f"post{k}": np.array([math.remainder(b, math.tau)]) for k, b in enumerate(bearings)}
    return locator.locate(sightings_of(seen, config))
