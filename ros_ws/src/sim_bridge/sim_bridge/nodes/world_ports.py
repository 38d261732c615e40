"""The topics of a world: those of each robot by the TF scheme, and those of people."""

from __future__ import annotations

from collections.abc import Mapping

from geometry_msgs.msg import PoseArray

from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.ros.transforms import StaticTransformBroadcaster, TransformBroadcaster
from sim_bridge.config import SimBridgeConfig
from sim_bridge.nodes.robot_port import RobotPort
from sim_bridge.observations import Observations
from sim_bridge.robot_model import RobotModel
from sim_bridge.ros_conversions import people_msg

_PEOPLE_PERIOD_NS = 100_000_000


def robot_ports(
    node: FloornavNode, config: SimBridgeConfig, models: Mapping[str, RobotModel]
) -> dict[str, RobotPort]:
    """Return a port for each robot.

    With `tf_scheme: prefix` all share /tf and a robot's name stands before its frames; with
    `topic` each has TF topics of its own and plain frames, as after `-r /tf:=tf`.
    """
    has_own_topics = config.tf_scheme == "topic"
    if not has_own_topics:
        shared = TransformBroadcaster(node), StaticTransformBroadcaster(node)
    ports = {}
    for name, model in models.items():
        below = f"{name}/" if name else ""
        prefix = node.frames.frame_prefix
        if has_own_topics:
            tf = TransformBroadcaster(node, f"{below}tf")
            tf_static = StaticTransformBroadcaster(node, f"{below}tf_static")
        else:
            (tf, tf_static), prefix = shared, prefix + below
        ports[name] = RobotPort(
            node, name, model, is_stamped=config.enable_stamped_cmd_vel,
            is_one_sonar_topic=config.sonar_topics == "one",
            tf=tf, tf_static=tf_static, frame_prefix=prefix,
        )  # fmt: skip
    return ports


class PeoplePort:
    """Publishes where people truly are, on `ground_truth/people`, ten times a second.

    Args:
        node: The node.
    """

    def __init__(self, node: FloornavNode) -> None:
        """Create the topic."""
        topic = "ground_truth/people"
        self._publisher = create_publisher(node, PoseArray, topic, RELIABLE_QOS)

    def publish(self, seen: Observations) -> None:
        """Publish one step, if it is due."""
        if seen.stamp_ns % _PEOPLE_PERIOD_NS == 0:
            self._publisher.publish(people_msg(seen.ground_truth_people, seen.stamp_ns))
