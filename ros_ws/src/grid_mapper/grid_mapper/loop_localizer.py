"""Poses with loops closed: a front end that never jumps, and a graph that corrects it.

The front end fits each scan to what was seen lately, so its frame drifts; key frames go to the
graph, and a scan's pose in the map is that of the nodes round it, moved on by the front end.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.corrections import Corrections
from grid_mapper.front_end import FrontEnd, key_frame
from grid_mapper.loop_closer import LoopCloser
from grid_mapper.match_verdict import ScanResult
from grid_mapper.sweeps import Sweep, SweepOrder, sweep_of


@dataclass(frozen=True)
class _Followed:
    """A scan's pose by the front end, and the newest node then; `NO_NODE` before the first.

    `sweep` is the motion with which it was matched.
    """

    T_local_base: SE2
    node: int
    is_trusted: bool
    reason: str
    sweep: Sweep | None


@dataclass(frozen=True)
class KnownPose:
    """Where a scan was taken, as all scans together say.

    Attributes:
        T_map_base: Pose of the robot.
        is_trusted: False where the scan's match was refused.
        reason: Why.
        sweep: Motion of the sensor with which the scan was matched; None without.
    """

    T_map_base: SE2
    is_trusted: bool
    reason: str
    sweep: Sweep | None = None


class LoopClosingLocalizer:
    """Localizes scans and closes loops; sonars are passed over, the grids are made afterwards.

    Attributes:
        closer: The graph.
    """

    def __init__(self, config: GridMapperConfig) -> None:
        self.config = config
        self._front = FrontEnd(config)
        self._followed: list[_Followed] = []
        self.closer = LoopCloser(config)
        self._has_jumped = False

    @classmethod
    def behind(
        cls, closer: LoopCloser, scans: Iterable[tuple[SE2, int, Sweep | None]]
    ) -> LoopClosingLocalizer:
        """Return one that goes on, with a jump, where a graph ends.

        Args:
            closer: The graph, of one node at least.
            scans: Pose by the front end, newest node then, and sweep of each scan so far.
        """
        made = cls(closer.config)
        made.closer = closer
        made._followed = [_Followed(T, node, True, "", sweep) for T, node, sweep in scans]
        made.front.begin_after(closer.frames, closer.config.loop.recent_scans)
        return made

    @property
    def front(self) -> FrontEnd:
        """What follows the scans."""
        return self._front

    @property
    def followed(self) -> list[tuple[SE2, int, Sweep | None] | None]:
        """Of each scan what `behind` takes; None where its match was not trusted."""
        return [(f.T_local_base, f.node, f.sweep) if f.is_trusted else None for f in self._followed]

    def corrections(self) -> Corrections:
        """Return what the graph says of poses now."""
        return Corrections.of([f.T_local_base for f in self.closer.frames], self.closer.poses)

    @property
    def sweeps(self) -> SweepOrder:
        """In which order the beams of a scan are taken."""
        return self._front.sweeps

    @property
    def num_scans(self) -> int:
        """Scans taken so far."""
        return len(self._followed)

    def insert_scan(
        self, stamp_ns: int, scan: Scan, T_base_laser: SE2, T_odom_base: SE2 | None
    ) -> ScanResult:
        """Localize one scan; see `ScanLocalizer.localize`. The pose is in the front end's frame."""
        scan = self._front.deskewed(stamp_ns, self.config.clipped(scan), T_base_laser, T_odom_base)
        result, is_node = self._front.follow(stamp_ns, scan, T_base_laser, T_odom_base)
        pose = result.T_map_base
        if is_node:
            seen = (stamp_ns, scan, T_base_laser, pose, result.information)
            self.closer.add(key_frame(*seen, self.config), follows_jump=self._has_jumped)
            self._has_jumped = False
        node = len(self.closer.frames) - 1
        outcome = (result.is_trusted, result.reason, sweep_of(scan))
        self._followed.append(_Followed(pose, node, *outcome))
        return result

    def insert_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str
    ) -> None:
        """Pass a reading over: it moves no pose."""

    def place_range(
        self, stamp_ns: int, reading: RangeReading, T_base_sonar: SE2, sensor: str, T_map_base: SE2
    ) -> None:
        """Pass a reading over."""

    def break_motion(self) -> None:
        """Go on after time or odometry jumped: where the robot was last, or where it began."""
        frames, poses = self.closer.frames, self.closer.poses
        if not frames:
            return
        self._has_jumped = True
        T_local_map = frames[-1].T_local_base @ poses[-1].inverse()
        numbers = self.first_seen()
        self._front.see((frames[k].points, T_local_map @ poses[k]) for k in numbers)
        self._front.break_motion(T_local_map @ poses[0])

    def first_seen(self) -> list[int]:
        """Return the first nodes; where their scans were thrown out those nearest to the first."""
        frames, poses = self.closer.frames, self.closer.poses
        num = min(len(frames), self.config.loop.submap_nodes + 1)
        if all(len(frame.points) for frame in frames[:num]):
            return list(range(num))
        held = [k for k, frame in enumerate(frames) if len(frame.points)]
        return sorted(held, key=lambda k: poses[0].between(poses[k]).distance)[:num]

    def leave_out_unplaced(self, first: int) -> int:
        """Forget the scans from one on that came before one was trusted; return how many."""
        last = first
        while last < len(self._followed) and not self._followed[last].is_trusted:
            last += 1
        del self._followed[first:last]
        return last - first

    def known_poses(self) -> list[KnownPose]:
        """Return the pose of every scan so far, as the graph has it now."""
        scans = self._followed
        poses = self.corrections().all_at(
            np.array([scan.node for scan in scans], int),
            np.array([scan.T_local_base.as_array() for scan in scans]).reshape(-1, 3),
        )
        return [
            KnownPose(SE2(*pose), scan.is_trusted, scan.reason, scan.sweep)
            for pose, scan in zip(poses.tolist(), scans, strict=True)
        ]
