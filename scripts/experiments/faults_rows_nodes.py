"""The faults of nodes: killed, told to end, joined by others that they do not get on with."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from rclpy.node import Node

from experiments.faults_case import Act, Fault
from experiments.faults_graph import SIMULATOR, FaultGraph, GraphError, set_parameters
from experiments.faults_judge import BASE, DRIVE, HALT, OTHER, STAND
from floornav_common.ros.messages import se2_to_pose
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.ros.transforms import TransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

BASE_S = 0.5
"""The base's own limit on the silence of commands (`command_timeout_s`)."""
_POSE_S = 0.6
"""Limit on the pose's age, and how far ahead `grid_mapper` stamps map to odom."""
_MAPPER = "grid_mapper"
_TRUTH = "ground_truth/odom"
_TIMES, _FOUND_S = 3, 10.0
_INTRUDER, _INTRUDER_PERIOD_S = "intruder", 0.05
_DRIVER, _LOCALIZER = "other_driver", "other_localizer"
_AWAY_M = 1.5
_NOTICED_S = 0.5
"""Time for a node's first messages to be heard, and for two of them."""


def process_faults() -> list[Fault]:
    """Return the faults of nodes that end."""
    on = "drives on by what it has; goes on to new goals when it is back"
    again = "started again on the map saved before, told where it is to 0.1 m"
    late = "the base brakes 0.5 s after the last command (its own limit)"
    pose = "zero when map to odom, stamped 0.1 s ahead, is 0.5 s old"
    return [
        _killed("local_planner", late, BASE, BASE_S),
        _with_saved_map(_killed("grid_mapper", f"{pose}; {again}", HALT, _POSE_S)),
        _killed("wavefront_planner", on, DRIVE),
        _killed("floor_detector", "drives on by laser", DRIVE),
        _ended("local_planner", "zero as its last word; exit code 0", HALT),
        _with_saved_map(_ended("grid_mapper", f"{pose}; exit code 0; {again}", HALT, _POSE_S)),
        _ended("wavefront_planner", f"{on}; exit code 0", DRIVE),
        _ended("floor_detector", "drives on by laser; exit code 0", DRIVE),
    ]  # fmt: skip


def simulator_fault() -> Fault:
    """Return the end of the simulator: of sensors, clock and base at once. To be the last."""

    def strike(graph: FaultGraph) -> None:
        graph.send_signal(SIMULATOR, signal.SIGKILL)

    def mend(graph: FaultGraph) -> None:
        graph.start_node(SIMULATOR)
        began_ns, told = graph.relay.now_ns, graph.watch.counts.get(_TRUTH, 0)
        graph.wait(lambda: graph.relay.now_ns > began_ns, "simulated time", 600.0)
        graph.wait(lambda: graph.watch.counts.get(_TRUTH, 0) > told, "where it began anew", 600.0)
        _place(graph)

    def problem(graph: FaultGraph) -> str:
        state, reason = graph.watch.state
        is_said = state == "stopped" and "/clock" in reason
        return "" if is_said else f"the planner says {state}: {reason}"

    return Fault(
        name="kill-sim_bridge", what="SIGKILL to sim_bridge: clock, sensors and base are gone",
        expected="the planner says that /clock stands still, and sends zero; the simulator begins "
        "anew, and grid_mapper is told that the robot is at its start", kind=OTHER,
        strike=strike, mend=mend, hold_s=4.0, has_time=False, check=problem,
        stops_clock=True,
    )  # fmt: skip


def company_faults() -> list[Fault]:
    """Return the faults of others in the graph, and of places of sensors that are missing."""
    return [
        Fault(
            name="second-cmd_vel", what="another node sends commands too", kind=DRIVE,
            expected="an ERROR on /diagnostics that names it; touches nothing",
            strike=_intrude(_DRIVER, _send_commands), mend=_leave, hold_s=4.0,
            check=_is_named(_DRIVER, "cmd_vel"),
        ),
        Fault(
            name="second-map-odom", what="another node sends map to odom, 1.5 m beside", kind=HALT,
            expected="zero within 0.5 s: the pose jumps to and fro; grid_mapper sends none any "
            "more, and an ERROR that names the other; goes on when that one is gone",
            limit_s=_NOTICED_S,
            strike=_intrude(_LOCALIZER, _send_transforms), mend=_leave, hold_s=4.0,
            check=_is_named(_LOCALIZER, "transform map to odom"),
        ),
        Fault(
            name="tf-missing", what="local_planner starts anew, and no /tf_static comes",
            kind=STAND, expected="stands, and says which frame is missing", hold_s=3.0,
            strike=_without_statics, mend=lambda graph: graph.relay.give_statics(),
            check=_says("laser"),
        ),
    ]  # fmt: skip


def killing(name: str, sign: signal.Signals = signal.SIGKILL) -> Act:
    """Return what ends a node by a signal."""
    return lambda graph: graph.send_signal(name, sign)


