"""What a stereo pair shows: disparities, the left image and its camera_info."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from stereo_msgs.msg import DisparityImage

from floornav_common.ros.messages import compressed_to_array, image_to_array, stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import SENSOR_QOS, create_subscription
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.transform3 import Transform3
from multi_localizer.ros_conversions import camera_from_msg, disparities_from_msg
from multi_localizer.stereo_cameras import CameraModel
from multi_localizer.stereo_localizer_node_config import StereoLocalizerNodeConfig
from multi_localizer.stereo_mount import mounted_camera
from multi_localizer.stereo_view import StereoView, observe
from multi_localizer.voxel_view import ViewCamera

DISPARITY, LEFT = "disparity", "left"


class StereoViewInput:
    """Subscribes to one pair; hands on each part with its stamp.

    Args:
        node: The node.
        name: Of the pair.
        config: The node's.
        target_frame: Frame to bring the camera to, at each stamp.
        add: Called with `<pair>/<part>`, the stamp and the value: for disparities the message and
            the camera's `Transform3`.
    """

    def __init__(
        self,
        node: FloornavNode,
        name: str,
        config: StereoLocalizerNodeConfig,
        target_frame: str,
        add: Callable[[str, int, Any], None],
    ) -> None:
        """Subscribe at once."""
        self.name, self._node = name, node
        self._model: CameraModel | None = None
        is_raw = config.image_transport == "raw"
        kind, ending = (Image, "") if is_raw else (CompressedImage, "/compressed")
        self._pixels_of = image_to_array if is_raw else compressed_to_array

        def on_disparity(msg: Any, T_target_camera: Transform3) -> None:
            self.watchdog.feed()
            add(f"{name}/{DISPARITY}", stamp_to_ns(msg.header.stamp), (msg, T_target_camera))

        def on_left(msg: Any) -> None:
            add(f"{name}/{LEFT}", stamp_to_ns(msg.header.stamp), msg)

        subscription = TransformedSubscription(
            node, DisparityImage, f"stereo/{name}/disparity", SENSOR_QOS, target_frame, on_disparity
        )
        self.watchdog = Watchdog(node, subscription.topic, config.image_timeout_s)
        topic = f"stereo/{name}/left"
        create_subscription(node, kind, f"{topic}/image_rect{ending}", on_left, SENSOR_QOS)
        create_subscription(node, CameraInfo, f"{topic}/camera_info", self._on_info, SENSOR_QOS)

    def camera(self, msg: Any) -> tuple[ViewCamera, Transform3]:
        """Return the camera of a disparity image, and its pose in the base frame.

        Raises:
            ValueError: There is no camera_info, or it does not fit.
            TransformUnavailable: TF does not say where the camera is.
        """
        if self._model is None:
            raise ValueError(f"no camera_info of stereo/{self.name}/left")
        buffer, frame = self._node.transforms.buffer, msg.header.frame_id
        T_base_camera = buffer.lookup(self._node.frames.base, frame, stamp_to_ns(msg.header.stamp))
        try:
            camera = mounted_camera(T_base_camera.matrix(), self._model, float(msg.f), float(msg.t))
        except ValueError as error:
            raise ValueError(f"pair {self.name}: {error}") from error
        return camera, T_base_camera

    def view(self, msg: Any, left: Any, camera: ViewCamera, farthest_m: float) -> StereoView:
        """Return a disparity image and its left image as a view.

        Raises:
            ValueError: If they are no such images, or not of the camera's size.
        """
        pixels: np.ndarray = self._pixels_of(left, "rgb8")
        try:
            return observe(disparities_from_msg(msg), pixels, camera, farthest_m)
        except ValueError as error:
            raise ValueError(f"pair {self.name}: {error}") from error

    def _on_info(self, msg: Any) -> None:
        self._model = camera_from_msg(msg)
