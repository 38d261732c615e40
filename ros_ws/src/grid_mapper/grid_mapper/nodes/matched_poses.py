"""`pose_source: icp`: the pose by scan matching, published as pose, trajectory and map->odom."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.ros import messages
from floornav_common.ros.diagnostics import Status
from floornav_common.ros.map_to_odom import MapToOdom
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.match_verdict import ScanResult, found_words
from grid_mapper.nodes.initial_pose import InitialPose
from grid_mapper.nodes.lost_robot import LostRobot
from grid_mapper.nodes.match_report import MatchReport
from grid_mapper.nodes.pose_outputs import PoseOutputs
from grid_mapper.nodes.scan_input import ScanInput
from grid_mapper.nodes.sweep_report import SweepReport
from grid_mapper.recovery import Recovery
from grid_mapper.sonar_mount import level_sonar
from grid_mapper.tracking import Tracking


class MatchedPoses:
    """Feeds scans and readings to the mapper, and publishes the poses it finds.

    Attributes:
        sonar_frame: Frame that sonar readings are to be brought to.
        publish_path: Publishes the way so far, with a stamp.
        close: Ends what runs in the background.
    """

    def __init__(
        self,
        node: FloornavNode,
        mapper: LayeredMapper | ClosingMapper,
        config: GridMapperNodeConfig,
        recovery: Recovery,
        warn: Callable[[str], None],
    ) -> None:
        """Subscribe to scans, odometry and initial poses."""
        self._node, self._mapper, self._config, self._warn = node, mapper, config, warn
        self._lost = LostRobot(mapper, recovery, config)
        self.close = self._lost.close
        self.sonar_frame = node.frames.base
        closing = mapper if isinstance(mapper, ClosingMapper) else None
        self._outputs = PoseOutputs(node, closing)
        self.publish_path = self._outputs.publish_path
        self._report = MatchReport(self._lost, has_odom=config.use_odom)
        self._sweeps = SweepReport(node, mapper)
        self.forget()
        self._odometry = OdometryFallback(node) if config.use_odom else None
        self._tf = MapToOdom(node) if config.use_odom and config.publish_tf else None
        frame = node.frames.odom if config.use_odom else node.frames.base
        self._scans = ScanInput(node, frame, config.scan_timeout_s, self._on_scan, warn)
        self._initial_pose = InitialPose(node, self._on_said, warn)
        node.transforms.on_restart(self._restart)  # the clock's too
        node.time.on_look(self._watch_scans)

    def configure(self, config: GridMapperNodeConfig) -> None:
        """Go on with other values."""
        self._config = self._lost.config = config
        self._scans.set_timeout(config.scan_timeout_s)

    def forget(self) -> None:
        """Begin anew, with no pose and no trajectory."""
        self._tracking = Tracking()
        self._outputs.forget()
        self._report.forget()
        self._lost.begin()

    def lose(self) -> None:
        """Stop sending until the next trusted scan."""
        self._tracking.lose()
        if self._tf is not None:
            self._tf.set(None)

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest pose that was published; None before the first."""
        return self._outputs.newest_ns

    def on_range(
        self, msg: Any, sensor: str, reading: RangeReading, T_base_sonar: Transform3
    ) -> None:
        """Hand over a reading; it waits in the mapper for the scans round it."""
        pose = level_sonar(T_base_sonar)
        self._mapper.insert_range(messages.stamp_to_ns(msg.header.stamp), reading, pose, sensor)

    def status(self) -> Status:
        """Return whether scans fit the map."""
        is_fresh, is_lost = self._scans.is_fresh, self._tracking.is_lost
        return self._report.status(self._mapper.num_bytes, is_fresh=is_fresh, is_lost=is_lost)

    def _on_said(self, pose: SE2, cov: np.ndarray) -> None:
        """Go on where somebody says that the robot is; what was sent so far is wrong."""
        self._lost.is_said_at(pose, cov)
        self.lose()

    def _on_scan(self, stamp: Any, scan: Scan, T_base_laser: SE2, T_target_base: SE2) -> None:
        stamp_ns = messages.stamp_to_ns(stamp)
        T_odom_base = T_target_base if self._config.use_odom else None
        started = time.perf_counter()
        if self._lost.is_jump(stamp_ns, T_odom_base):
            self.lose()
        found = self._lost.look(scan, T_base_laser, T_odom_base)
        if found is not None:
            words = found_words(found, self._lost.looked_for_s(stamp_ns))
            self._node.get_logger().info(words)
        result = self._mapper.insert_scan(stamp_ns, scan, T_base_laser, T_odom_base)
        result = self._lost.checked(stamp_ns, scan, T_base_laser, result)
        self._report.note(result, 1e3 * (time.perf_counter() - started))
        self._take(result, stamp, T_odom_base)

    def _take(self, result: ScanResult, stamp: Any, T_odom_base: SE2 | None) -> None:
        """Publish the pose of a scan, unless the robot is lost."""
        stamp_ns, lost_after_s = messages.stamp_to_ns(stamp), self._config.lost_after_s
        if self._lost.is_looked_for:
            self.lose()
        self._tracking.update(stamp_ns, result.is_trusted, lost_after_s)
        is_lost = self._tracking.is_lost
        self._lost.judge(stamp_ns, result.is_trusted, is_lost)
        if not result.is_trusted:
            self._warn(f"scan not trusted: {result.reason}" + (", lost" if is_lost else ""))
        if self._tf is not None and T_odom_base is not None:
            self._tf.set(None if is_lost else result.T_map_base @ T_odom_base.inverse())
        if not is_lost:
            self._outputs.publish_pose(stamp, result.T_map_base, result.cov)

    def _restart(self) -> None:
        """Begin anew in the map that is there: stamps jumped back."""
        self._lost.restart()
        self.lose()

    def _watch_scans(self) -> None:
        """Stop sending when scans stop; while /clock stands still nothing is sent anyway."""
        if not self._scans.is_fresh and not self._node.time.is_stopped:
            self.lose()
