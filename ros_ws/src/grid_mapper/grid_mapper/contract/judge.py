"""All rules on all topics."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grid_mapper.contract import frames, maps, poses, qos, scans
from grid_mapper.contract.rule import Rule, Topic, Verdict

_JUDGES: dict[str, Callable[[Topic], list[Verdict]]] = {
    "sensor_msgs/msg/LaserScan": scans.judge_scans,
    "sensor_msgs/msg/Range": scans.judge_ranges,
    "nav_msgs/msg/Odometry": poses.judge_odometry,
    "geometry_msgs/msg/PoseWithCovarianceStamped": poses.judge_poses,
    "nav_msgs/msg/OccupancyGrid": maps.judge_maps,
}
TRANSFORMS = "tf2_msgs/msg/TFMessage"
JUDGED_TYPES = (*_JUDGES, TRANSFORMS)
RULES: tuple[Rule, ...] = (
    *frames.RULES, *scans.RULES, *poses.RULES, *maps.RULES, *qos.RULES
)  # fmt: skip
_MAP = "nav_msgs/msg/OccupancyGrid"


def judge(topics: Sequence[Topic]) -> list[Verdict]:
    """Return the verdicts on all topics whose types have rules, topic by topic."""
    tree = frames.tree_of(topic for topic in topics if topic.msgtype == TRANSFORMS)
    verdicts: list[Verdict] = []
    for topic in topics:
        if topic.msgtype not in JUDGED_TYPES:
            continue
        verdicts.append(qos.judge_qos(topic))
        if topic.msgtype == TRANSFORMS:
            verdicts += frames.judge_transforms(topic, tree)
            continue
        verdicts += frames.judge_headers(topic, is_latched=topic.msgtype == _MAP)
        if topic.msgtype != _MAP:
            verdicts.append(frames.judge_connection(topic, tree))
        verdicts += _JUDGES[topic.msgtype](topic)
    return verdicts
