"""The faults of what a robot is told: goals, paths and maps that are no numbers, or no maps."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Path

from experiments.faults_case import Act, Fault
from experiments.faults_changes import edited, no_numbers
from experiments.faults_graph import FaultGraph, stereo_topics
from experiments.faults_judge import DIP, DRIVE, HALT
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS

_MATCHER = "stereo_matcher"


def told_faults() -> list[Fault]:
    """Return the faults of goals, paths and maps."""
    gone = "refused; what was told before does not count any more: zero"
    kept = "refused and said; drives on by the map it has"
    return [
        Fault(
            name="nan-goal", what="a goal of NaN", kind=HALT, expected=gone,
            strike=_telling(PoseStamped, "goal_pose", RELIABLE_QOS, _no_goal), mend=_untell,
        ),
        Fault(
            name="nan-path", what="a path of NaN", kind=HALT, expected=gone,
            strike=_telling(Path, "path", LATCHED_QOS, _no_path), mend=_untell,
        ),
        Fault(
            name="nan-map", what="a map whose resolution and origin are NaN", kind=DRIVE,
            expected=kept, strike=_telling(OccupancyGrid, "map", LATCHED_QOS, _no_map),
            mend=_untell, check=_in_log("wavefront_planner", "map refused"),
        ),
        Fault(
            name="short-map", what="a map with fewer cells than its size says", kind=DRIVE,
            expected=kept, strike=_telling(OccupancyGrid, "map", LATCHED_QOS, _short_map),
            mend=_untell, check=_in_log("wavefront_planner", "map refused"),
        ),
        Fault(
            name="nan-glass-map", what="a layer of glass whose resolution and origin are NaN",
            kind=DIP, expected="zero in the next period, until a good one comes",
            strike=_telling(OccupancyGrid, "map/glass", LATCHED_QOS, _no_map), mend=_untell,
        ),
        Fault(
            name="nan-camera_info", kind=DRIVE, hold_s=4.0,
            what="every float of the stereo cameras' models is NaN; stereo_matcher runs too",
            expected="drives on; stereo_matcher gives no disparity, and lives",
            strike=_blind_stereo, mend=_see_stereo, check=_is_without_disparity,
            after=_has_disparity,
        ),
    ]  # fmt: skip


def _telling(kind: type, topic: str, qos: Any, make: Callable[[], Any]) -> Act:
    """Return what publishes one message beside those who usually do."""

    def strike(graph: FaultGraph) -> None:
        graph.watch.sends_goals = False
        publisher = graph.notes["told"] = graph.watch.create_publisher(kind, topic, qos)
        num = graph.watch.count_subscribers(topic)
        graph.wait(lambda: publisher.get_subscription_count() >= num, f"listeners of {topic}")
        graph.spin(0.5)  # they hear of it a moment later
        graph.notes["struck_ns"] = graph.relay.now_ns
        publisher.publish(make())

    return strike


def _untell(graph: FaultGraph) -> None:
    graph.watch.destroy_publisher(graph.notes.pop("told"))
    graph.watch.sends_goals = True


def _no_goal() -> PoseStamped:
    msg = PoseStamped()
    no_numbers(msg)
    msg.header.frame_id = "map"
    return msg


def _no_path() -> Path:
    msg = Path(poses=[PoseStamped(), PoseStamped()])
    no_numbers(msg)
    msg.header.frame_id = "map"
    return msg


def _map() -> OccupancyGrid:
    msg = OccupancyGrid()
    msg.header.frame_id = "map"
    msg.info.width = msg.info.height = 20
    msg.info.resolution, msg.info.origin.orientation.w = 0.05, 1.0
    msg.data = array("b", [0] * 400)
    return msg


def _no_map() -> OccupancyGrid:
    msg = _map()
    msg.info.resolution = msg.info.origin.position.x = math.nan
    return msg


def _short_map() -> OccupancyGrid:
    msg = _map()
    msg.data = array("b", [0] * 123)
    return msg


def _in_log(name: str, text: str) -> Callable[[FaultGraph], str]:
    def problem(graph: FaultGraph) -> str:
        log = (graph.out / "logs" / f"{name}.log").read_text(errors="replace")
        return "" if text in log else f"{name} does not say '{text}'"

    return problem


def _blind_stereo(graph: FaultGraph) -> None:
    for topic, kind in stereo_topics(graph.model).items():
        graph.relay.add(topic, kind)
        if topic.endswith("camera_info"):
            graph.relay.set_change(topic, edited(no_numbers))
    graph.watch.count_disparities()
    graph.watch.counts["disparity"] = 0
    graph.start_node(_MATCHER)
    graph.spin_sim(2.0)


def _see_stereo(graph: FaultGraph) -> None:
    for topic in stereo_topics(graph.model):
        graph.relay.set_change(topic, None)


def _is_without_disparity(graph: FaultGraph) -> str:
    if graph.children.exit_code(_MATCHER) is not None:
        return f"{_MATCHER} ended"
    num = graph.watch.counts.get("disparity", 0)
    return f"{num} disparities by cameras of NaN" if num else ""


def _has_disparity(graph: FaultGraph) -> str:
    """Look whether it recovers, and end it: nothing else here needs it."""
    try:
        graph.wait(lambda: graph.watch.counts.get("disparity", 0) > 0, "a disparity", 20.0)
    except RuntimeError as error:
        return str(error)
    finally:
        graph.expected_dead.add(_MATCHER)
        graph.children.stop(_MATCHER)
    return ""
