"""Short drives: the floor localizer settles by the goals it sees, and finds itself when carried.

The robot drives a curve among cubes, its masks and goals from the same pictures, its odometry a few
percent off. In the middle a cover hides the floor, and when that is gone the robot stands somewhere
else, at any heading; its odometry knows nothing of it. What is counted: masks after which the pose
is given and right, given and wrong, open or lost, and the time to the first right one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.floor_pose_bounds import calibrated
from experiments.floor_pose_runs import FAILED_M, FAILED_RAD, NUM_CUBES
from experiments.floor_pose_scenes import FieldCamera, random_cubes
from floor_perception.markers import MarkerDetector, load_marker_classes
from floor_perception.resources import find_file
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_fitter import FloorShapeFitter
from multi_localizer.floor_localizer import FloorLocalizer
from multi_localizer.floor_node_config import FloorPoseConfig
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_rays import BorderScanner
from multi_localizer.floor_tracker import TrackState
from multi_localizer.goal_evidence import GoalsSeen
from multi_localizer.pose_estimate import difference

PERIOD_S = 0.1
PART_MASKS, COVERED_MASKS = 25, 5
SPEED, TURN_SD = 0.25, 0.8
ODOM_SHARE = 0.03
_NS = 1_000_000_000


@dataclass(frozen=True)
class Moment:
    """What one mask came to: the state, and whether the pose given is right."""

    state: TrackState
    is_right: bool


def drives(
    field: FieldCamera, num: int, plan: FloorPlan, seed: int, scanner: BorderScanner
) -> dict[str, Any]:
    """Return what a number of drives amounts to.

    Args:
        field: Takes the pictures.
        num: Drives.
        plan: The floor.
        seed: Of everything drawn.
        scanner: Its paths serve all calibrations.
    """
    parts: list[list[Moment]] = []
    for k in range(num):
        rng = np.random.default_rng([seed, 7, k])
        camera = calibrated(field.camera, rng).camera(field.camera)
        parts += _drive(field, camera, plan, rng, scanner)
    return summary(parts[::2], parts[1::2])


def summary(before: list[list[Moment]], after: list[list[Moment]]) -> dict[str, Any]:
    """Return counts of all masks, and times until right, before and after being carried away."""
    every = [m for part in [*before, *after] for m in part]
    known = [m for m in every if m.state is TrackState.KNOWN]
    settle, recover = ([first_right_s(part) for part in parts] for parts in (before, after))
    return {
        "drives": len(before), "masks": len(every),
        "settled": sum(bool(m.is_right) for m in known),
        "wrong": sum(not m.is_right for m in known),
        "open": sum(m.state is TrackState.OPEN for m in every),
        "lost": sum(m.state is TrackState.LOST for m in every),
        "never_settled": sum(t is None for t in settle),
        "never_recovered": sum(t is None for t in recover),
        "settle_s": _times(settle), "recover_s": _times(recover),
    }  # fmt: skip


def first_right_s(part: list[Moment]) -> float | None:
    """Return after how many seconds the pose is given and right, and stays so; None: never.

    A part begins with the first mask that is not covered.
    """
    for k in range(len(part)):
        if part[k].is_right and all(m.is_right or m.state is not TrackState.KNOWN
                                    for m in part[k:]):  # fmt: skip
            return PERIOD_S * k
    return None


def _times(seconds: list[float | None]) -> dict[str, float | None]:
    known = [s for s in seconds if s is not None]
    if not known:
        return {"median": None, "largest": None}
    return {"median": float(np.median(known)), "largest": max(known)}


def _drive(
    field: FieldCamera, camera: FloorCamera, plan: FloorPlan, rng: np.random.Generator,
    scanner: BorderScanner,
) -> list[list[Moment]]:  # fmt: skip
    """Return the moments before and after the robot is carried away."""

    def make(c: FloorCamera, p: FloorPlan, config: FloorFitConfig) -> FloorShapeFitter:
        return FloorShapeFitter(c, p, config, scanner.through(c))

    localizer = FloorLocalizer(camera, plan, FloorPoseConfig(), make)
    markers = MarkerDetector(camera, load_marker_classes(find_file("soccer", "colors")))
    odom, stamp_ns, parts = SE2(3.0, 1.0, 2.0), _NS, []
    covered = np.zeros((camera.height_px, camera.width_px), np.uint8)
    for part in range(2):
        pose = SE2(*rng.uniform((-1.0, -0.45, -math.pi), (1.0, 0.45, math.pi)).tolist())
        cubes = tuple(random_cubes(pose, NUM_CUBES, plan, rng))
        moments: list[Moment] = []
        for k in range(-COVERED_MASKS * part, PART_MASKS):
            stamp_ns += int(PERIOD_S * _NS)
            if k < 0:
                localizer.take_mask(stamp_ns, covered, SE2.identity(), odom)
                continue
            picture = field.picture(pose, cubes, int(rng.integers(1 << 30)))
            localizer.take_mask(stamp_ns, field.mask(picture), SE2.identity(), odom)
            _see_goals(localizer, markers, picture, stamp_ns)
            moments.append(_moment(localizer, pose))
            pose, odom = _step(pose, odom, plan, rng)
        parts.append(moments)
    return parts


def _see_goals(
    localizer: FloorLocalizer, markers: MarkerDetector, picture: np.ndarray, stamp_ns: int
) -> None:
    for kind, found in markers.detect(picture, "rgb").items():
        bearings = np.array([m.bearing for m in found])
        localizer.tracker.see_goals(GoalsSeen(kind, stamp_ns, bearings, SE2.identity()))


def _moment(localizer: FloorLocalizer, pose: SE2) -> Moment:
    tracker = localizer.tracker
    if tracker.estimate is None:
        return Moment(tracker.state, False)
    x, y, yaw = difference(tracker.estimate.pose, pose)
    is_right = math.hypot(x, y) < FAILED_M and abs(yaw) < FAILED_RAD
    return Moment(tracker.state, bool(is_right))


def _step(pose: SE2, odom: SE2, plan: FloorPlan, rng: np.random.Generator) -> tuple[SE2, SE2]:
    """Return where the robot is a period later, and where its odometry has it."""
    turn = PERIOD_S * float(rng.normal(0.0, TURN_SD))
    ahead = pose @ SE2(SPEED * PERIOD_S + 0.2, 0.0, 0.0)
    way = SPEED * PERIOD_S if plan.contains(ahead.x, ahead.y) else 0.0
    turn = turn if way > 0.0 else 0.2  # a wall ahead: turn on the spot
    by = 1.0 + ODOM_SHARE * rng.normal(size=2)
    return pose @ SE2(way, 0.0, turn), odom @ SE2(way * float(by[0]), 0.0, turn * float(by[1]))
