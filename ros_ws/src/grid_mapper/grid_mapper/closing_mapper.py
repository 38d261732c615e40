"""A live mapper that closes loops: poses and maps at once, corrected from the background.

Every scan is followed by the front end and mapped at its pose as the graph had it last. What maps
are made from goes to the background too (`LoopSession`). Maps made anew there take the place
of the old ones, and the new correction that of the old, once they are up to now (`LoopLink`).
"""

from __future__ import annotations

import time
from dataclasses import astuple, replace

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.background import Worker
from grid_mapper.config import GridMapperConfig
from grid_mapper.corrections import NO_NODE, Corrections
from grid_mapper.front_end import FrontEnd, in_map
from grid_mapper.kept_events import KeptReading, KeptScan, ReadingsToKeep
from grid_mapper.key_scans import KeyScans
from grid_mapper.layers import LayeredMapper, SonarCounts
from grid_mapper.layers_moment import Layers, LayersMoment
from grid_mapper.loop_link import LoopLink
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.loop_session import GraphState, Rebuilt
from grid_mapper.match_verdict import ScanResult
from grid_mapper.motion import rotated
from grid_mapper.opaque_cells import APART
from grid_mapper.placed_readings import PlacedReadings
from grid_mapper.surface_points import SurfacePoints, points_of
from grid_mapper.sweeps import SweepOrder


