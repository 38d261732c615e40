"""Tiny worlds for the mapper's tests: rooms of straight walls and exact scans in them."""

from __future__ import annotations

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2

FULL_TURN = 2.0 * np.pi


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """Return the four walls of a box as rows (x1, y1, x2, y2)."""
    c = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return np.array([(*c[k], *c[(k + 1) % 4]) for k in range(4)], float)


def square_room() -> np.ndarray:
    """Return a room of 8 x 6 m with a cupboard and a pillar, unlike itself under any turn."""
    return np.vstack((box(-4, -3, 4, 3), box(-4, 1, -3, 3), box(1.5, -1.0, 1.9, -0.6)))


def scan_at(
    pose: SE2, walls: np.ndarray, num_beams: int = 360, rng: np.random.Generator | None = None,
    sigma: float = 0.01, range_max: float = 30.0,
) -> Scan:  # fmt: skip
    """Return a full-turn scan; exact unless `rng` is given."""
    increment = FULL_TURN / num_beams
    angles = pose.yaw - np.pi + increment * np.arange(num_beams)
    ranges = ranges_to(walls, np.array([[pose.x, pose.y]]), angles)
    if rng is not None:
        ranges = ranges + rng.normal(0.0, sigma, num_beams)
    ranges[ranges > range_max] = np.inf
    return Scan(ranges, -np.pi, increment, 0.05, range_max)


def ranges_to(walls: np.ndarray, origins: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return how far beams go, shape (N,); they begin at `origins`, shape (N, 2) or (1, 2)."""
    d = np.column_stack((np.cos(angles), np.sin(angles)))[:, None, :]
    a, e = walls[None, :, :2] - origins[:, None, :], (walls[:, 2:] - walls[:, :2])[None]
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
        t = (a[..., 0] * e[..., 1] - a[..., 1] * e[..., 0]) / cross
        u = (a[..., 0] * d[..., 1] - a[..., 1] * d[..., 0]) / cross
    hit = (t > 0.0) & (u >= -1e-12) & (u <= 1.0 + 1e-12)
    return np.asarray(np.where(hit, t, np.inf).min(axis=1))


def swept_scan(
    poses: list[SE2], walls: np.ndarray, time_increment: float, rng: np.random.Generator,
    sigma: float = 0.01, range_max: float = 30.0,
) -> Scan:  # fmt: skip
    """Return a full-turn scan of which each beam is taken from a pose of its own."""
    increment = FULL_TURN / len(poses)
    at = np.array([pose.as_array() for pose in poses])
    angles = at[:, 2] - np.pi + increment * np.arange(len(poses))
    ranges = ranges_to(walls, at[:, :2], angles) + rng.normal(0.0, sigma, len(poses))
    ranges[ranges > range_max] = np.inf
    return Scan(ranges, -np.pi, increment, 0.05, range_max, time_increment)


def moved_walls(T: SE2, walls: np.ndarray) -> np.ndarray:
    """Return the walls of a world moved by T."""
    return np.hstack((T @ walls[:, :2], T @ walls[:, 2:]))


def drive_around(num: int = 60) -> list[SE2]:
    """Return poses on a rounded way through the square room."""
    phi = np.linspace(0.0, 1.5 * np.pi, num)
    return [SE2(-1.5 + 1.3 * np.cos(p), -0.8 + 1.0 * np.sin(p), p + np.pi / 2.0) for p in phi]
