"""Floors for `relocalization`: the generator's, mapped from a drive, then looked at anew.

A floor is cut at the laser's height; beams meet what is opaque there, and a pane of glass only near
its normal. The drive follows the floor's route twice with wheels that slip, and its recording is
mapped as `map_bag` does, loops closed; the map goes through its file, three values a cell. After
that furniture moves: some is away, some shifted, and people and boxes stand about.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.corridor_loop import slipping_odometry
from experiments.glass_rays import first_hits
from experiments.glass_truth import distance_to_segments
from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.map_files import load_map, save_map
from grid_mapper.map_rebuild import MapRebuild
from sim_bridge.config import LaserConfig
from sim_bridge.laser import beam_angles, measure
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import load_world

FIRST_FLOOR = 9600
"""Floors of the experiment; values were set on 9000 to 9101, 9500 to 9504 and `--seed` 100."""
GLASS_SHARE = 0.2
LASER = LaserConfig()
LASER_HEIGHT_M = 0.35
STEP_M, STEP_RAD, STEP_NS = 0.1, 0.2, 150_000_000
LAPS = 2
PANE_RAD = np.deg2rad(5.0)
AWAY_SHARE, SHIFTED_SHARE, SHIFT_M = 0.15, 0.25, 0.8
NUM_STANDING = 6
CLEAR_M, WALK_CLEAR_M = 0.45, 0.35
HERE = SE2.identity()


@dataclass(frozen=True)
class Cut:
    """A floor at the laser's height: rows (x1, y1, x2, y2), m."""

    opaque: np.ndarray
    panes: np.ndarray

    @property
    def all(self) -> np.ndarray:
        """Opaque things and panes."""
        return np.vstack((self.opaque, self.panes))


@dataclass(frozen=True)
class MappedFloor:
    """A floor with the map that a drive made of it.

    Attributes:
        name: Of the floor.
        now: The floor by now, things moved.
        grid: The map.
        driven: True poses of the drive.
        mapped: The same poses in the map.
    """

    name: str
    now: Cut
    grid: OccupancyMap
    driven: list[SE2]
    mapped: list[SE2]

    def in_map(self, pose: SE2) -> SE2:
        """Return where a true pose lies in the map: as the drive's pose nearest to it does."""
        k = int(np.argmin([np.hypot(p.x - pose.x, p.y - pose.y) for p in self.driven]))
        return self.mapped[k] @ self.driven[k].between(pose)


def mapped_floor(number: int) -> MappedFloor:
    """Drive through a floor, map it, and move things."""
    name, rng = f"generated:{number}:{GLASS_SHARE:g}", np.random.default_rng((number, 3))
    world = load_world(name)
    solids = [solid for solid in solids_of(world) if solid.is_at_height(LASER_HEIGHT_M)]
    before = cut_of(solids)
    assert world.route is not None
    truth = _poses_along(np.array(LAPS * tuple(world.route.waypoints_m), float))
    scans = [look_at(before, pose, rng) for pose in truth]
    grid, mapped = _mapped(scans, slipping_odometry(truth, number))
    return MappedFloor(name, _moved_about(solids, rng), grid, truth, mapped)


def cut_of(solids: list[Solid]) -> Cut:
    """Return the outlines of solids."""
    opaque = [_edges(solid) for solid in solids if solid.glass is None]
    panes = [_edges(solid) for solid in solids if solid.glass is not None]
    nothing = np.zeros((0, 4))
    return Cut(np.vstack([nothing, *opaque]), np.vstack([nothing, *panes]))


def look_at(cut: Cut, pose: SE2, rng: np.random.Generator) -> Scan:
    """Return a scan taken at a pose."""
    angles = pose.yaw + beam_angles(LASER)
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    place = np.array([pose.x, pose.y])
    distances, _ = first_hits(place, rays, cut.opaque)
    if len(cut.panes):
        to_pane, which = first_hits(place, rays, cut.panes)
        along = cut.panes[which, 2:] - cut.panes[which, :2]
        along /= np.hypot(*along.T)[:, None]
        is_straight = np.abs((rays * along).sum(axis=1)) < np.sin(PANE_RAD)
        seen = (which >= 0) & is_straight & (to_pane < distances)
        distances = np.where(seen, to_pane, distances)
    distances[distances > LASER.range_max_m] = np.inf
    return measure(LASER, distances, rng)


