"""Mapping by laser and sonars on ROS topics, with glass.

In: `scan` (LaserScan), the `sonar_topics` (Range; `sonar` by default), `odom` (Odometry, its pose
where TF has none), `initialpose` (PoseWithCovarianceStamped), `reference_map` (OccupancyGrid), TF
odom->base_link->sensors, with `pose_source: tf` map->base_link too.
Out: `map` (laser and sonar), `map/laser`, `map/sonar`, `map/glass` (OccupancyGrid, latched), `pose`
(PoseWithCovarianceStamped), `trajectory` (Path, thinned to 0.1 m; above 1000 poses to 0.2 m,
and so on), TF map->odom; with `pose_source: tf` only the three layers.
Services: `~/save_map`, `~/reset` (Trigger).
"""

from __future__ import annotations

import gc
import sys

from std_srvs.srv import Trigger

from floornav_common.ros import messages
from floornav_common.ros.main import run_node
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.time_watch import Throttle
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.glass_files import SUFFIXES, save_layers
from grid_mapper.map_files import free_prefix
from grid_mapper.nodes.given_poses import GivenPoses
from grid_mapper.nodes.map_outputs import MapOutputs
from grid_mapper.nodes.mapper_choice import make_mapper, make_recovery, read_start_map
from grid_mapper.nodes.matched_poses import MatchedPoses
from grid_mapper.nodes.node_sessions import SessionSaver, read_start_session, wait_for_maps
from grid_mapper.nodes.sonar_inputs import SonarInputs
from grid_mapper.warm_up import compile_kernels

WARN_PERIOD_NS = 5_000_000_000


class GridMapperNode(FloornavNode):
    """Feeds scans and sonar readings to a mapper and publishes what it knows."""

    def __init__(self) -> None:
        """Declare, subscribe, compile, and say ready."""
        super().__init__("grid_mapper")
        config = declare_config(self, GridMapperNodeConfig, on_change=self._set_config)
        self._config = config
        self._warnings = Throttle(WARN_PERIOD_NS)
        has_own_poses = config.pose_source == "icp"
        mapper_config = declare_config(self, GridMapperConfig, on_change=self._tune)
        start = read_start_map(config)
        before = read_start_session(config, mapper_config)
        kept = config.keep_start_map
        self._mapper = make_mapper(self, mapper_config, has_own_poses, start, kept, before)
        self._session = SessionSaver(self, self._mapper, config.session_file)
        self._maps = MapOutputs(self, has_own_poses, config.reference_map, self._warn)
        self._maps.has_news = start is not None or before is not None
        self._poses: MatchedPoses | GivenPoses
        if has_own_poses:
            recovery = make_recovery(mapper_config, start, kept, lambda: self._maps.laser_map)
            self._poses = MatchedPoses(self, self._mapper, config, recovery, self._warn)
        else:
            self._poses = GivenPoses(self, self._mapper, config, self._warn)
        self._sonars = SonarInputs(
            self, config.sonar_topics, self._poses.sonar_frame, self._poses.on_range, self._warn,
            lambda: self._mapper.sonar_counts,
        )  # fmt: skip
        self._num_published = 0
        self.create_service(Trigger, "~/save_map", self._on_save_map)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_timer(config.map_period_s, self._publish_map)
        self.diagnostics.add("mapping", self._poses.status)
        if before is not None:
            wait_for_maps(self, self._mapper)
        self.ready(lambda: self._prepare(mapper_config.fusion, has_loops=has_own_poses))

    @staticmethod
    def _prepare(fusion: str, *, has_loops: bool) -> None:
        """Compile, and keep all that is there by now from being gone through for garbage again.

        Else each full collection goes through some 100 000 objects of what was imported, and a
        scan waits for it.
        """
        compile_kernels(fusion, has_loops=has_loops)
        gc.collect()
        gc.freeze()

    def destroy_node(self) -> None:
        """Let no map be made while publishers go."""
        self._maps.close()
        self._poses.close()
        if isinstance(self._mapper, ClosingMapper):
            self._session.finish()
            self._mapper.close()
        super().destroy_node()

    def _set_config(self, config: GridMapperNodeConfig) -> None:
        self._config = config
        self._poses.configure(config)

    def _tune(self, config: GridMapperConfig) -> None:
        self._mapper.reconfigure(config)

    def _publish_map(self) -> None:
        self._session.look()
        if self._maps.is_busy():
            return
        has_changed = self._mapper.num_changes != self._num_published
        if not self._maps.has_news and (not has_changed or self._poses.newest_ns is None):
            return
        self._num_published = self._mapper.num_changes
        stamp_ns = self._poses.newest_ns
        now = self.get_clock().now().to_msg()
        stamp = now if stamp_ns is None else messages.ns_to_stamp(stamp_ns)
        self._maps.publish(self._mapper.moment(), stamp)
        self._poses.publish_path(stamp)

    def _on_save_map(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        prefix = self._config.map_file or free_prefix("map", SUFFIXES)
        margin = self._mapper.config.keepout_margin_m
        try:
            path = save_layers(prefix, self._mapper.layers(), self._config.map_mode, margin)[0]
            response.success, response.message = True, str(path.resolve())
            self._session.save()
        except (ValueError, OSError) as error:
            response.success, response.message = False, str(error)
        return response

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._mapper.reset()
        self._poses.forget()
        self._poses.lose()
        self._num_published = 0
        self._maps.has_news = bool(self._config.start_map)
        stamp = self.get_clock().now().to_msg()
        self._maps.publish_nothing_known(self._mapper.config.resolution_m, stamp)
        self._poses.publish_path(stamp)
        what = "the map is as at the start" if self._config.start_map else "the map is empty"
        response.success, response.message = True, f"{what}, the trajectory is empty"
        return response

    def _warn(self, text: str) -> None:
        if self._warnings.is_due(self.time.steady_ns()):
            self.get_logger().warning(text)


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(GridMapperNode, args)


if __name__ == "__main__":
    sys.exit(main())
