"""What truly stands in a glass world, as a map of it is judged by: distances, glass faced, behind.

Everything lies on one lattice of cells round the world, so that it is found once for all rows.
Functions are pure: segments are rows (x1, y1, x2, y2), m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from experiments.glass_logs import GlassLog
from experiments.glass_rays import count_faced, first_hits
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

RESOLUTION_M = 0.05
NEAR_PATH_M = 2.0
MIN_FACED = 3
SAMPLE_M = 0.05
APART_M = 0.10
BEHIND_FROM_M = 0.15
_MARGIN_M = 1.0
_NEAR_M = 0.5
_PLACE_STEP_M = 0.4
_NUM_RAYS = 2880
_BLOCK_SLACK_M = 0.03
_STEEPEST = 0.2  # cosine of incidence; steeper rays would end far away


@dataclass(frozen=True)
class Truth:
    """A world on a lattice, with the drive that mapped it.

    Attributes:
        lattice: Empty map that says where the cells are.
        to_real: Distance of each cell's center to the nearest footprint of anything at any
            height, shape (H, W), m; inside negative, beyond 0.5 m infinite.
        to_opaque: To the nearest surface of a thing, not of glass, that the laser's plane cuts.
        to_glass: To the nearest pane's middle line.
        is_behind: Whether the robot saw the cell through a pane; see `seen_through_glass`.
        opaque: Outlines of what the laser's plane cuts, glass left out, as segments.
        panes: Middle lines of panes.
        glass: Points of the panes every 5 cm, shape (N, 2).
        is_faced: Of these, which lie within 2 m of the path and were faced by a sonar three times
            or more; see `times_faced`.
        is_apart: Of these, which have nothing opaque within 10 cm.
        path: True positions of the robot, shape (S, 2).
        solids: What stands there.
    """

    lattice: OccupancyMap
    to_real: np.ndarray
    to_opaque: np.ndarray
    to_glass: np.ndarray
    is_behind: np.ndarray
    opaque: np.ndarray
    panes: np.ndarray
    glass: np.ndarray
    is_faced: np.ndarray
    is_apart: np.ndarray
    path: np.ndarray
    solids: list[Solid]


def truth_of(log: GlassLog) -> Truth:
    """Return what a map made from a log is judged by."""
    solids, height = log.solids(), float(log.laser_height)
    cut = [s for s in solids if s.glass is None and s.is_at_height(height)]
    panes = pane_lines([s for s in solids if s.is_at_height(height)])
    lattice = lattice_round(np.vstack([s.outline() for s in solids]))
    centers = centers_of(lattice)
    shape = lattice.cells.shape
    opaque, glass = outlines(cut), samples(panes)
    to_real = signed_distance_near(lattice, solids)
    way = thinned(log.scan_true[:, :2], RESOLUTION_M)
    is_near = distance_to_segments(glass, np.hstack((way[:-1], way[1:]))) <= NEAR_PATH_M
    return Truth(
        lattice=lattice,
        to_real=to_real,
        to_opaque=np.abs(signed_distance_near(lattice, cut)),
        to_glass=distance_to_segments(centers, panes).reshape(shape),
        is_behind=seen_through_glass(
            thinned(log.scan_true[:, :2], _PLACE_STEP_M), opaque, panes, lattice
        ),
        opaque=opaque,
        panes=panes,
        glass=glass,
        is_faced=is_near & (times_faced(log, glass, panes, opaque) >= MIN_FACED),
        is_apart=distance_to_segments(glass, opaque) > APART_M,
        path=log.scan_true[:, :2],
        solids=solids,
    )  # fmt: skip


def lattice_round(points: np.ndarray) -> OccupancyMap:
    """Return an empty map round points, its cells at whole multiples of the resolution."""
    low = np.floor((points.min(axis=0) - _MARGIN_M) / RESOLUTION_M)
    high = np.ceil((points.max(axis=0) + _MARGIN_M) / RESOLUTION_M)
    cols, rows = (high - low).astype(int)
    x, y = (low * RESOLUTION_M).tolist()
    return OccupancyMap(np.full((rows, cols), -1, np.int8), RESOLUTION_M, SE2(x, y, 0.0))


def centers_of(lattice: OccupancyMap) -> np.ndarray:
    """Return the centers of all cells, row by row, shape (H * W, 2), m."""
    rows, cols = lattice.cells.shape
    return lattice.to_points(np.indices((rows, cols)).reshape(2, -1).T)


def signed_distance_near(lattice: OccupancyMap, solids: list[Solid]) -> np.ndarray:
    """Return the distance of each cell's center to the nearest footprint's edge, (H, W), m.

    Inside it is negative. Farther than 0.5 m from everything it is infinite.
    """
    distances = np.full(lattice.cells.shape, np.inf)
    for solid in solids:
        outline = solid.outline()
        corners = np.array((outline.min(axis=0) - _NEAR_M, outline.max(axis=0) + _NEAR_M))
        (r0, c0), (r1, c1) = np.clip(lattice.to_cells(corners), 0, distances.shape)
        cells = np.stack(np.meshgrid(np.arange(r0, r1), np.arange(c0, c1), indexing="ij"), axis=-1)
        there = solid.signed_distance(lattice.to_points(cells.reshape(-1, 2)))
        part = distances[r0:r1, c0:c1]
        np.minimum(part, there.reshape(part.shape), out=part)
    return np.where(distances < _NEAR_M, distances, np.inf)


def outlines(solids: list[Solid]) -> np.ndarray:
    """Return the edges of footprints, shape (M, 4)."""
    edges = [np.hstack((o, np.roll(o, -1, axis=0))) for o in (s.outline() for s in solids)]
    return np.vstack(edges) if edges else np.zeros((0, 4))


def pane_lines(solids: list[Solid]) -> np.ndarray:
    """Return the middle lines of the panes among solids, shape (P, 4)."""
    corners = [s.outline() for s in solids if s.glass is not None]
    return np.array([[*(c[0] + c[3]) / 2.0, *(c[1] + c[2]) / 2.0] for c in corners]).reshape(-1, 4)


def samples(segments: np.ndarray, step: float = SAMPLE_M) -> np.ndarray:
    """Return the middles of equal pieces of about `step` of all segments, shape (N, 2), m."""
    points = []
    for x1, y1, x2, y2 in segments:
        num = max(round(math.hypot(x2 - x1, y2 - y1) / step), 1)
        share = (np.arange(num) + 0.5) / num
        points.append(np.column_stack((x1 + share * (x2 - x1), y1 + share * (y2 - y1))))
    return np.vstack(points) if points else np.zeros((0, 2))


def distance_to_segments(points: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Return the distance of each point (N, 2) to the nearest segment, shape (N,), m."""
    nearest = np.full(len(points), np.inf)
    for x1, y1, x2, y2 in segments:
        a, along = np.array((x1, y1)), np.array((x2 - x1, y2 - y1))
        squared = float(along @ along)
        share = np.clip((points - a) @ along / squared, 0.0, 1.0) if squared > 0.0 else 0.0
        off = points - a - np.multiply.outer(share, along)
        nearest = np.minimum(nearest, np.hypot(off[..., 0], off[..., 1]))
    return nearest


