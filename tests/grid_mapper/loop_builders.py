"""Drives that come back, for the tests of loop closing."""

from __future__ import annotations

import numpy as np
from worlds import box, scan_at

from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.front_end import key_frame
from grid_mapper.key_frames import Edge, KeyFrame
from grid_mapper.loop_closer import LoopCloser

NS = 1_000_000_000
LOOSE = np.diag([0.05, 0.05, 0.02]) ** 2
SURE = np.diag([0.01, 0.01, 0.005]) ** 2


def ring() -> np.ndarray:
    """Return the walls of a corridor round a block of 8 x 6 m, with cupboards and niches."""
    walls = [box(-6, -5, 6, 5), box(-4, -3, 4, 3)]
    for x, y, w, h in (
        (-5.9, -1, 0.4, 1), (5.5, 1.2, 0.4, 1.4), (-1, -4.9, 1.2, 0.4), (2.2, 4.4, 0.8, 0.5),
        (-3.1, 3.0, 0.6, 0.4), (4.0, -1.6, 0.3, 0.7), (-5.9, 3.3, 0.5, 0.4), (4.4, -4.9, 0.4, 0.6),
    ):  # fmt: skip
        walls.append(box(x, y, x + w, y + h))
    return np.vstack(walls)


def round_the_ring(num: int, laps: float = 1.0, beside: float = 0.0) -> list[SE2]:
    """Return poses round the middle of the corridor, counter-clockwise from its lower left."""
    corners = np.array([(-5, -4), (5, -4), (5, 4), (-5, 4), (-5, -4)], float)
    sides = np.diff(corners, axis=0)
    lengths = np.hypot(*sides.T)
    ends = np.concatenate(([0.0], np.cumsum(lengths)))
    poses = []
    for s in np.linspace(0.0, laps * ends[-1], num) % ends[-1]:
        k = min(int(np.searchsorted(ends, s, side="right")) - 1, 3)
        along = sides[k] / lengths[k]
        x, y = corners[k] + (s - ends[k]) * along
        yaw = np.arctan2(along[1], along[0])
        poses.append(SE2(float(x), float(y), float(yaw)) @ SE2(0.0, beside, 0.0))
    return poses


def drifted(truth: list[SE2], turn_per_step: float, stretch: float = 1.0) -> list[SE2]:
    """Return the poses as one has them who turns and stretches every step a little."""
    poses = [truth[0]]
    for a, b in zip(truth, truth[1:], strict=False):
        step = a.between(b)
        moved = SE2(stretch * step.x, stretch * step.y, step.yaw + turn_per_step)
        poses.append(poses[-1] @ moved)
    return poses


def frames_at(
    truth: list[SE2], local: list[SE2], walls: np.ndarray, rng: np.random.Generator | None = None
) -> list[KeyFrame]:
    """Return key frames seen at true poses by a front end that believes others."""
    config, frames = GridMapperConfig(), []
    information = np.diag([1e4, 1e4, 1e5])
    for k, (pose, believed) in enumerate(zip(truth, local, strict=True)):
        scan = scan_at(pose, walls, rng=rng)
        frames.append(key_frame(k * NS, scan, SE2.identity(), believed, information, config))
    return frames


def closed(frames: list[KeyFrame], config: GridMapperConfig | None = None) -> LoopCloser:
    """Return what a closer makes of frames."""
    closer = LoopCloser(config or GridMapperConfig())
    for frame in frames:
        closer.add(frame)
    closer.finish()
    return closer


def motion(first: int, second: int, T: SE2, is_loop: bool = False, cov: np.ndarray = LOOSE) -> Edge:
    """Return an edge."""
    return Edge(first, second, T, cov, is_loop)


def largest_error(poses: list[SE2], truth: list[SE2]) -> float:
    """Return the greatest distance of a pose from its true one."""
    return max(a.between(b).distance for a, b in zip(poses, truth, strict=True))
