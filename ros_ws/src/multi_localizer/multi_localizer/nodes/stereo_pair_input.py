"""The images of one stereo pair, put together by stamp, with their cameras checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.messages import compressed_to_array, image_to_array, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.ros.watchdog import Watchdog
from multi_localizer.nodes.stamped_input import StampedInput
from multi_localizer.nodes.state_log import StateLog
from multi_localizer.ros_conversions import camera_from_msg
from multi_localizer.stereo_cameras import CameraModel, RectifiedPair, rectified_pair
from multi_localizer.stereo_pairs_config import StereoPairsConfig

SIDES = ("left", "right")
_SINGLE_AFTER = 3


class StereoPairInput:
    """Subscribes to a pair and hands on what belongs together.

    Args:
        node: The node.
        name: Of the pair.
        config: The node's.
        on_pair: Called with the left header, both images in RGB and what the cameras are.
    """

    def __init__(
        self,
        node: FloornavNode,
        name: str,
        config: StereoPairsConfig,
        on_pair: Callable[[Any, np.ndarray, np.ndarray, RectifiedPair], None],
    ) -> None:
        """Subscribe at once."""
        self._node, self._on_pair = node, on_pair
        self._cameras: dict[str, CameraModel] = {}
        self._problem, self._num_pairs, self._num_single, self._singles = "", 0, 0, 0
        self._is_sent = False
        self._single_sides: set[str] = set()
        self._topics: dict[str, str] = {}
        topic = f"stereo/{name}"
        is_raw = config.image_transport == "raw"
        kind, ending = (Image, "") if is_raw else (CompressedImage, "/compressed")
        self._pixels_of = image_to_array if is_raw else compressed_to_array
        for side in SIDES:
            images = f"{topic}/{side}/image_rect{ending}"
            self._topics[side] = node.resolve_topic_name(images)
            create_subscription(node, kind, images, partial(self._on_image, side), SENSOR_QOS)
            create_subscription(
                node, CameraInfo, f"{topic}/{side}/camera_info", partial(self._on_info, side),
                SENSOR_QOS,
            )  # fmt: skip
        self.watchdog = Watchdog(node, node.resolve_topic_name(topic), config.image_timeout_s)
        node.diagnostics.add(f"stereo {name}", self.status)
        self._log = StateLog(node, self.status, name)
        self._images = StampedInput(node, config.wait_s, self._take)
        node.time.on_restart(self._images.groups.clear)

    def status(self) -> Status:
        """Return whether disparities are sent, or why not."""
        values = {
            "pairs": self._num_pairs, "images without a partner": self._num_single,
            "images that came too late": self._images.groups.num_late,
        }  # fmt: skip
        if not self.watchdog.is_fresh:
            self._is_sent = False
            return Status(STALE, "no images: no disparities are sent", values)
        if self._singles >= _SINGLE_AFTER:
            return Status(WARN, f"{self._why_single()}: no disparities are sent", values)
        if self._problem:
            return Status(ERROR, f"no disparities are sent: {self._problem}", values)
        if not self._is_sent:
            return Status(STALE, "waiting for a whole pair: no disparities are sent", values)
        return Status(OK, "disparities are sent", values)

    def _why_single(self) -> str:
        silent = [side for side in SIDES if side not in self._single_sides]
        if not silent:
            return "images without a partner of the same stamp"
        topic = self._topics[silent[0]]
        by_nobody = "" if self._node.count_publishers(topic) else ", which nobody publishes"
        return f"no {silent[0]} images on {topic}{by_nobody}"

    def _on_info(self, side: str, msg: CameraInfo) -> None:
        self._cameras[side] = camera_from_msg(msg)

    def _on_image(self, side: str, msg: Any) -> None:
        self.watchdog.feed()
        self._images.add(side, stamp_to_ns(msg.header.stamp), msg)

    def _take(self, _: int, images: dict[str, Any]) -> None:
        if len(images) < len(SIDES):
            self._num_single += 1
            self._singles += 1
            self._single_sides.update(images)
            return
        self._singles = 0
        self._single_sides.clear()
        try:
            self._match(images)
            self._problem, self._is_sent = "", True
        except ValueError as error:
            self._problem = str(error)

    def _match(self, images: dict[str, Any]) -> None:
        missing = [side for side in SIDES if side not in self._cameras]
        if missing:
            raise ValueError(f"no camera_info of {' and '.join(missing)}")
        cameras = rectified_pair(*(self._cameras[side] for side in SIDES))
        left, right = (self._pixels_of(images[side], "rgb8") for side in SIDES)
        for side, pixels in zip(SIDES, (left, right), strict=True):
            size = (pixels.shape[1], pixels.shape[0])
            if size != cameras.size:
                raise ValueError(f"the {side} image is {size}, its camera_info {cameras.size}")
        self._on_pair(images["left"].header, left, right, cameras)
        self._num_pairs += 1
