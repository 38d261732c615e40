"""The sonar topics of one simulated robot."""

from __future__ import annotations

import math

from sensor_msgs.msg import Range

from floornav_common.readings import RangeReading
from floornav_common.ros.messages import ns_to_stamp, range_to_msg
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from sim_bridge.robot_model import RobotModel


class SonarPort:
    """Publishes readings on `sonar`, told apart by frame, or each on its own `sonar_<k>`.

    Args:
        node: The node.
        topic: What the robot's topics begin with.
        prefix: What its frames begin with.
        model: Its model.
        is_one_topic: True for all on one topic.
    """

    def __init__(
        self, node: FloornavNode, topic: str, prefix: str, model: RobotModel, *, is_one_topic: bool
    ) -> None:
        """Create the topics; a robot without sonars has none."""
        frames = model.config.sonar_frames
        self._frames = [prefix + frame for frame in frames]
        names = ["sonar" if is_one_topic else f"sonar_{k}" for k in range(len(frames))]
        made = {
            name: create_publisher(node, Range, topic + name, RELIABLE_QOS)
            for name in dict.fromkeys(names)
        }
        self._publishers = [made[name] for name in names]

    def publish(self, stamp_ns: int, readings: tuple[RangeReading, ...]) -> None:
        """Publish the readings of the sonars that fired."""
        stamp = ns_to_stamp(stamp_ns)
        for frame, publisher, reading in zip(self._frames, self._publishers, readings, strict=True):
            if not math.isnan(reading.range):
                publisher.publish(range_to_msg(reading, stamp, frame))