def restarting(name: str) -> Act:
    """Return what starts a node again."""
    return lambda graph: graph.start_node(name)


def _with_saved_map(fault: Fault) -> Fault:
    """Return a fault of `grid_mapper` that is mended with the map of before and the last pose."""

    def strike(graph: FaultGraph) -> None:
        set_parameters(graph, _MAPPER, map_file=str(graph.out / fault.name))
        graph.notes["map"] = graph.call(f"{_MAPPER}/save_map").message
        graph.notes["struck_ns"] = graph.relay.now_ns
        fault.strike(graph)

    def mend(graph: FaultGraph) -> None:
        graph.start_node(_MAPPER, "-p", f"start_map:={graph.notes['map']}")
        _place(graph)

    return replace(fault, strike=strike, mend=mend)


def _place(graph: FaultGraph) -> None:
    """Tell the mapper where the robot is, to 0.1 m and 0.1 rad as a person would on a screen."""
    true = graph.T_world_goals.inverse() @ graph.watch.truth[-1][1]
    pose = SE2(*(round(value, 1) for value in (true.x, true.y, true.yaw)))
    publisher = graph.watch.create_publisher(PoseWithCovarianceStamped, "initialpose", RELIABLE_QOS)
    graph.wait(lambda: publisher.get_subscription_count() > 0, "grid_mapper")
    msg = PoseWithCovarianceStamped()
    msg.pose.pose = se2_to_pose(pose)
    msg.header.frame_id = "map"
    for axis in (0, 7, 35):
        msg.pose.covariance[axis] = 0.05
    num = graph.watch.counts.get("pose", 0)
    for _ in range(_TIMES):
        publisher.publish(msg)
        with contextlib.suppress(GraphError):  # then it is told once more
            graph.wait(lambda: graph.watch.counts.get("pose", 0) > num, "a pose", _FOUND_S)
            break
    graph.watch.destroy_publisher(publisher)


def _killed(name: str, expected: str, kind: str, limit_s: float = 0.0) -> Fault:
    return Fault(
        name=f"kill-{name}", what=f"SIGKILL to {name}, then it is started again", kind=kind,
        limit_s=limit_s, expected=expected, strike=killing(name), mend=restarting(name),
    )  # fmt: skip


def _ended(name: str, expected: str, kind: str, limit_s: float = 0.0) -> Fault:
    def problem(graph: FaultGraph) -> str:
        code = graph.wait_for_end(name)
        return f"{name} ended with {code}" if code else ""

    return Fault(
        name=f"sigterm-{name}", what=f"SIGTERM to {name}, then it is started again", kind=kind,
        limit_s=limit_s, expected=expected, strike=killing(name, signal.SIGTERM),
        mend=restarting(name), check=problem,
    )  # fmt: skip


def _intrude(name: str, make: Callable[[Node, FaultGraph], Callable[[], None]]) -> Act:
    """Return what starts a node that does something twenty times a second."""

    def strike(graph: FaultGraph) -> None:
        node = Node(name)
        node.create_timer(_INTRUDER_PERIOD_S, make(node, graph))
        graph.notes[_INTRUDER] = node
        graph.add(node)

    return strike


def _leave(graph: FaultGraph) -> None:
    graph.remove(graph.notes.pop(_INTRUDER))


def _send_commands(node: Node, _graph: FaultGraph) -> Callable[[], None]:
    publisher = node.create_publisher(Twist, "cmd_vel", RELIABLE_QOS)
    msg = Twist()
    msg.linear.x, msg.angular.z = 0.2, 0.1
    return lambda: publisher.publish(msg)


def _send_transforms(node: Node, graph: FaultGraph) -> Callable[[], None]:
    broadcaster = TransformBroadcaster(node)
    beside = Transform3.from_se2(SE2(0.0, _AWAY_M, 0.0))
    return lambda: broadcaster.send("map", "odom", graph.relay.now_ns, beside)


def _without_statics(graph: FaultGraph) -> None:
    graph.relay.withhold_statics()
    graph.send_signal("local_planner", signal.SIGKILL)
    graph.wait_for_end("local_planner")
    graph.start_node("local_planner")
    graph.wait(lambda: graph.watch.speed < 0.01, "a robot that stands")
    graph.spin_sim(1.0)
    graph.notes["struck_ns"] = graph.relay.now_ns


def _is_named(name: str, part: str) -> Callable[[FaultGraph], str]:
    """Return what looks whether a part of the diagnostics is an error that names the intruder."""

    def problem(graph: FaultGraph) -> str:
        parts = graph.watch.said.items()
        said: list[Any] = [what for key, what in parts if key.endswith(f": {part}")]
        found = [text for level, text in said if level == 2 and name in text]
        return "" if found else f"no ERROR names it: {said}"

    return problem


def _says(word: str) -> Callable[[FaultGraph], str]:
    def problem(graph: FaultGraph) -> str:
        state, reason = graph.watch.state
        return "" if word in reason else f"the planner says {state}: {reason}"

    return problem
