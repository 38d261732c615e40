"""One false bearing among those of unlike posts: how often a wrong pose comes out as a sure one.

Of single views, and of short drives in which views confirm each other as `landmark_localizer` has
them do: the robot drives at 0.3 m/s, its odometry a few percent off. In the drives the false
bearing is another one in each view, or that of a thing that stands on the field and is taken for
one of the posts all the time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floornav_common.reporting import Progress, Table
from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmark_config import LandmarkConfig, LandmarkTrackConfig
from multi_localizer.landmark_locator import LandmarkFix, LandmarkLocator, sightings_of
from multi_localizer.landmark_tracker import LandmarkTracker
from multi_localizer.landmarks import Landmark, Landmarks
from multi_localizer.pose_estimate import PoseEstimate, difference, normalized_error

VIEWS = 400
FALSE_RAD = (0.03, 0.5)
WRONG_CHI2 = 25.0  # of 3 numbers: once in 60 000
# Posts in the order in which they are added: the corners of goals, then of the field.
_ALL = (
    (4.11, 0.8), (4.11, -0.8), (-4.11, -0.8), (-4.11, 0.8), (0.0, 2.6), (0.0, -2.6), (4.5, 2.6),
    (-4.5, -2.6),
)  # fmt: skip
DRIVES, VIEWS_A_DRIVE, PERIOD_S = 100, 15, 0.1
STEP_M, TURN_SD, ODOM_SHARE = 0.03, 0.05, 0.03
THING_M = (0.3, 2.5)  # from the robot's start
KINDS = ("none", "another in each view", "a thing that stands there")
DRIVE_CASES = tuple((num, kind) for num in (4, 5, 6) for kind in KINDS)
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


def drive_rows(
    seed: int, config: LandmarkConfig, num_drives: int = DRIVES, is_quiet: bool = True
) -> list[dict[str, Any]]:
    """Return a row for each number of posts and kind of false bearing, of short drives."""
    rows = []
    with Progress("drives with false bearings", len(DRIVE_CASES), is_quiet=is_quiet) as progress:
        for k, (num, kind) in enumerate(DRIVE_CASES):
            rows.append(_drive_row(seed, num, kind, config, num_drives))
            progress.update(k + 1)
    return rows


def drive_table(rows: list[dict[str, Any]]) -> Table:
    """Return the rows as a table."""
    header = [
        "posts", "false bearing", "drives with a pose %", "poses sent of views %",
        "drives with a wrong pose %", "wrong of views %", "wrong of views, each view alone %",
    ]  # fmt: skip
    keys = ("given_share", "sent_share", "wrong_drives", "wrong_share", "alone_wrong_share")
    return Table(header, [
        [r["posts"], r["false"], *(round(100.0 * r[k], 1) for k in keys)] for r in rows
    ])  # fmt: skip


def _drive_row(
    seed: int, num: int, kind: str, config: LandmarkConfig, num_drives: int
) -> dict[str, Any]:
    """Count drives, and views, with a pose given and with a wrong one."""
    posts: Landmarks = {f"post{k}": (Landmark((place,)),) for k, place in enumerate(_ALL[:num])}
    rng = np.random.default_rng([seed, num, KINDS.index(kind)])
    given, wrong, alone = (np.zeros((num_drives, VIEWS_A_DRIVE), dtype=bool) for _ in range(3))
    for k in range(num_drives):
        for n, (is_given, is_wrong) in enumerate(_drive(posts, kind, config, rng)):
            given[k, n], wrong[k, n], alone[k, n] = is_given, is_given and is_wrong, is_wrong
    return {
        "posts": num, "false": kind, "given_share": float(given.any(axis=1).mean()),
        "sent_share": float(given.mean()), "wrong_drives": float(wrong.any(axis=1).mean()),
        "wrong_share": float(wrong.mean()), "alone_wrong_share": float(alone.mean()),
    }  # fmt: skip


def _drive(
    posts: Landmarks, kind: str, config: LandmarkConfig, rng: np.random.Generator
) -> list[tuple[bool, bool]]:
    """Return of each view of a drive whether a pose was given, and whether the view's is wrong."""
    locator, tracker = LandmarkLocator(posts, config), LandmarkTracker(LandmarkTrackConfig())
    pose = SE2(rng.uniform(-3.0, 3.0), rng.uniform(-1.5, 1.5), rng.uniform(-3.1, 3.1))
    way, post = rng.uniform(-math.pi, math.pi), int(rng.integers(len(posts)))
    thing = np.array([pose.x, pose.y]) + rng.uniform(*THING_M) * np.array(
        (math.cos(way), math.sin(way))
    )
    odom, sd, said = SE2(3.0, 1.0, 2.0), config.bearing_sd_rad, []
    for k in range(VIEWS_A_DRIVE):
        bearings = _bearings(pose, posts)
        if kind == KINDS[1]:
            bearings[rng.integers(len(posts))] += rng.choice((-1.0, 1.0)) * rng.uniform(*FALSE_RAD)
        elif kind == KINDS[2]:
            bearings[post] = _bearing(pose, thing)
        stamp_ns = round(1e9 * PERIOD_S * (k + 1))
        noisy = bearings + rng.normal(0.0, sd, len(posts))
        expected = tracker.expected(stamp_ns, odom)
        fix = _located(locator, noisy, sd, expected)
        estimate = fix.estimate
        why_not = tracker.update(stamp_ns, estimate, odom, fix.is_elsewhere)
        is_wrong = estimate is not None and _is_wrong(estimate, pose)
        said.append((estimate is not None and not why_not, is_wrong))
        pose, odom = _step(pose, odom, rng)
    return said


def _step(pose: SE2, odom: SE2, rng: np.random.Generator) -> tuple[SE2, SE2]:
    """Return where the robot is a view later, and where its odometry has it."""
    turn, by = float(rng.normal(0.0, TURN_SD)), 1.0 + ODOM_SHARE * rng.normal(size=2)
    own = SE2(STEP_M * float(by[0]), 0.0, turn * float(by[1]))
    return pose @ SE2(STEP_M, 0.0, turn), odom @ own


def _is_wrong(estimate: PoseEstimate, pose: SE2) -> bool:
    return normalized_error(estimate.pose, pose, estimate.cov) > WRONG_CHI2


def _bearing(pose: SE2, place: np.ndarray) -> float:
    x, y = (pose.inverse() @ place[None])[0]
    return math.atan2(y, x)


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
            if _is_wrong(estimate, pose):
                errors.append(float(np.hypot(*difference(estimate.pose, pose)[:2])))
    return {
        "posts": num, "min_spare": spare, "sent_share": num_sent / VIEWS,
        "false_sent_share": num_false_sent / VIEWS, "wrong_share": len(errors) / VIEWS,
        "worst_m": max(errors, default=0.0),
    }  # fmt: skip


def _bearings(pose: SE2, posts: Landmarks) -> np.ndarray:
    local = pose.inverse() @ np.array([mark.position for (mark,) in posts.values()])
    return np.asarray(np.arctan2(local[:, 1], local[:, 0]))


def _located(
    locator: LandmarkLocator, bearings: np.ndarray, sd: float, expected: PoseEstimate | None = None
) -> LandmarkFix:
    config = LandmarkConfig(bearing_sd_rad=sd)
    seen = {f"post{k}": np.array([wrap_angle(b)]) for k, b in enumerate(bearings)}
    return locator.locate(sightings_of(seen, config), expected)
