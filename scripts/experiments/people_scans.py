"""A room full of people walking, as a laser on a robot that drives through it sees it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from experiments.corridor_loop import ray_cast
from floornav_common.scan import Scan
from floornav_common.se2 import SE2

BODY = 0.2
_HALF = 7.0
_NOISE, _RANGE_MAX = 0.01, 12.0
_SPEED = 0.5  # of the robot, m/s
_CLEAR = 0.9  # of the robot's way at the start, m


@dataclass(frozen=True)
class Moment:
    """What there is at one scan.

    Attributes:
        scan: What the laser sees, at base_link.
        pose: Of the robot in the room.
        people: Everyone's x, y, vx, vy in the base frame, shape (N, 4).
    """

    scan: Scan
    pose: SE2
    people: np.ndarray


def walk_through(
    num_people: int, num_beams: int, num_scans: int, period: float, seed: int
) -> Iterator[Moment]:
    """Yield scans of a full turn, one every `period` s, of people who walk straight on.

    They turn back at the walls; the robot drives ahead at 0.5 m/s from the room's left side.
    """
    rng = np.random.default_rng(seed)
    places = _apart(num_people, rng)
    ways = rng.uniform(-math.pi, math.pi, num_people)
    speeds = rng.uniform(0.6, 1.5, num_people)
    velocities = np.column_stack((speeds * np.cos(ways), speeds * np.sin(ways)))
    corners = _HALF * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    walls = np.hstack((corners, np.roll(corners, -1, axis=0)))
    step = 2.0 * math.pi / num_beams
    angles = -math.pi + step * np.arange(num_beams)
    for k in range(num_scans):
        pose = SE2(-0.6 * _HALF + _SPEED * period * k, 0.0, 0.1 * math.sin(0.5 * period * k))
        at = np.array([pose.x, pose.y])
        ranges = np.minimum(
            ray_cast(at, angles + pose.yaw, walls), _round(at, angles + pose.yaw, places)
        )
        ranges = ranges + _NOISE * rng.standard_normal(num_beams)
        inside = pose.inverse()
        people = np.hstack((inside @ places, SE2(0.0, 0.0, inside.yaw) @ velocities))
        yield Moment(Scan(ranges, -math.pi, step, 0.05, _RANGE_MAX), pose, people)
        places = places + period * velocities
        is_out = np.abs(places) > _HALF - 0.5
        velocities = np.where(is_out, -np.sign(places) * np.abs(velocities), velocities)


def _apart(num: int, rng: np.random.Generator) -> np.ndarray:
    places: list[np.ndarray] = []
    while len(places) < num:
        place = rng.uniform(-_HALF + 0.6, _HALF - 0.6, 2)
        is_off_robot = np.hypot(place[0] + 0.6 * _HALF, place[1]) > _CLEAR
        if is_off_robot and all(np.hypot(*(place - p)) > 3.0 * BODY for p in places):
            places.append(place)
    return np.array(places)


def _round(at: np.ndarray, angles: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the distance to the nearest body along each direction, shape (N,), m."""
    units = np.column_stack((np.cos(angles), np.sin(angles)))
    along = units @ (places - at).T
    off2 = ((places - at) ** 2).sum(axis=1) - along**2
    with np.errstate(invalid="ignore"):
        near = along - np.sqrt(BODY**2 - off2)
    return np.where((off2 < BODY**2) & (near > 0.0), near, np.inf).min(axis=1)
