"""The image topics of one simulated robot."""

from __future__ import annotations

from sensor_msgs.msg import CameraInfo, Image

from floornav_common.ros.messages import array_to_image, ns_to_stamp
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from sim_bridge.camera_config import optical_frame
from sim_bridge.observations import RobotObservation
from sim_bridge.robot_model import RobotModel
from sim_bridge.ros_conversions import camera_info_msg
from sim_bridge.views import OMNI

SIDES = ("left", "right")


class CameraPort:
    """Publishes what a robot's cameras see; a robot without cameras has none of the topics.

    Args:
        node: The node.
        topic: Stands before the topics' names.
        frame_prefix: Stands before the frames' names.
        model: The robot.
    """

    def __init__(
        self, node: FloornavNode, topic: str, frame_prefix: str, model: RobotModel
    ) -> None:
        """Create the topics."""
        self._prefix, self._model = frame_prefix, model
        omni, stereo = model.config.omni, model.config.stereo
        if omni is not None:
            self._omni_pub = create_publisher(node, Image, f"{topic}omni/image_raw", RELIABLE_QOS)
        self._pubs = {
            (pair, side): tuple(
                create_publisher(node, kind, f"{topic}stereo/{pair}/{side}/{name}", RELIABLE_QOS)
                for kind, name in ((Image, "image_rect"), (CameraInfo, "camera_info"))
            )
            for pair in (() if stereo is None else stereo.pairs)
            for side in SIDES
        }

    def is_watched(self, camera: str) -> bool:
        """Tell whether anybody subscribes to a topic of `OMNI` or of a stereo pair."""
        if camera == OMNI:
            return self._omni_pub.get_subscription_count() > 0
        pubs = [pub for side in SIDES for pub in self._pubs[camera, side]]
        return any(pub.get_subscription_count() > 0 for pub in pubs)

    def publish(self, stamp_ns: int, seen: RobotObservation) -> None:
        """Publish the images of a step, if there are any."""
        stamp, config = ns_to_stamp(stamp_ns), self._model.config
        if seen.omni is not None and config.omni is not None:
            frame = self._prefix + config.omni.frame
            self._omni_pub.publish(array_to_image(seen.omni, "rgb8", stamp, frame))
        for pair, images in ({} if seen.stereo is None else seen.stereo).items():
            # Both cameras speak of the left one's frame, as image_geometry's stereo model wants.
            frame = self._prefix + optical_frame(pair, "left")
            for side, pixels in zip(SIDES, (images.left, images.right), strict=True):
                shift = self._model.baseline(pair) if side == "right" else 0.0
                image_pub, info_pub = self._pubs[pair, side]
                image_pub.publish(array_to_image(pixels, "rgb8", stamp, frame))
                info_pub.publish(camera_info_msg(config.stereo, shift, stamp, frame))
