"""Laser mapping on ROS topics.

In: `scan` (LaserScan), `odom` (Odometry, its pose where TF has none), `initialpose`
(PoseWithCovarianceStamped), TF odom->base_link->laser.
Out: `map` (OccupancyGrid, latched), `pose` (PoseWithCovarianceStamped), `trajectory` (Path, thinned
to 0.1 m), TF map->odom.
Services: `~/save_map`, `~/reset` (Trigger).
"""

from __future__ import annotations

import sys
import time
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from floornav_common.ros import messages
from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.main import run_node
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import (
    LATCHED_QOS,
    RELIABLE_QOS,
    SENSOR_QOS,
    create_publisher,
    create_subscription,
)
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from floornav_common.time_watch import Throttle
from floornav_common.transform3 import Transform3
from floornav_common.transform_errors import TransformUnavailable
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.laser_mount import level_scan
from grid_mapper.localizer import ScanResult
from grid_mapper.map_files import free_prefix, save_map
from grid_mapper.mapper import GridMapper
from grid_mapper.nodes.map_to_odom import MapToOdom
from grid_mapper.path_thinner import PathThinner
from grid_mapper.ros_conversions import empty_map, path_to_msg, pose_to_msg, stamped_pose
from grid_mapper.tracking import Tracking
from grid_mapper.warm_up import compile_kernels

WARN_PERIOD_NS = 5_000_000_000


