"""`pose_source: tf`: another localizer says where the robot is; only layers are added."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from floornav_common.readings import RangeReading
from floornav_common.ros import messages
from floornav_common.ros.diagnostics import OK, STALE, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from floornav_common.transform_errors import TransformUnavailable
from grid_mapper.config import GridMapperNodeConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.nodes.jump_watch import JumpWatch
from grid_mapper.nodes.scan_input import ScanInput
from grid_mapper.sonar_mount import level_sonar


class GivenPoses:
    """Feeds scans and readings to the mapper at the poses that TF has for them.

    Attributes:
        newest_ns: Stamp of the newest input that was mapped; None before the first.
        sonar_frame: Frame that sonar readings are to be brought to.
    """

    def __init__(
        self,
        node: FloornavNode,
        mapper: LayeredMapper,
        config: GridMapperNodeConfig,
        warn: Callable[[str], None],
    ) -> None:
        """Subscribe to scans, where there is a laser."""
        self._node, self._mapper, self._warn = node, mapper, warn
        self.sonar_frame = node.frames.map
        self._jumps = JumpWatch(node, config, warn)
        self.forget()
        self._scans: ScanInput | None = None
        if config.use_scan:
            timeout_s = config.scan_timeout_s
            self._scans = ScanInput(node, node.frames.map, timeout_s, self._on_scan, warn)
        node.transforms.on_restart(self._restart)  # the clock's too

    def configure(self, config: GridMapperNodeConfig) -> None:
        """Go on with other values."""
        self._jumps.config = config
        if self._scans is not None:
            self._scans.set_timeout(config.scan_timeout_s)

    def forget(self) -> None:
        """Begin anew."""
        self.newest_ns: int | None = None
        self._num_mapped = 0
        self._jumps.forget()

    def lose(self) -> None:
        """Do nothing: the pose is somebody else's."""

    def close(self) -> None:
        """Do nothing."""

    def publish_path(self, stamp: Any) -> None:
        """Do nothing: the way is somebody else's."""

    def on_range(
        self, msg: Any, sensor: str, reading: RangeReading, T_map_sonar: Transform3
    ) -> None:
        """Map a reading."""
        stamp_ns = messages.stamp_to_ns(msg.header.stamp)
        try:
            frames = (self._node.frames.base, msg.header.frame_id)
            T_base_sonar = self._node.transforms.buffer.lookup(*frames, stamp_ns)
        except TransformUnavailable as error:
            self._warn(f"sonar {sensor}: {error}")
            return
        T_map_base = (T_map_sonar @ T_base_sonar.inverse()).to_se2()
        pose = level_sonar(T_base_sonar)
        if self._jumps.is_steady(stamp_ns, T_map_base):
            self._mapper.place_range(stamp_ns, reading, pose, sensor, T_map_base)
            self._note(stamp_ns)

    def status(self) -> Status:
        """Return whether there is input, and whether its poses jumped of late."""
        values = {
            "inputs mapped": self._num_mapped,
            "jumps of the pose": self._jumps.num_jumps,
            "map (MB)": f"{self._mapper.num_bytes / 1e6:.1f}",
        }
        if self._scans is not None and not self._scans.is_fresh:
            return Status(STALE, "no scans with a pose in the map frame", values)
        if self._jumps.late_jump:
            return Status(WARN, f"the given pose jumped by {self._jumps.late_jump}", values)
        if not self._num_mapped:
            return Status(STALE, "no input with a pose in the map frame", values)
        return Status(OK, "poses are taken from TF", values)

    def _on_scan(self, stamp: Any, scan: Scan, T_base_laser: SE2, T_map_base: SE2) -> None:
        stamp_ns = messages.stamp_to_ns(stamp)
        if self._jumps.is_steady(stamp_ns, T_map_base):
            self._mapper.place_scan(stamp_ns, scan, T_base_laser, T_map_base)
            self._note(stamp_ns)

    def _restart(self) -> None:
        """Begin anew in the map that is there: stamps jumped back."""
        self.newest_ns = None
        self._jumps.restart()
        self._mapper.break_motion()

    def _note(self, stamp_ns: int) -> None:
        self._num_mapped += 1
        self.newest_ns = max(stamp_ns, self.newest_ns or 0)