class ClosingMapper:
    """Turns scans and sonar readings into poses and layers, with loops closed.

    Attributes:
        config: Its values; change them with `reconfigure`.
        link: To the background.
        corrections: What poses are corrected by; another object after each correction.
        node: The newest node.
        num_swaps: How often maps made anew took the place of the old.
        longest_wait_ms: The longest that a scan waited for news of the background to be taken.
    """

    def __init__(self, config: GridMapperConfig, worker: Worker) -> None:
        self.config, self.link = config, LoopLink(worker)
        self._num_changes_before, self.longest_wait_ms = 0, 0.0
        self._has_jumped = False
        self._empty()

    def reset(self) -> None:
        """Forget the maps, the pose and the graph."""
        self.link.restart(self.config)
        self._empty()

    def reconfigure(self, config: GridMapperConfig) -> None:
        """Go on with other values; those of `loop` stay as they were."""
        self.config = config
        self.link.reconfigure(config)
        self._front.reconfigure(config)
        self._maps.reconfigure(config)

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanResult:
        """Localize and map one scan; see `LayeredMapper.insert_scan`."""
        self.take_news()
        clipped = self.config.clipped(scan)
        scan = self._front.deskewed(stamp_ns, clipped, T_base_laser, T_odom_base)
        result, is_node = self._front.follow(stamp_ns, scan, T_base_laser, T_odom_base)
        if result.is_trusted:
            self._keep_scan(stamp_ns, scan, T_base_laser, result, is_node)
        return in_map(result, self._T_map_local)

    def insert_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str
    ) -> None:
        """Take one sonar reading; see `LayeredMapper.insert_range`."""
        self._readings.push(stamp_ns, reading, T_base_sonar, sensor)
        self._place_readings()

    def relocate(
        self, T_map_base: SE2, cov: np.ndarray | None = None, seen: SurfacePoints | None = None
    ) -> None:
        """Go on from another pose; see `ScanLocalizer.relocate`.

        Args:
            T_map_base: About where the robot is.
            cov: Of (x, y, yaw) in map axes, shape (3, 3).
            seen: What is known of the surroundings, in the map frame.
        """
        T_local_map = self._T_map_local.inverse()
        if seen is not None:
            self._front.see([(seen, T_local_map)])
        turned = None if cov is None else rotated(cov, T_local_map.yaw)
        self._front.relocate(T_local_map @ T_map_base, turned)
        self._has_jumped = True
        self._readings.break_here()

    def take_up(self, before: LoopClosingLocalizer) -> None:
        """Go on with a session; the robot is looked for near its last and its first pose."""
        frames, numbers = before.closer.frames, before.first_seen()
        self._front, self.node = before.front, len(frames) - 1
        self._first_seen[:] = [(k, frames[k].points, frames[k].T_local_base) for k in numbers]
        self.corrections = before.corrections()
        self._T_map_local = self.corrections.T_map_local
        self.break_motion()

    def lose(self) -> None:
        """Follow odometry alone until `relocate`; see `ScanLocalizer.lose`."""
        self._front.lose()

    def break_motion(self) -> None:
        """Forget the motion so far: time or odometry jumped. Maps and pose stay."""
        T_local_map = self._T_map_local.inverse()
        if self._first_seen:
            poses = [self.corrections.at(k, pose) for k, _, pose in self._first_seen]
            seen = zip((points for _, points, _ in self._first_seen), poses, strict=True)
            self._front.see((points, T_local_map @ pose) for points, pose in seen)
            self._front.break_motion(T_local_map @ poses[0])
            self._has_jumped = True
        self._readings.clear()

    def in_local(self, T_map_base: SE2) -> SE2:
        """Return a pose of now in the front end's frame; `corrections` brings it back."""
        return self._T_map_local.inverse() @ T_map_base

    def moment(self) -> LayersMoment:
        """Return what makes all maps as they stand; quick, however large the floor is."""
        return self._maps.moment()

    def layers(self) -> Layers:
        """Return all maps as they stand."""
        return self.moment().layers()

    @property
    def sweeps(self) -> SweepOrder:
        """In which order the beams of a scan are taken."""
        return self._front.sweeps

    @property
    def num_changes(self) -> int:
        """Grows whenever one of the maps may have changed."""
        return self._num_changes_before + self._maps.num_changes

    @property
    def sonar_counts(self) -> SonarCounts:
        """What became of readings so far."""
        before, now = self._counts_before, self._maps.sonar_counts
        pairs = zip(astuple(before), astuple(now), strict=True)
        return replace(
            SonarCounts(*(a + b for a, b in pairs)), unplaced=self._readings.num_unplaced
        )

    @property
    def num_bytes(self) -> int:
        """Bytes held here by what scans are fitted to and the maps."""
        return self._front.num_bytes + self._maps.num_bytes

    @property
    def graph(self) -> GraphState:
        """How the graph was when last heard of."""
        return self.link.graph

    @property
    def failure(self) -> str:
        """Why no loops are closed any more; "" while they are."""
        return self.link.failure

    @property
    def longest_hold_up_ms(self) -> float:
        """The longest that a scan can have waited: for news, behind an answer being read."""
        return self.longest_wait_ms + self.link.longest_read_ms

    def close(self) -> None:
        """End the background."""
        self.link.close()

    def _keep_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, result: ScanResult, is_node: bool
    ) -> None:
        pose = result.T_map_base
        self.node += is_node
        if is_node and len(self._first_seen) <= self.config.loop.submap_nodes:
            points = points_of(scan, T_base_laser, self.config.matcher)
            self._first_seen.append((self.node, points, pose))
        is_apart = self._apart.take(stamp_ns, pose, APART)
        self._readings.add_pose(stamp_ns, pose)
        self._maps.place_scan(stamp_ns, scan, T_base_laser, self._T_map_local @ pose)
        if is_node or is_apart:
            match = (is_node, result.information, is_node and self._has_jumped)
            seen = (scan, T_base_laser, pose, self.node, *match)
            self._has_jumped &= not is_node
            self.link.send(KeptScan, stamp_ns, *seen)
        self._place_readings()

    def _empty(self) -> None:
        """Begin with empty maps, at the first pose of all."""
        config = self.config
        self.num_swaps = 0
        self.corrections = Corrections.of([], [])
        self.node = NO_NODE
        self._has_jumped = False
        self._T_map_local = SE2.identity()
        self._front, self._maps = FrontEnd(config), LayeredMapper(config)
        self._readings, self._to_keep = PlacedReadings(), ReadingsToKeep(config.bayes)
        self._apart, self._counts_before = KeyScans(), SonarCounts()
        self._first_seen: list[tuple[int, SurfacePoints, SE2]] = []

    def _place_readings(self) -> None:
        """Map the readings that the newest scan has caught up with."""
        for w, pose in self._readings.take(self.config.sonar.max_pose_gap_s):
            place = (w.T_base_sonar, w.sensor, self._T_map_local @ pose)
            self._maps.place_range(w.stamp_ns, w.reading, *place)
            if self._to_keep.take(w.stamp_ns, w.reading, pose, w.sensor):
                seen = (w.stamp_ns, w.reading, w.T_base_sonar, pose, self.node, w.sensor)
                self.link.send(KeptReading, *seen)

    def take_news(self) -> None:
        """Take what the background has to say; every scan does so."""
        started = time.perf_counter()
        if (rebuilt := self.link.take()) is not None:
            self._swap(rebuilt)
        self.longest_wait_ms = max(self.longest_wait_ms, 1e3 * (time.perf_counter() - started))

    def _swap(self, rebuilt: Rebuilt) -> None:
        """Let the new maps and the new correction take the place of the old."""
        self.num_swaps += 1
        new = rebuilt.mapper
        self._num_changes_before = self.num_changes + 1 - new.num_changes
        pairs = zip(astuple(self.sonar_counts), astuple(new.sonar_counts), strict=True)
        self._counts_before = SonarCounts(*(a - b for a, b in pairs))
        self._maps = new
        self._maps.reconfigure(self.config)
        self.corrections = rebuilt.corrections
        self._T_map_local = rebuilt.corrections.T_map_local
