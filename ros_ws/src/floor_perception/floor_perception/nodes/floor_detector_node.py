"""Floor region and free space of an omnidirectional camera.

In: `omni/image_raw` (Image, or `omni/image_raw/compressed`), /tf_static.
Out: `floor/mask` (Image mono8, 255 where the floor is), `floor/free_space` (LaserScan in
`floor_frame`), `floor/overlay` (Image bgr8, only while somebody subscribes), TF base_frame ->
floor_frame (static, where nobody else sends it).
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Header

from floor_perception.color_files import load_color
from floor_perception.config import CameraNodeConfig, FloorDetectorConfig, FloorNodeConfig
from floor_perception.floor_detector import FloorDetector, FloorResult
from floor_perception.nodes.floor_frame import FloorFrame
from floor_perception.nodes.image_input import ImageInput
from floor_perception.overlay import overlay
from floor_perception.resources import find_file, load_camera_model, load_hidden_mask
from floor_perception.warm_up import compile_kernels
from floornav_common.ros.diagnostics import OK, STALE, WARN, Status
from floornav_common.ros.main import run_node
from floornav_common.ros.messages import array_to_image, scan_to_msg, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher


class FloorDetectorNode(FloornavNode):
    """Feeds images to a FloorDetector and publishes what it finds."""

    def __init__(self) -> None:
        """Declare, load the camera, subscribe, compile, and say ready."""
        super().__init__("floor_detector")
        config = declare_config(self, CameraNodeConfig)
        tf_config = declare_config(self, FloorNodeConfig)
        self._detector = self._make_detector(config)
        self._frame = (self.frames.frame_prefix + config.floor_frame).lstrip("/")
        if tf_config.publish_tf:
            wait_s = tf_config.publish_tf_after_s
            self._floor_frame = FloorFrame(self, self._frame, self._detector.camera, wait_s)
        self._mask_pub = create_publisher(self, Image, "floor/mask", RELIABLE_QOS)
        self._scan_pub = create_publisher(self, LaserScan, "floor/free_space", RELIABLE_QOS)
        self._overlay_pub = create_publisher(self, Image, "floor/overlay", RELIABLE_QOS)
        self._newest: FloorResult | None = None
        self._num_images, self._ms, self._worst_ms, self._latency_ms = 0, 0.0, 0.0, 0.0
        compile_kernels(self._detector)
        self._input = ImageInput(
            self, config.image_transport, config.image_timeout_s, self._on_image
        )
        self.time.on_restart(lambda: self._detector.tracker.forget())
        self.diagnostics.add("floor", self._status)
        self.ready()

    def _make_detector(self, config: CameraNodeConfig) -> FloorDetector:
        detection = declare_config(self, FloorDetectorConfig, on_change=self._tune)
        try:
            camera = load_camera_model(config.camera_model)
            hidden = load_hidden_mask(config.hidden_mask)
            file = detection.color.file
            color = load_color(find_file(file, "colors")) if file else None
            return FloorDetector(camera, detection, hidden, color)
        except (ValueError, OSError) as error:
            raise ParameterError(f"{self.get_fully_qualified_name()}: {error}") from error

    def _tune(self, config: FloorDetectorConfig) -> None:
        try:
            self._detector.reconfigure(config)
        except ValueError as error:
            self.get_logger().error(f"the old settings are kept: {error}")

    def _on_image(self, header: Any, pixels: np.ndarray, order: str) -> None:
        started = time.perf_counter()
        self._num_images += 1
        self._newest = self._detector.detect(pixels, order, stamp_to_ns(header.stamp))
        self._input.set_doubt(self._detector.size_doubt)
        self._ms = 1e3 * (time.perf_counter() - started)
        self._worst_ms = max(self._worst_ms, self._ms)
        if self._newest is None:
            self._input.warn(self._detector.tracker.reason)
            return
        self._publish(self._newest, header)
        now_ns = self.get_clock().now().nanoseconds
        self._latency_ms = 1e-6 * (now_ns - stamp_to_ns(header.stamp))
        if self._overlay_pub.get_subscription_count():
            bgr = pixels if order == "bgr" else np.ascontiguousarray(pixels[..., ::-1])
            drawn = overlay(bgr, self._newest.mask, self._newest.scan, self._detector.camera)
            self._overlay_pub.publish(array_to_image(drawn, "bgr8", header.stamp, header.frame_id))

    def _publish(self, result: FloorResult, header: Any) -> None:
        scan_header = Header(stamp=header.stamp, frame_id=self._frame)
        self._scan_pub.publish(scan_to_msg(result.scan, scan_header))
        mask = array_to_image(result.mask, "mono8", header.stamp, header.frame_id)
        self._mask_pub.publish(mask)

    def _status(self) -> Status:
        tracker = self._detector.tracker
        values = {
            "images": self._num_images,
            "processing (ms)": f"{self._ms:.2f}",
            "longest processing (ms)": f"{self._worst_ms:.2f}",
            "stamp to published (ms)": f"{self._latency_ms:.1f}",
            "floor color around the robot (share)": f"{tracker.support:.2f}",
        }
        if not self._input.watchdog.is_fresh:
            return Status(STALE, "no images: no free space is sent", values)
        if self._input.refusal:
            return self._input.refused("no free space is sent", values)
        doubts = "; ".join(filter(None, (tracker.reason, self._input.doubt)))
        if self._newest is None:
            return Status(WARN, f"no free space: {doubts}", values)
        values["directions seen (share)"] = f"{self._newest.coverage:.3f}"
        if doubts:
            return Status(WARN, doubts, values)
        return Status(OK, "the floor's color is known", values)


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(FloorDetectorNode, args)


if __name__ == "__main__":
    sys.exit(main())
