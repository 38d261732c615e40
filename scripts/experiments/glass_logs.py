"""Sensor logs of drives past glass: what laser, sonars and odometry gave, and the truth apart.

The simulation is the slow part, so a drive is kept as a file and mapped again from it by every
method. The robot follows the world's route by its true pose; its odometry drifts as its wheels do.
"""

from __future__ import annotations

import heapq
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from experiments.glass_drive import follow_route
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.recordings.events import RangeEvent, ScanEvent
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import load_world

SPEED_M_S = 0.4
_FORMAT = 1  # of the files; another one is driven anew


@dataclass(frozen=True)
class GlassLog:
    """One drive. Poses are rows (x, y, yaw), m and rad; `true` ones are of the base in the world.

    Attributes:
        world: Name or path of the world, as `load_world` takes it.
        seed: Of the drive.
        scan_ns: Stamp of each scan, shape (S,).
        scan_ranges: Shape (S, B), m.
        scan_odom: Odometry at each scan, shape (S, 3).
        scan_true: True pose at each scan, shape (S, 3).
        range_ns: Stamp of each reading of a sonar, shape (R,); only of sonars that fired.
        range_sensor: Number of the sonar, shape (R,).
        range_m: What it read, shape (R,), m.
        range_odom: Odometry at each reading, shape (R, 3).
        range_true: True pose at each reading, shape (R, 3).
        laser_limits: Angle of the first beam, step, shortest and longest range, shape (4,).
        sonar_limits: Opening, shortest and longest range, critical angle, shape (4,).
        laser_pose: `T_base_laser`, shape (3,).
        laser_height: Of the laser above the floor, shape (), m.
        sonar_poses: `T_base_sonar` of each, shape (K, 3).
        num_touches: Steps in which the robot touched anything, shape ().
        is_complete: Whether it came to the end of its route, shape ().
    """

    world: str
    seed: int
    scan_ns: np.ndarray
    scan_ranges: np.ndarray
    scan_odom: np.ndarray
    scan_true: np.ndarray
    range_ns: np.ndarray
    range_sensor: np.ndarray
    range_m: np.ndarray
    range_odom: np.ndarray
    range_true: np.ndarray
    laser_limits: np.ndarray
    sonar_limits: np.ndarray
    laser_pose: np.ndarray
    laser_height: np.ndarray
    sonar_poses: np.ndarray
    num_touches: np.ndarray
    is_complete: np.ndarray

    @property
    def T_base_laser(self) -> SE2:  # noqa: N802, frames rule of the transforms
        """Pose of the laser on the robot."""
        return SE2(*self.laser_pose.tolist())

    @property
    def start(self) -> SE2:
        """True pose at the first scan."""
        return SE2(*self.scan_true[0].tolist())

    def solids(self) -> list[Solid]:
        """Return what truly stands in the world."""
        return solids_of(load_world(self.world))

    def scan(self, index: int) -> ScanEvent:
        """Return a scan as recordings give it."""
        angle_min, step, low, high = (float(v) for v in self.laser_limits)
        scan = Scan(self.scan_ranges[index], angle_min, step, low, high)
        T_odom_base = SE2(*self.scan_odom[index].tolist())
        return ScanEvent(int(self.scan_ns[index]), scan, self.T_base_laser, T_odom_base)

    def range(self, index: int) -> RangeEvent:
        """Return a sonar's reading as recordings give it."""
        number = int(self.range_sensor[index])
        opening, low, high = (float(v) for v in self.sonar_limits[:3])
        return RangeEvent(
            int(self.range_ns[index]), f"sonar_{number}", float(self.range_m[index]), low, high,
            opening, SE2(*self.sonar_poses[number].tolist()), SE2(*self.range_odom[index]),
        )  # fmt: skip

    def events(self) -> Iterator[tuple[ScanEvent | RangeEvent, SE2]]:
        """Yield scans and readings in time order, each with the true pose of the base then."""
        scans = ((int(ns), 0, k) for k, ns in enumerate(self.scan_ns))
        ranges = ((int(ns), 1, k) for k, ns in enumerate(self.range_ns))
        for _, kind, k in heapq.merge(scans, ranges):
            if kind == 0:
                yield self.scan(k), SE2(*self.scan_true[k].tolist())
            else:
                yield self.range(k), SE2(*self.range_true[k].tolist())

    def save(self, path: Path) -> None:
        """Write the log as a file."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        partial = path.with_suffix(".partial.npz")
        np.savez_compressed(partial, format=_FORMAT, **values)
        partial.replace(path)


def load_log(path: Path) -> GlassLog | None:
    """Return a log that was saved; None if there is none, or one of another version."""
    if not path.exists():
        return None
    with np.load(path) as file:
        names = {f.name for f in fields(GlassLog)}
        if int(file["format"]) != _FORMAT or not names <= set(file.files):
            return None
        values = {name: file[name] for name in names - {"world", "seed"}}
        return GlassLog(world=str(file["world"]), seed=int(file["seed"]), **values)


def drive(
    world: str | Path, seed: int, speed: float = SPEED_M_S, cache: Path | None = None
) -> GlassLog:
    """Return the log of one drive along a world's route.

    Args:
        world: Name or path of a world with a robot, a laser, sonars and a route.
        seed: Of every random number in the drive.
        speed: Along the route, m/s.
        cache: Folder of logs; one that is there is not driven again.

    Raises:
        ValueError: The world has no route, or its robot no laser or sonars.
    """
    name = f"{_file_name(str(world))}-{seed}-{speed:g}.npz"
    path = None if cache is None else cache / name
    log = None if path is None else load_log(path)
    if log is None:
        log = GlassLog(world=str(world), seed=seed, **follow_route(str(world), seed, speed))
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            log.save(path)
    return log


def _file_name(world: str) -> str:
    """Return a world's name as a part of a file's; of a file also a mark of what is in it."""
    path = Path(world)
    if path.is_file():
        return f"{path.stem}-{zlib.crc32(path.read_bytes()):08x}"
    return world.replace(":", "-")
