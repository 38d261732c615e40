"""Rules for the QoS that a topic is offered with: what its usual subscribers ask for."""

from __future__ import annotations

from rosbags.interfaces import Qos, QosDurability, QosReliability

from grid_mapper.contract.rule import OPEN, Rule, Topic, Verdict, of_problems

MAP = Rule(
    "QoS", "reliable and transient local", "Nav2's static layer, AMCL",
    "nav2_costmap_2d static_layer.cpp (map_subscribe_transient_local); nav2_amcl amcl_node.cpp",
)  # fmt: skip
RELIABLE = Rule(
    "QoS", "reliable: subscribers with the system's default get nothing else",
    "Nav2's OdomSmoother, robot_localization, rviz",
    "nav2_util src/odometry_utils.cpp (SystemDefaultsQoS); REP 2003",
)  # fmt: skip
SENSOR = Rule(
    "QoS", "volatile or latched, best effort or reliable: all fit the sensor-data profile",
    "Nav2's layers, slam_toolbox, AMCL",
    "nav2_costmap_2d obstacle_layer.cpp (SensorDataQoS); REP 2003",
)  # fmt: skip
STATIC = Rule(
    "QoS", "reliable and transient local, for who comes later", "tf2_ros",
    "tf2_ros qos.hpp StaticListenerQoS",
)  # fmt: skip
RULES = (MAP, RELIABLE, SENSOR, STATIC)


def qos_rule(msgtype: str, topic: str) -> Rule:
    """Return the rule of a topic by its type."""
    if topic.endswith("tf_static"):
        return STATIC
    name = msgtype.rpartition("/")[2]
    if name == "OccupancyGrid":
        return MAP
    return SENSOR if name in ("LaserScan", "Range") else RELIABLE


def judge_qos(topic: Topic) -> Verdict:
    """Return the verdict on what a topic's publishers offer."""
    rule = qos_rule(topic.msgtype, topic.name)
    if not topic.qos:
        return Verdict(topic.name, rule, OPEN, "the offered QoS was not recorded")
    return of_problems(topic, rule, [qos_problem(profile, rule) for profile in topic.qos])


def qos_problem(profile: Qos, rule: Rule) -> str:
    """Return what a profile offers too little of."""
    lacking = []
    if rule is not SENSOR and profile.reliability == QosReliability.BEST_EFFORT:
        lacking.append("not reliable")
    if rule in (MAP, STATIC) and profile.durability == QosDurability.VOLATILE:
        lacking.append("not transient local")
    return ", ".join(lacking)
