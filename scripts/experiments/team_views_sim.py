"""What robots of a layout see: bearings without names; noise, hiding, misses and false ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numba
import numpy as np

from experiments.team_layouts import BODY_RADIUS, OBSTACLE_RADIUS, POSTS, Layout
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_views import NOBODY, RobotView


@dataclass(frozen=True, kw_only=True)
class Senses:
    """How well the robots see, and how well each knows its place by itself.

    Attributes:
        noise: Deviation of a bearing, rad.
        rough_sd: Deviation of a rough pose: x, y, yaw; None for no rough pose.
        hides: Whether bodies and obstacles hide what is behind them.
        sees_posts: Whether the goal posts are seen.
        miss_share: Chance that something in view is not detected.
        num_false: Mean number of false detections of each robot, of any bearing.
    """

    noise: float
    rough_sd: tuple[float, float, float] | None = (0.36, 0.36, float(np.radians(15.0)))
    hides: bool = True
    sees_posts: bool = True
    miss_share: float = 0.0
    num_false: float = 0.0


@dataclass(frozen=True, eq=False)
class Scene:
    """Views of a team, and beside them what only the judge may know.

    Attributes:
        layout: Where everything is.
        senses: How it was seen.
        views: All that is handed to a localizer.
        true_ids: For each robot the index of the robot at each bearing, `NOBODY` at false ones.
        visible: [i, j]: robot j is not hidden from robot i, (N, N).
        faulty: Robots whose word is false on purpose; they are not judged.
    """

    layout: Layout
    senses: Senses
    views: tuple[RobotView, ...]
    true_ids: tuple[np.ndarray, ...]
    visible: np.ndarray
    faulty: tuple[int, ...] = ()


@numba.njit(cache=True)
def hidden(eye: np.ndarray, targets: np.ndarray, disks: np.ndarray) -> np.ndarray:
    """Return which targets have a disk across the line of sight to their middle, (T,) bool.

    Args:
        eye: (2,).
        targets: (T, 2).
        disks: x, y, radius, (K, 3); one that holds the eye or the target hides nothing there.
    """
    result = np.zeros(len(targets), dtype=np.bool_)
    for t in range(len(targets)):
        way_x, way_y = targets[t, 0] - eye[0], targets[t, 1] - eye[1]
        length = max(math.hypot(way_x, way_y), 1e-9)
        for k in range(len(disks)):
            x, y, radius = disks[k, 0] - eye[0], disks[k, 1] - eye[1], disks[k, 2]
            along = (way_x * x + way_y * y) / length
            aside = abs(way_x * y - way_y * x) / length
            if 0.0 < along < length and aside < radius:
                holds_eye = math.hypot(x, y) <= radius
                holds_target = math.hypot(x - way_x, y - way_y) <= radius
                if not holds_eye and not holds_target:
                    result[t] = True
                    break
    return result


def see(layout: Layout, senses: Senses, seed: int) -> Scene:
    """Return what the robots see; same arguments, same scene."""
    rng = np.random.default_rng([seed, len(layout.poses), 7])
    visible = _visible(layout, senses.hides)
    views, ids = [], []
    for index, name in enumerate(layout.names):
        bearings, true_ids = _robots(layout, senses, index, visible[index], rng)
        posts = _posts(layout, senses, index, rng)
        rough = _rough(layout.poses[index], senses, rng)
        views.append(
            RobotView(name, bearings, posts, rough=rough, bearing_sd=senses.noise)
        )  # fmt: skip
        ids.append(true_ids)
    return Scene(layout, senses, tuple(views), tuple(ids), visible)


def with_names(scene: Scene) -> tuple[RobotView, ...]:
    """Return the views with the true name at each bearing, for rows that ask for the fit alone."""
    names = (*scene.layout.names, "")  # the last one is for NOBODY
    return tuple(
        replace(view, known=tuple(names[k] for k in ids))
        for view, ids in zip(scene.views, scene.true_ids, strict=True)
    )


def _disks(layout: Layout) -> np.ndarray:
    robots = np.column_stack((layout.poses[:, :2], np.full(len(layout.poses), BODY_RADIUS)))
    others = np.column_stack((layout.obstacles, np.full(len(layout.obstacles), OBSTACLE_RADIUS)))
    return np.vstack((robots, others))


def _visible(layout: Layout, hides: bool) -> np.ndarray:
    places = layout.poses[:, :2]
    visible = ~np.eye(len(places), dtype=bool)
    if hides:
        for index, eye in enumerate(places):
            visible[index] &= ~hidden(eye, places, _disks(layout))
    return visible


def _bearings(
    pose: np.ndarray, places: np.ndarray, noise: float, rng: np.random.Generator
) -> np.ndarray:
    seen = np.arctan2(places[:, 1] - pose[1], places[:, 0] - pose[0]) - pose[2]
    return np.pi - (np.pi - seen - rng.normal(0.0, noise, len(places))) % (2.0 * np.pi)


def _robots(
    layout: Layout, senses: Senses, index: int, visible: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    seen = np.flatnonzero(visible & (rng.random(len(visible)) >= senses.miss_share))
    real = _bearings(layout.poses[index], layout.poses[seen, :2], senses.noise, rng)
    false = rng.uniform(-np.pi, np.pi, rng.poisson(senses.num_false))
    order = rng.permutation(len(real) + len(false))
    ids = np.concatenate((seen, np.full(len(false), NOBODY)))
    return np.concatenate((real, false))[order], ids[order]


def _posts(
    layout: Layout, senses: Senses, index: int, rng: np.random.Generator
) -> dict[str, np.ndarray]:
    places = np.concatenate(list(POSTS.values()))
    pose = layout.poses[index]
    is_seen = rng.random(len(places)) >= senses.miss_share
    if senses.hides:
        is_seen &= ~hidden(pose[:2], places, _disks(layout))
    bearings = _bearings(pose, places, senses.noise, rng)
    if not senses.sees_posts:
        return {}
    return {
        kind: bearings[k : k + 1] for k, kind in enumerate(POSTS) if is_seen[k]
    }  # fmt: skip


def _rough(pose: np.ndarray, senses: Senses, rng: np.random.Generator) -> PoseEstimate | None:
    if senses.rough_sd is None:
        return None
    x, y, yaw = pose + rng.normal(0.0, 1.0, 3) * senses.rough_sd
    return PoseEstimate(SE2(x, y, yaw), np.diag(np.square(senses.rough_sd)))