def thinned(points: np.ndarray, step: float) -> np.ndarray:
    """Return points of a way at least `step` (m) from the one kept before."""
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) >= step:
            kept.append(point)
    return np.array(kept)


def times_faced(
    log: GlassLog, points: np.ndarray, panes: np.ndarray, opaque: np.ndarray
) -> np.ndarray:
    """Return how often a sonar faced each point of the glass, shape (N,).

    A firing faces a point that lies in its cone and range, whose pane it meets within its critical
    angle there, with nothing opaque and no other pane between.
    """
    opening, _, reach, critical = log.sonar_limits.tolist()
    firings = []
    for number, (x, y, yaw) in enumerate(log.sonar_poses):
        base = log.range_true[log.range_sensor == number]
        c, s = np.cos(base[:, 2]), np.sin(base[:, 2])
        place = (base[:, 0] + c * x - s * y, base[:, 1] + s * x + c * y)
        firings.append(np.column_stack((*place, base[:, 2] + yaw)))
    return count_faced(
        np.vstack(firings), points, _normals_at(points, panes), np.vstack((opaque, panes)),
        opening / 2.0, reach, critical, _BLOCK_SLACK_M,
    )  # fmt: skip


def seen_through_glass(
    places: np.ndarray, opaque: np.ndarray, panes: np.ndarray, lattice: OccupancyMap
) -> np.ndarray:
    """Return which cells a robot looked at through a pane, shape (H, W).

    They lie on a ray from one of the places that has crossed a pane and met nothing opaque, more
    than 0.15 m behind the first pane crossed, measured square to it, however far.

    Args:
        places: Of the robot, shape (N, 2), m.
        opaque: What stops rays.
        panes: What they cross.
        lattice: The cells.
    """
    is_behind = np.zeros(lattice.cells.shape, bool)
    if not len(panes):
        return is_behind
    angles = np.linspace(-np.pi, np.pi, _NUM_RAYS, endpoint=False)
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    normals, step = _pane_normals(panes), 0.6 * lattice.resolution
    far = float(np.hypot(*lattice.cells.shape)) * lattice.resolution
    for place in places:
        first, which = first_hits(place, rays, panes)
        crosses = np.flatnonzero(which >= 0)
        stop, _ = first_hits(place, rays[crosses], opaque)
        square = np.abs(np.einsum("ij,ij->i", rays[crosses], normals[which[crosses]]))
        start = first[crosses] + BEHIND_FROM_M / np.maximum(square, _STEEPEST)
        num = np.ceil((np.minimum(stop, far) - start) / step).clip(0).astype(int)
        ray = np.repeat(np.arange(len(crosses)), num)
        along = start[ray] + step * (np.arange(num.sum()) - np.repeat(np.cumsum(num) - num, num))
        cells = lattice.to_cells(place + along[:, None] * rays[crosses][ray])
        inside = ((cells >= 0) & (cells < is_behind.shape)).all(axis=1)
        is_behind[tuple(cells[inside].T)] = True
    return is_behind


def _pane_normals(panes: np.ndarray) -> np.ndarray:
    along = panes[:, 2:] - panes[:, :2]
    length = np.hypot(*along.T)[:, None]
    return np.column_stack((-along[:, 1], along[:, 0])) / length


def _normals_at(points: np.ndarray, panes: np.ndarray) -> np.ndarray:
    """Return the normal of the pane nearest to each point, shape (N, 2)."""
    if not len(panes):
        return np.zeros((0, 2))
    distances = [distance_to_segments(points, pane[None]) for pane in panes]
    return _pane_normals(panes)[np.argmin(distances, axis=0)]
