"""The pose in a voxel map from what two stereo pairs see, one alone as well.

In, for each of `pairs`: `stereo/<pair>/disparity` (DisparityImage), `stereo/<pair>/left/image_rect`
(Image, or .../compressed) of the same stamp and `stereo/<pair>/left/camera_info`; `odom` (Odometry,
its pose where TF has none), `initialpose` (PoseWithCovarianceStamped: where to look for the
robot), TF odom->base_link->the camera's frame.
Out: `stereo_pose` (PoseWithCovarianceStamped of base_link in the map's frame; nothing while it is
not known), `stereo_pose/candidates` (PoseArray: all poses that fit, the likeliest first), TF
map->odom with `publish_tf`.
"""

from __future__ import annotations

import sys
import time
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseArray

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import ns_to_stamp, poses_to_msg
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable
from multi_localizer.newest_worker import NewestWorker
from multi_localizer.nodes.initial_pose import hear_initial_pose
from multi_localizer.nodes.localizer_outputs import LocalizerOutputs
from multi_localizer.nodes.stamped_input import StampedInput
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.nodes.stereo_map import load_map
from multi_localizer.nodes.stereo_report import StereoReport
from multi_localizer.nodes.stereo_views import Seen, StereoViews
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_localizer_node_config import StereoLocalizerNodeConfig
from multi_localizer.stereo_moments import StereoMoments
from multi_localizer.stereo_pose import StereoPose, StereoState


class StereoLocalizerNode(FloornavNode):
    """Puts together what the pairs see at one moment, and publishes the pose it gives."""

    def __init__(self) -> None:
        """Declare, load the map, subscribe, compile, and say ready."""
        super().__init__("stereo_localizer")
        config = declare_config(self, StereoLocalizerNodeConfig)
        method = declare_config(self, StereoLocalizerConfig, on_change=self._tune)
        self._voxels = load_map(self, config.map_file)
        threads = int(self.get_parameter("num_threads").value)
        wait_ns = round(config.pairs_wait_s * 1e9)
        self._moments = StereoMoments(self._voxels, method, config.pairs, wait_ns, threads)
        self._worker, self._generation = NewestWorker("stereo"), 0
        self._seen = StampedInput(self, config.wait_s, self._take)
        self._outputs = LocalizerOutputs(self, "stereo_pose", config.publish_tf)
        self._candidates = create_publisher(self, PoseArray, "stereo_pose/candidates", RELIABLE_QOS)
        self._odometry = OdometryFallback(self) if config.use_odom else None
        self._pairs = StereoViews(self, config, self._seen.add)
        self._report = StereoReport(
            self._pairs.watchdogs, self._outputs, self._seen.groups, self._worker,
            lambda: self._moments.doing,
        )  # fmt: skip
        self.diagnostics.add("stereo pose", self._report.status)
        self._log = StateLog(self, self._report.status)
        self.time.on_look(self._look)
        self.transforms.on_restart(self._restart)
        hear_initial_pose(self, self._relocate, self.get_logger().warning)
        self.ready(self._moments.warm_up)

    def destroy_node(self) -> None:
        """Wait for the pose that is being looked for."""
        self._worker.close()
        super().destroy_node()

    def _tune(self, config: StereoLocalizerConfig) -> None:
        self._worker.do(partial(self._moments.reconfigure, config))

    def _relocate(self, told: PoseEstimate) -> None:
        self._worker.do(partial(self._moments.relocate, told))

    def _restart(self) -> None:
        self._generation += 1  # what was begun before is too old
        self._worker.withdraw()
        self._seen.groups.clear()
        self._worker.do(self._moments.reset)
        self._report.forget()

    def _look(self) -> None:
        self._worker.check()
        if self._report.is_lost and not self.time.is_stopped:
            self._outputs.stop_tf()

    def _take(self, stamp_ns: int, group: dict[str, Any]) -> None:
        try:
            seen = self._pairs.seen(group, self._voxels.farthest_m)
        except (ValueError, TransformUnavailable) as error:
            self._report.refuse(str(error))
            return
        if seen is None:
            self._report.note_single(group)
            return
        self._worker.offer(partial(self._locate, self._generation, stamp_ns, seen))

    def _locate(self, generation: int, stamp_ns: int, seen: Seen) -> None:
        started = time.perf_counter()
        try:
            found = self._moments.locate(stamp_ns, seen.cameras, seen.views, seen.T_odom_base)
        except ValueError as error:
            self._report.refuse(str(error))
            return
        if found is None or generation != self._generation:
            return
        self._report.note(found, list(seen.views), 1e3 * (time.perf_counter() - started))
        self._publish(ns_to_stamp(stamp_ns), found, seen.T_odom_base)
        refusal, news = self._moments.take_refusal(), self._moments.take_news()
        if refusal:
            self.get_logger().warning(f"initialpose refused: {refusal}")
        if news:
            self.get_logger().info(news)

    def _publish(self, stamp: Any, found: StereoPose, T_odom_base: SE2 | None) -> None:
        if found.state is StereoState.KNOWN:
            self._outputs.send(stamp, found.hypotheses[0].estimate, T_odom_base)
        is_fit = found.state is not StereoState.LOST
        poses = [h.estimate.pose for h in found.hypotheses] if is_fit else []
        self._candidates.publish(poses_to_msg(poses, stamp, self.frames.map))


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(StereoLocalizerNode, args)


if __name__ == "__main__":
    sys.exit(main())
