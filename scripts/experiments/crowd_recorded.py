"""Drives through recorded people, who are replayed and see nothing of the robot."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.crowd_scenes import ROBOT, Scene, scene_with
from floornav_common.reporting import UserError
from sim_bridge.people.recorded import read_obsmat
from sim_bridge.people.schema import Recording

_DRAWS = 10_000
_APPEARS = 3.0  # nobody begins to be recorded nearer to a robot that drives straight, m


def recorded(path: Path, frames_per_s: float, seed: int) -> Scene:
    """Return a drive through recorded people: across their main way, or along it, in turns.

    Args:
        path: Of the `obsmat` file.
        frames_per_s: Frames of its video in a second.
        seed: Of when and where it sets out: nobody comes near its start in the first 2 s, and
            somebody would come within 1 m of a robot that drove straight on, and nobody begins to
            be recorded within 3 m of that.

    Raises:
        UserError: If no start and time drawn is like that.
    """
    rng = np.random.default_rng([seed, 5])
    rows = read_obsmat(path)
    low, high = np.percentile(rows[:, 2:], (3.0, 97.0), axis=0)
    is_along = bool(seed % 2)
    times = rows[:, 0] / frames_per_s
    for _ in range(_DRAWS):
        start, goal = _ends(rng, low, high, is_along)
        at = float(rng.uniform(times.min(), max(times.max() - 60.0, times.min() + 1.0)))
        if _is_fair(times - at, rows[:, 1], rows[:, 2:], start, goal):
            break
    else:
        raise UserError(f"{path}: no start of {_DRAWS} drawn ones lets a robot meet people fairly")
    recording = Recording(file=str(path), frames_per_s=frames_per_s, starts_s=at)
    scene = scene_with(path.parent.name or path.stem, [], tuple(start), tuple(goal))
    return Scene(replace(scene.world, recorded_people=recording), scene.goal, False)


def _is_fair(
    times: np.ndarray, numbers: np.ndarray, places: np.ndarray, start: np.ndarray, goal: np.ndarray
) -> bool:
    """Tell whether a drive meets somebody, and nobody begins to be recorded right before it.

    Args:
        times: Of all rows, from when the robot sets out, shape (N,), s.
        numbers: Whose they are, shape (N,).
        places: Where they are, shape (N, 2), m.
        start: Of the robot, shape (2,), m.
        goal: Of the robot, shape (2,), m.
    """
    is_soon = (times > -0.5) & (times < 2.0)
    if np.hypot(*(places[is_soon] - start).T).min(initial=math.inf) < 1.3:
        return False
    length = float(np.hypot(*(goal - start)))
    share = np.clip(times[:, None] * ROBOT.speed_m_s / length, 0.0, 1.0)
    off = np.hypot(*(places - (start + share * (goal - start))).T)
    is_then = (times > 2.0) & (times < length / ROBOT.speed_m_s)
    if off[is_then].min(initial=math.inf) >= 1.0:
        return False
    firsts = np.unique(numbers, return_index=True)[1]
    appears = firsts[(times[firsts] > 0.0) & (times[firsts] < 2.0 * length / ROBOT.speed_m_s)]
    return bool(off[appears].min(initial=math.inf) > _APPEARS)


def _ends(
    rng: np.random.Generator, low: np.ndarray, high: np.ndarray, is_along: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return where a drive through a region begins and ends, along its longer side or across."""
    size = high - low
    ahead = int(np.argmax(size)) if is_along else int(np.argmin(size))
    middle = low + rng.uniform(0.3, 0.7, 2) * size
    half = 0.5 * min(max(float(size[ahead]), 8.0), 11.0)
    middle[ahead] = 0.5 * (low + high)[ahead]
    off = np.zeros(2)
    off[ahead] = half * float(rng.choice([-1.0, 1.0]))
    return middle - off, middle + off