class GridMapperNode(FloornavNode):
    """Feeds scans to a GridMapper and publishes what it knows."""

    def __init__(self) -> None:
        """Declare, subscribe, compile, and say ready."""
        super().__init__("grid_mapper")
        self._config = declare_config(self, GridMapperNodeConfig, on_change=self._set_config)
        self._mapper = GridMapper(declare_config(self, GridMapperConfig, on_change=self._tune))
        self._warnings = Throttle(WARN_PERIOD_NS)
        self._forget()
        self._make_publishers()
        use_odom = self._config.use_odom
        self._odometry = OdometryFallback(self) if use_odom else None
        self._tf = MapToOdom(self) if use_odom and self._config.publish_tf else None
        self._scans = TransformedSubscription(
            self, LaserScan, "scan", SENSOR_QOS,
            self.frames.odom if use_odom else self.frames.base, self._on_scan,
        )  # fmt: skip
        self._watchdog = Watchdog(self, self._scans.topic, self._config.scan_timeout_s)
        create_subscription(
            self, PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, RELIABLE_QOS
        )
        self.create_service(Trigger, "~/save_map", self._on_save_map)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_timer(self._config.map_period_s, self._publish_map)
        self.transforms.on_restart(self._restart)  # the clock's too
        self.time.on_look(self._look)
        self.diagnostics.add("mapping", self._status)
        self.ready(compile_kernels)

    def _make_publishers(self) -> None:
        self._map_pub = create_publisher(self, OccupancyGrid, "map", LATCHED_QOS)
        self._pose_pub = create_publisher(self, PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
        self._path_pub = create_publisher(self, Path, "trajectory", RELIABLE_QOS)

    def _forget(self) -> None:
        self._tracking = Tracking()
        self._path: PathThinner[Any] = PathThinner(
            lambda stamp_ns, pose: stamped_pose(stamp_ns, pose, self.frames.map)
        )
        self._num_scans = self._num_trusted = 0
        self._worst_ms, self._num_published = 0.0, 0
        self._reason, self._note = "no scan yet", ""

    def _set_config(self, config: GridMapperNodeConfig) -> None:
        self._config = config
        self._watchdog.set_timeout(config.scan_timeout_s)

    def _tune(self, config: GridMapperConfig) -> None:
        self._mapper.reconfigure(config)

    def _restart(self) -> None:
        """Begin anew in the map that is there: stamps jumped back."""
        self._mapper.break_motion()
        self._lose()

    def _look(self) -> None:
        """Stop sending when scans stop; while /clock stands still nothing is sent anyway."""
        if not self._watchdog.is_fresh and not self.time.is_stopped:
            self._lose()

    def _lose(self) -> None:
        self._tracking.lose()
        if self._tf is not None:
            self._tf.set(None)

    def _on_scan(self, msg: Any, T_target_laser: Transform3) -> None:
        stamp_ns = messages.stamp_to_ns(msg.header.stamp)
        T_base_laser, T_odom_base = T_target_laser, None
        try:
            if self._config.use_odom:
                T_base_laser = self.transforms.buffer.lookup(
                    self.frames.base, msg.header.frame_id, stamp_ns
                )
                T_odom_base = (T_target_laser @ T_base_laser.inverse()).to_se2()
            scan, pose = level_scan(messages.scan_from_msg(msg), T_base_laser)
            started = time.perf_counter()
            result = self._mapper.insert_scan(stamp_ns, scan, pose, T_odom_base)
        except (ValueError, TransformUnavailable) as error:
            self._warn(f"{self._scans.topic}: {error}")
            return
        self._watchdog.feed()
        self._worst_ms = max(self._worst_ms, 1e3 * (time.perf_counter() - started))
        self._take(result, msg.header.stamp, stamp_ns, T_odom_base)

    def _take(self, result: ScanResult, stamp: Any, stamp_ns: int, T_odom_base: SE2 | None) -> None:
        """Publish the pose of a scan, unless the robot is lost."""
        self._num_scans += 1
        self._num_trusted += result.is_trusted
        self._reason, self._note = result.reason, result.note
        self._tracking.update(stamp_ns, result.is_trusted, self._config.lost_after_s)
        is_lost = self._tracking.is_lost
        if not result.is_trusted:
            self._warn(f"scan not trusted: {result.reason}" + (", lost" if is_lost else ""))
        if self._tf is not None and T_odom_base is not None:
            self._tf.set(None if is_lost else result.T_map_base @ T_odom_base.inverse())
        if not is_lost:
            self._path.add(stamp_ns, result.T_map_base)
            self._pose_pub.publish(
                pose_to_msg(result.T_map_base, result.cov, stamp, self.frames.map)
            )

    def _publish_map(self) -> None:
        stamp_ns = self._path.newest_stamp_ns
        if self._mapper.num_key_scans == self._num_published or stamp_ns is None:
            return
        self._num_published = self._mapper.num_key_scans
        stamp = messages.ns_to_stamp(stamp_ns)
        grid = self._mapper.occupancy()
        self._map_pub.publish(messages.grid_to_msg(grid, stamp, self.frames.map))
        self._path_pub.publish(path_to_msg(self._path.rows(), stamp, self.frames.map))

    def _publish_nothing_known(self) -> None:
        """Replace the latched map and the path, so that the old ones do not stay up."""
        stamp, frame = self.get_clock().now().to_msg(), self.frames.map
        grid = empty_map(self._mapper.config.resolution_m)
        self._map_pub.publish(messages.grid_to_msg(grid, stamp, frame))
        self._path_pub.publish(path_to_msg([], stamp, frame))

    def _on_initial_pose(self, msg: Any) -> None:
        if msg.header.frame_id.lstrip("/") != self.frames.map:
            self._warn(f"initialpose is in '{msg.header.frame_id}', not in '{self.frames.map}'")
            return
        try:
            pose = messages.pose_to_se2(msg.pose.pose)
            cov = messages.ros_cov_to_se2(msg.pose.covariance)
            self._mapper.relocate(pose, cov)
        except ValueError as error:
            self._warn(f"initialpose refused: {error}")

    def _on_save_map(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        prefix = self._config.map_file or free_prefix("map")
        try:
            path = save_map(prefix, self._mapper.occupancy(), self._config.map_mode)
            response.success, response.message = True, str(path.resolve())
        except (ValueError, OSError) as error:
            response.success, response.message = False, str(error)
        return response

    def _on_reset(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        self._mapper.reset()
        self._forget()
        self._lose()
        self._publish_nothing_known()
        response.success, response.message = True, "map and trajectory are empty"
        return response

    def _status(self) -> Status:
        values = {
            "scans": self._num_scans,
            "trusted": self._num_trusted,
            "longest scan (ms)": f"{self._worst_ms:.1f}",
            "map (MB)": f"{self._mapper.num_bytes / 1e6:.1f}",
        }
        if not self._watchdog.is_fresh:
            return Status(STALE, "no scans: pose and map->odom are not sent", values)
        if self._tracking.is_lost:
            return Status(ERROR, f"lost: {self._reason}", values)
        if self._reason:
            return Status(WARN, f"newest scan not trusted: {self._reason}", values)
        if self._note:
            judge = "odometry decides" if self._config.use_odom else "nothing else does either"
            return Status(WARN, f"{self._note}; {judge}", values)
        return Status(OK, "every scan fits the map", values)

    def _warn(self, text: str) -> None:
        if self._warnings.is_due(self.time.steady_ns()):
            self.get_logger().warning(text)


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(GridMapperNode, args)


if __name__ == "__main__":
    sys.exit(main())
