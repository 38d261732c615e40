"""Images of a camera, raw or compressed, for the nodes that look at them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from floornav_common.ros.diagnostics import ERROR, Status
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
            ValueError of it refuses the image, which is said in a throttled warning.

    Attributes:
        refusal: Why the newest image was refused; "" if it was not.
        doubt: What is doubtful about the newest image that was taken; "" if nothing.
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
        self.refusal = self.doubt = ""
        is_raw = transport == "raw"
        kind, topic = (Image, TOPIC) if is_raw else (CompressedImage, f"{TOPIC}/compressed")
        callback = self._on_raw if is_raw else self._on_compressed
        subscription = create_subscription(node, kind, topic, callback, SENSOR_QOS)
        self.watchdog = Watchdog(node, subscription.topic_name, timeout_s)

    def warn(self, text: str) -> None:
        """Say something about the input, not too often."""
        if self._warnings.is_due(self._node.time.steady_ns()):
            self._node.get_logger().warning(f"{self.watchdog.topic}: {text}")

    def set_doubt(self, doubt: str) -> None:
        """Take what is doubtful about the images, "" for nothing; what is new goes to the log."""
        if doubt and doubt != self.doubt:
            self._node.get_logger().warning(f"{self.watchdog.topic}: {doubt}")
        self.doubt = doubt

    def refused(self, nothing: str, values: Mapping[str, Any]) -> Status:
        """Return the status of a node whose newest image was refused.

        Args:
            nothing: What is not sent now.
            values: Numbers beside it.
        """
        return Status(ERROR, f"{nothing}, the image is refused: {self.refusal}", values)

    def _on_raw(self, msg: Image) -> None:
        self._take(msg, lambda: _pixels_of(msg))

    def _on_compressed(self, msg: CompressedImage) -> None:
        self._take(msg, lambda: _pixels_of_compressed(msg))

    def _take(self, msg: Any, pixels_of: Callable[[], tuple[np.ndarray, str]]) -> None:
        self.watchdog.feed()
        try:
            self._on_image(msg.header, *pixels_of())
        except ValueError as error:
            self.refusal = str(error)
            self.warn(self.refusal)
        else:
            self.refusal = ""


def _pixels_of(msg: Image) -> tuple[np.ndarray, str]:
    _refuse_gray(msg.encoding)
    if msg.encoding in _ORDERS:
        return image_to_array(msg), _ORDERS[msg.encoding]
    return image_to_array(msg, "bgr8"), "bgr"


def _pixels_of_compressed(msg: CompressedImage) -> tuple[np.ndarray, str]:
    _refuse_gray(msg.format.split(";")[0].strip())
    return compressed_to_array(msg), "bgr"


def _refuse_gray(encoding: str) -> None:
    if encoding.startswith("mono"):
        raise ValueError(f"image must have colors, as rgb8, bgr8 or bgra8, got {encoding}")