def places(floor: MappedFloor, num: int, rng: np.random.Generator) -> list[SE2]:
    """Return random poses in what the map shows free, not close to anything."""
    rows, cols = np.nonzero(floor.grid.cells == 0)
    centers = floor.grid.origin @ ((np.column_stack((cols, rows)) + 0.5) * floor.grid.resolution)
    found: list[SE2] = []
    while len(found) < num:
        T_map = SE2(*centers[rng.integers(len(centers))].tolist(), 0.0)
        near = int(np.argmin([p.between(T_map).distance for p in floor.mapped]))
        pose = floor.driven[near] @ floor.mapped[near].between(T_map)
        pose = SE2(pose.x, pose.y, float(rng.uniform(-np.pi, np.pi)))
        if _clearance(floor.now, pose) > CLEAR_M:
            found.append(pose)
    return found


def walk(floor: MappedFloor, start: SE2, way_m: float, rng: np.random.Generator) -> list[SE2]:
    """Return poses of a short drive from a place: ahead while that is free, else turning."""
    poses, way, side = [start], 0.0, float(rng.choice([-1.0, 1.0]))
    while way < way_m and len(poses) < 400:
        ahead = poses[-1] @ SE2(STEP_M, 0.0, float(rng.normal(0.0, 0.02)))
        if _clearance(floor.now, ahead) > WALK_CLEAR_M:
            poses.append(ahead)
            way += STEP_M
        else:
            poses.append(poses[-1] @ SE2(0.0, 0.0, side * STEP_RAD))
    return poses


def _clearance(cut: Cut, pose: SE2) -> float:
    return float(distance_to_segments(np.array([[pose.x, pose.y]]), cut.all)[0])


def _edges(solid: Solid) -> np.ndarray:
    corners = solid.outline()
    return np.hstack((corners, np.roll(corners, -1, axis=0)))


def _poses_along(points: np.ndarray) -> list[SE2]:
    """Return poses along a line of waypoints, a step apart, turning on the spot."""
    poses: list[SE2] = []
    for a, b in zip(points, points[1:], strict=False):
        length = float(np.hypot(*(b - a)))
        if length < 1e-6:
            continue
        yaw = float(np.arctan2(b[1] - a[1], b[0] - a[0]))
        if poses:
            turn = SE2(0.0, 0.0, poses[-1].yaw).between(SE2(0.0, 0.0, yaw)).yaw
            num = int(abs(turn) / STEP_RAD)
            last = poses[-1]
            poses += [
                SE2(last.x, last.y, last.yaw + turn * (k + 1) / (num + 1)) for k in range(num)
            ]
        for s in np.arange(0.0, length, STEP_M):
            x, y = a + (b - a) * (s / length)
            poses.append(SE2(float(x), float(y), yaw))
    return poses


def _mapped(scans: list[Scan], odometry: list[SE2]) -> tuple[OccupancyMap, list[SE2]]:
    """Return the map of a drive, as its file has it, and the poses in it."""
    config = GridMapperConfig()
    localizer, mapper = LoopClosingLocalizer(config), LayeredMapper(config)
    for k, (scan, odom) in enumerate(zip(scans, odometry, strict=True)):
        localizer.insert_scan(k * STEP_NS, scan, HERE, odom)
    localizer.closer.finish()
    known = localizer.known_poses()
    rebuild = MapRebuild(mapper, known)
    for k, scan in enumerate(scans):
        rebuild.insert_scan(k * STEP_NS, scan, HERE, None)
    with tempfile.TemporaryDirectory() as folder:
        path = save_map(Path(folder) / "floor", mapper.occupancy())
        return load_map(path), [pose.T_map_base for pose in known]


def _moved_about(solids: list[Solid], rng: np.random.Generator) -> Cut:
    """Return the floor with furniture away or shifted, and people and boxes that stand about."""
    now = []
    for solid in solids:
        if solid.name == "wall" or solid.glass is not None or max(solid.size[:2]) > 3.0:
            now.append(solid)
            continue
        chance = float(rng.random())
        if chance < AWAY_SHARE:
            continue
        if chance < AWAY_SHARE + SHIFTED_SHARE:
            x, y, turn = rng.uniform(-SHIFT_M, SHIFT_M, 3).tolist()
            pose = SE2(solid.pose.x + x, solid.pose.y + y, solid.pose.yaw + turn)
            solid = replace(solid, pose=pose)
        now.append(solid)
    corners = np.vstack([solid.outline() for solid in solids])
    for _ in range(NUM_STANDING):
        x, y = rng.uniform(corners.min(axis=0) + 0.5, corners.max(axis=0) - 0.5).tolist()
        size = float(rng.uniform(0.25, 0.6))
        pose, is_round = SE2(x, y, float(rng.uniform(0.0, np.pi))), bool(rng.random() < 0.5)
        now.append(Solid("standing", pose, (size, size, 1.7), 0.0, is_round, (0.5, 0.5, 0.5)))
    return cut_of(now)
