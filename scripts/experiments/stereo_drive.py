"""A drive round the stereo room, followed by odometry and stereo views, begun without a guess."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.stereo_places import Observer
from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_pose import StereoPose, StereoState

SPEED, PERIOD_S = 0.4, 0.1
LOST_M = 0.5
_MIDDLE, _HALF_AXES, _WAVE = (2.56, 2.56), (0.95, 1.45), 0.12
_SCALE_ERROR, _STEP_NOISE, _TURN_NOISE = 0.02, 0.05, 0.002
SOURCE = "ours"


@dataclass(frozen=True)
class Step:
    """One step of a drive.

    Attributes:
        pose: Where the robot was.
        found: What the localizer said.
        ms: How long it took.
    """

    pose: SE2
    found: StereoPose
    ms: float

    @property
    def error(self) -> float:
        """Distance of the likeliest pose from the truth, m; inf if there is none."""
        pose = self.found.pose
        if pose is None:
            return math.inf
        return math.hypot(pose.x - self.pose.x, pose.y - self.pose.y)


def drive_poses(length: float) -> list[SE2]:
    """Return poses along rounds of changing width, one every `PERIOD_S` at `SPEED`."""
    poses: list[SE2] = []
    angle = 0.0
    while (len(poses) - 1) * SPEED * PERIOD_S < length:
        here, ahead = (_on_round(a) for a in (angle, angle + 1e-4))
        step = ahead - here
        poses.append(SE2(*here.tolist(), math.atan2(step[1], step[0])))
        angle += SPEED * PERIOD_S * 1e-4 / float(np.linalg.norm(step))
    return poses


def odometry_steps(poses: list[SE2], rng: np.random.Generator) -> list[SE2]:
    """Return each pose seen from the one before as wheels tell it.

    2 % too long all the time; each step off by another 5 % of it, its turn by 0.1 degrees.
    """
    steps = []
    for before, after in zip(poses[:-1], poses[1:], strict=True):
        true = before.inverse() @ after
        scale = 1.0 + _SCALE_ERROR + _STEP_NOISE * rng.standard_normal()
        turn = true.yaw + _TURN_NOISE * rng.standard_normal()
        steps.append(SE2(scale * true.x, scale * true.y, turn))
    return steps


def follow(
    observer: Observer,
    localizer: StereoLocalizer,
    length: float,
    seed: int,
    on_step: Callable[[int, int], None],
) -> list[Step]:
    """Return every step of a drive; the first pose is found without a guess."""
    poses = drive_poses(length)
    motions = [None, *odometry_steps(poses, np.random.default_rng(seed))]
    localizer.reset()
    steps = []
    for k, (pose, motion) in enumerate(zip(poses, motions, strict=True)):
        views = observer.look(pose, 1000 + k).views[SOURCE]
        started = time.perf_counter()
        # The first call has nothing to start from: a search of the whole map.
        found = localizer.track(views, motion or SE2(0.0, 0.0, 0.0), PERIOD_S)
        steps.append(Step(pose, found, 1e3 * (time.perf_counter() - started)))
        on_step(k + 1, len(poses))
    return steps


def drive_values(steps: list[Step]) -> dict[str, Any]:
    """Return the figures of a drive."""
    errors = 100.0 * np.array([step.error for step in steps])
    after = [step.ms for step in steps[1:]] or [math.nan]
    states = [step.found.state for step in steps]
    return {
        "length_m": round((len(steps) - 1) * SPEED * PERIOD_S, 2),
        "steps": len(steps),
        "lost_steps": sum(s is StereoState.LOST for s in states),
        "bridged_steps": sum(s is StereoState.BRIDGED for s in states),
        "ambiguous_steps": sum(s is StereoState.AMBIGUOUS for s in states),
        "far_off_steps": int((errors > 100.0 * LOST_M).sum()),
        "within_8cm": float(100.0 * np.mean(errors <= 8.0)),
        "median_cm": float(np.median(errors)),
        "max_cm": float(errors.max()),
        "first_ms": steps[0].ms,
        "median_ms": float(np.median(after)),
        "p99_ms": float(np.percentile(after, 99)),
    }


def _on_round(angle: float) -> np.ndarray:
    swing = 1.0 - _WAVE * (1.0 - math.cos(0.37 * angle)) / 2.0
    (x, y), (a, b) = _MIDDLE, _HALF_AXES
    return np.array([x + swing * a * math.cos(angle), y + swing * b * math.sin(angle)])
