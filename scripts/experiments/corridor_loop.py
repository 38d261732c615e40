"""A closed loop of 66 m through a ring corridor with rooms: the drive on which matchers are timed.

The plan is 20 x 20 m, the corridor 3 m wide, with rooms, doors and cupboards on both sides. The
robot starts and ends at the same pose, so the end error is what drifted. Everything follows from
one seed; beams have 1 cm of Gaussian range noise and no motion distortion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2

NUM_SCANS = 500
RANGE_SIGMA_M = 0.01
RANGE_MAX_M = 30.0
PLAN_M = 20.0
CORRIDOR_M = 3.0
CORNER_RADIUS_M = 1.2


@dataclass(frozen=True)
class Drive:
    """Scans along a path with the truth to hold a result against.

    Attributes:
        scans: One Scan per pose.
        truth: Pose of the sensor at each scan.
    """

    scans: list[Scan]
    truth: list[SE2]


def corridor_loop(num_beams: int, fov_rad: float, seed: int, num_scans: int = NUM_SCANS) -> Drive:
    """Make the drive.

    Args:
        num_beams: Beams a scan.
        fov_rad: Angle from first to last beam; a full turn leaves out the repeated beam.
        seed: Of the furniture and the noise.
        num_scans: Scans on the whole way.
    """
    rng = np.random.default_rng(seed)
    walls = _plan(rng)
    truth = _path(num_scans)
    scans = [_scan(walls, pose, num_beams, fov_rad, rng) for pose in truth]
    return Drive(scans, truth)


def ring_laps(
    num_beams: int, fov_rad: float, seed: int, num_scans: int, laps: int = 2,
    rng_drive: np.random.Generator | None = None,
) -> Drive:  # fmt: skip
    """Make a drive of several laps, each up to 0.4 m beside the middle of the corridor.

    Args:
        num_beams: Beams a scan.
        fov_rad: Angle from first to last beam; a full turn leaves out the repeated beam.
        seed: Of the furniture, the ways and the noise.
        num_scans: Scans a lap.
        laps: How often round.
        rng_drive: Draws ways and noise; by default what `seed` has left behind the furniture.
    """
    rng = np.random.default_rng(seed)
    walls = _plan(rng)
    rng = rng if rng_drive is None else rng_drive
    truth: list[SE2] = []
    for _ in range(laps):
        beside = SE2(0.0, float(rng.uniform(-0.4, 0.4)), 0.0)
        truth += [pose @ beside for pose in _path(num_scans)[:-1]]
    return Drive([_scan(walls, pose, num_beams, fov_rad, rng) for pose in truth], truth)


def ray_cast(origin: np.ndarray, angles: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Return the distance to the nearest wall along each direction.

    Args:
        origin: Shape (2,), m.
        angles: Shape (N,), rad.
        walls: Segments as rows (x1, y1, x2, y2), shape (M, 4), m.

    Returns:
        Shape (N,), m; inf where nothing is hit.
    """
    d = np.column_stack((np.cos(angles), np.sin(angles)))[:, None, :]
    a, e = walls[None, :, :2] - origin, (walls[:, 2:] - walls[:, :2])[None]
    cross = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (a[..., 0] * e[..., 1] - a[..., 1] * e[..., 0]) / cross
        u = (a[..., 0] * d[..., 1] - a[..., 1] * d[..., 0]) / cross
    hit = (t > 0.0) & (u >= 0.0) & (u <= 1.0)
    return np.where(hit, t, np.inf).min(axis=1)


def _plan(rng: np.random.Generator) -> np.ndarray:
    """Return the walls: outer walls, corridor walls with doors, partitions, cupboards."""
    inner, outer = 6.5, 6.5 + CORRIDOR_M
    half = PLAN_M / 2.0 + 3.0
    walls = _box(0.0, 0.0, half, half)
    for side in range(4):
        turn = SE2(0.0, 0.0, side * np.pi / 2.0)
        lines = _wall_with_doors(inner, inner, rng) + _wall_with_doors(outer, outer, rng)
        for x in np.sort(rng.uniform(-inner, inner, 2)):
            lines.append((outer, x, half, x))
            lines.append((inner, x * 0.5, 2.0, x * 0.5))
        for _ in range(4):
            lines += _cupboard(rng, inner, outer)
        for x1, y1, x2, y2 in lines:
            ends = turn @ np.array([[x1, y1], [x2, y2]])
            walls.append((*ends[0], *ends[1]))
    return np.array(walls)


