"""Images of a camera, raw or compressed, for the nodes that look at them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from floornav_common.ros.messages import compressed_to_array, image_to_array
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.time_watch import Throttle

TOPIC = "omni/image_raw"
WARN_PERIOD_NS = 5_000_000_000
_ORDERS = {"rgb8": "rgb", "bgr8": "bgr"}


class ImageInput:
    """Subscribes to `omni/image_raw` and hands each image on as pixels.

    Args:
        node: The node.
        transport: `raw` or `compressed`.
        timeout_s: Silence allowed.
        on_image: Called with header, pixels (H, W, 3) and the order of their channels; a
            ValueError of it is said in a throttled warning.
    """

    def __init__(
        self,
        node: FloornavNode,
        transport: str,
        timeout_s: float,
        on_image: Callable[[Any, np.ndarray, str], None],
    ) -> None:
        """Subscribe at once."""
        self._node, self._on_image = node, on_image
        self._warnings = Throttle(WARN_PERIOD_NS)
        is_raw = transport == "raw"
        kind, topic = (Image, TOPIC) if is_raw else (CompressedImage, f"{TOPIC}/compressed")
        callback = self._on_raw if is_raw else self._on_compressed
        subscription = create_subscription(node, kind, topic, callback, SENSOR_QOS)
        self.watchdog = Watchdog(node, subscription.topic_name, timeout_s)

    def warn(self, text: str) -> None:
        """Say something about the input, not too often."""
        if self._warnings.is_due(self._node.time.steady_ns()):
            self._node.get_logger().warning(f"{self.watchdog.topic}: {text}")

    def _on_raw(self, msg: Image) -> None:
        try:
            if msg.encoding in _ORDERS:
                self._take(msg.header, image_to_array(msg), _ORDERS[msg.encoding])
            else:
                self._take(msg.header, image_to_array(msg, "bgr8"), "bgr")
        except ValueError as error:
            self.warn(str(error))

    def _on_compressed(self, msg: CompressedImage) -> None:
        try:
            self._take(msg.header, compressed_to_array(msg), "bgr")
        except ValueError as error:
            self.warn(str(error))

    def _take(self, header: Any, pixels: np.ndarray, order: str) -> None:
        self.watchdog.feed()
        self._on_image(header, pixels, order)
