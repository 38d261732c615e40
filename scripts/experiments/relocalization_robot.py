"""A robot in a map as the mapping node has it: told about where it is, or carried off on its way.

The node's own parts are run in turn, scan by scan: the search (`Recovery`, at once instead of in
the background), the scan matcher in the map, and what says that the robot is lost. A pose counts as
sent while the node would send it: not while the robot is lost.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from experiments.corridor_loop import slipping_odometry
from experiments.relocalization_floors import HERE, STEP_NS, MappedFloor, look_at, places, walk
from floornav_common.se2 import SE2
from grid_mapper.background import InlineWorker
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.nodes.lost_robot import LostRobot
from grid_mapper.recovery import Recovery
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.start_map import StartMap
from grid_mapper.tracking import Tracking

STEP_S = 1e-9 * STEP_NS
NEAR_M, NEAR_RAD = 0.10, np.deg2rad(3.0)
ROUGH_SIGMAS = np.array([0.5, 0.5, 0.26])
"""How far off the pose is that the robot is told (m, m, rad; deviations): what RViz sends."""
SETTLED_SIGMAS = np.array([0.05, 0.05, 0.02])
TRACKED_M, AWAY_M = 2.0, 3.0
"""The robot is followed for this way, and then carried further than that."""
NODE = GridMapperNodeConfig(start_map="the floor's", keep_start_map=True)


@dataclass(frozen=True)
class Sent:
    """What the robot said after a scan.

    Attributes:
        pose: The pose that it sent; None while lost.
        is_trusted: Whether the scan's match was believed.
        search_s: Computing time of the search.
    """

    pose: SE2 | None
    is_trusted: bool
    search_s: float


@dataclass(frozen=True)
class Outcome:
    """How it went at one place; times are of the drive, s, from where it began or was carried to.

    Attributes:
        found_s: Until a pose was sent that is right; None if none was.
        search_s: Computing time of all looks until then, or until the end.
        is_false: Whether a scan was believed at a wrong pose once the robot had said that it is
            lost, or at all where it was lost from the beginning.
        lost_s: Until it said that it is lost; None if it never did.
        wrong_s: How long scans were believed at a wrong pose before that.
    """

    found_s: float | None
    search_s: float
    is_false: bool
    lost_s: float | None = None
    wrong_s: float = 0.0


class Robot:
    """Drives in a map that was made before."""

    def __init__(self, floor: MappedFloor, config: GridMapperConfig) -> None:
        start = StartMap(floor.grid, floor.grid)
        recovery = Recovery(config, lambda: InlineWorker(Relocalizer(config)), lambda: start.laser)
        self._mapper = LayeredMapper(config, start=start, is_frozen=True)
        self._lost, self._tracking = LostRobot(self._mapper, recovery, NODE), Tracking()
        self._floor, self._odom, self._stamp_ns = floor, HERE, 0

    def is_said_at(self, pose: SE2, sigmas: np.ndarray) -> None:
        """Tell the robot a pose in the map and its deviations."""
        self._lost.is_said_at(pose, np.diag(sigmas**2))

    def drive(self, poses: list[SE2], rng: np.random.Generator) -> Iterator[tuple[SE2, Sent]]:
        """Drive on through true poses, wherever they are; yield each as the map has it."""
        odometry, begin = slipping_odometry(poses, int(rng.integers(1 << 30))), self._odom
        for pose, odom in zip(poses, odometry, strict=True):
            self._odom = begin @ odometry[0].between(odom)
            sent = self._take(look_at(self._floor.now, pose, rng))
            yield self._floor.in_map(pose), sent

    def _take(self, scan) -> Sent:  # type: ignore[no-untyped-def]
        """Take a scan as `MatchedPoses` does."""
        self._stamp_ns += STEP_NS
        started = time.process_time()
        self._lost.look(scan, HERE, self._odom)
        search_s = time.process_time() - started
        result = self._mapper.insert_scan(self._stamp_ns, scan, HERE, self._odom)
        result = self._lost.checked(self._stamp_ns, scan, HERE, result)
        if self._lost.is_looked_for:
            self._tracking.lose()
        self._tracking.update(self._stamp_ns, result.is_trusted, NODE.lost_after_s)
        is_lost = self._tracking.is_lost
        self._lost.judge(self._stamp_ns, result.is_trusted, is_lost)
        return Sent(None if is_lost else result.T_map_base, result.is_trusted, search_s)


def rough(floor: MappedFloor, start: SE2, way_m: float, rng: np.random.Generator) -> Outcome:
    """Tell a robot that was switched on about where it is, and drive on until it knows."""
    robot = Robot(floor, GridMapperConfig())
    robot.is_said_at(floor.in_map(start) @ SE2(*rng.normal(0.0, ROUGH_SIGMAS)), ROUGH_SIGMAS)
    return _until_known(robot.drive(walk(floor, start, way_m, rng), rng))


def carried(floor: MappedFloor, start: SE2, way_m: float, rng: np.random.Generator) -> Outcome:
    """Carry a robot off that is followed in the map; its wheels do not notice."""
    robot = Robot(floor, GridMapperConfig())
    robot.is_said_at(floor.in_map(start), SETTLED_SIGMAS)
    for _ in robot.drive(walk(floor, start, TRACKED_M, rng), rng):
        pass
    there = next(p for p in iter(lambda: places(floor, 1, rng)[0], None)
                 if p.between(start).distance > AWAY_M + TRACKED_M)  # fmt: skip
    return judged_drive(robot.drive(walk(floor, there, way_m, rng), rng))


def _until_known(drive: Iterator[tuple[SE2, Sent]]) -> Outcome:
    """Return how a robot came out that was lost from the beginning."""
    spent = 0.0
    for k, (true, sent) in enumerate(drive):
        spent += sent.search_s
        if sent.pose is not None and sent.is_trusted:
            is_found = is_right(true, sent.pose)
            return Outcome(k * STEP_S if is_found else None, spent, not is_found)
    return Outcome(None, spent, is_false=False)


def judged_drive(drive: Iterator[tuple[SE2, Sent]]) -> Outcome:
    """Return how a robot came out that does not know that it was carried off."""
    spent, lost_s, wrong_s = 0.0, None, 0.0
    for k, (true, sent) in enumerate(drive):
        spent += sent.search_s
        if sent.pose is None:
            lost_s = k * STEP_S if lost_s is None else lost_s
        elif sent.is_trusted and is_right(true, sent.pose):
            return Outcome(k * STEP_S, spent, is_false=False, lost_s=lost_s, wrong_s=wrong_s)
        elif sent.is_trusted and lost_s is None:
            wrong_s += STEP_S
        elif sent.is_trusted:
            return Outcome(None, spent, is_false=True, lost_s=lost_s, wrong_s=wrong_s)
    return Outcome(None, spent, is_false=False, lost_s=lost_s, wrong_s=wrong_s)


def is_right(true: SE2, claimed: SE2) -> bool:
    """Tell whether a pose is near enough to the true one."""
    off = true.between(claimed)
    return off.distance <= NEAR_M and abs(off.yaw) <= NEAR_RAD