def _wall_with_doors(x: float, reach: float, rng: np.random.Generator) -> list[tuple]:
    cuts = np.sort(rng.uniform(-reach + 1.0, reach - 1.0, 2))
    edges = [-reach, cuts[0] - 0.45, cuts[0] + 0.45, cuts[1] - 0.45, cuts[1] + 0.45, reach]
    pieces = [(x, a, x, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a]
    return pieces


def _cupboard(rng: np.random.Generator, inner: float, outer: float) -> list[tuple]:
    """Return a cupboard standing at one of the corridor's walls."""
    width, depth, y = rng.uniform(0.4, 1.2), rng.uniform(0.3, 0.5), rng.uniform(-5.0, 5.0)
    x = inner + depth / 2.0 if rng.random() < 0.5 else outer - depth / 2.0
    return _box(x, y, depth / 2.0, width / 2.0)


def _box(x: float, y: float, dx: float, dy: float) -> list[tuple]:
    c = [(x - dx, y - dy), (x + dx, y - dy), (x + dx, y + dy), (x - dx, y + dy)]
    return [(*c[k], *c[(k + 1) % 4]) for k in range(4)]


def _path(num_scans: int) -> list[SE2]:
    """Return evenly spaced poses round the middle of the corridor, with rounded corners."""
    a, r = 6.5 + CORRIDOR_M / 2.0, CORNER_RADIUS_M
    straight, arc = 2.0 * (a - r), r * np.pi / 2.0
    total = 4.0 * (straight + arc)
    poses = []
    for s in np.linspace(0.0, total, num_scans):
        leg, rest = divmod(s, straight + arc)
        if rest <= straight:
            local = SE2(a, -(a - r) + rest, np.pi / 2.0)
        else:
            phi = (rest - straight) / r
            x, y = a - r + r * np.cos(phi), a - r + r * np.sin(phi)
            local = SE2(float(x), float(y), np.pi / 2.0 + phi)
        poses.append(SE2(0.0, 0.0, leg * np.pi / 2.0) @ local)
    return poses


def bare_corridor(num_beams: int, fov_rad: float, seed: int, num_scans: int = 200) -> Drive:
    """Make a straight drive of 20 m in a corridor of 60 x 2.4 m whose ends are out of range."""
    rng = np.random.default_rng(seed)
    walls = np.array(_box(0.0, 0.0, 30.0, 1.2))
    truth = [SE2(float(x), 0.0, 0.0) for x in np.linspace(-10.0, 10.0, num_scans)]
    return Drive([_scan(walls, pose, num_beams, fov_rad, rng, 12.0) for pose in truth], truth)


def slipping_odometry(truth: list[SE2], seed: int, slip: float = 0.1) -> list[SE2]:
    """Return odometry of wheels that slip.

    Distance and turn are each wrong by a share drawn once per run (uniform up to `slip`) and by
    2 % white noise a step.
    """
    rng = np.random.default_rng(seed)
    scale = 1.0 + rng.uniform(-slip, slip, 2)
    odometry = [truth[0]]
    for a, b in zip(truth, truth[1:], strict=False):
        moved = a.between(b)
        along, turn = scale * (1.0 + rng.normal(0.0, 0.02, 2))
        odometry.append(odometry[-1] @ SE2(along * moved.x, along * moved.y, turn * moved.yaw))
    return odometry


def _scan(
    walls: np.ndarray, pose: SE2, num_beams: int, fov_rad: float, rng: np.random.Generator,
    range_max: float = RANGE_MAX_M,
) -> Scan:  # fmt: skip
    is_full_turn = np.isclose(fov_rad, 2.0 * np.pi)
    increment = fov_rad / (num_beams if is_full_turn else num_beams - 1)
    angles = pose.yaw - fov_rad / 2.0 + increment * np.arange(num_beams)
    ranges = ray_cast(np.array([pose.x, pose.y]), angles, walls)
    ranges = ranges + rng.normal(0.0, RANGE_SIGMA_M, num_beams)
    ranges[ranges > range_max] = np.inf
    return Scan(ranges, -fov_rad / 2.0, increment, 0.05, range_max)
