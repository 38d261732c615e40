"""A graph of `evaluate.py faults`: its processes, the relay among them, what is done to it."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, LaserScan, Range
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from _processes import Processes
from experiments.faults_heard import FaultWatch
from experiments.faults_relay import FaultRelay, raw_name
from experiments.faults_setups import Setup
from floornav_common.ros.main import make_executor
from sim_bridge.robot_model import RobotModel

SIMULATOR = "sim_bridge"
EXCEPTION = "Traceback"  # what logs hold where one was not handled
_KINDS = {
    "/clock": Clock, "/tf": TFMessage, "/tf_static": TFMessage, "odom": Odometry,
    "scan": LaserScan, "sonar": Range, "omni/image_raw": Image,
}  # fmt: skip
_READY_S = 600.0  # the first time kernels are compiled, maybe on a busy machine
_STANDS_STILL_S = 240.0  # real time without simulated time going on
_CLOCK_PERIOD_S, _PACE_LAG_S, _PACE_TIMEOUT_S = 0.01, 0.06, 1.0


class GraphError(RuntimeError):
    """The graph did not do what it must before or between faults."""


class FaultGraph:
    """Runs the nodes, and does to them what a fault asks for.

    Args:
        setup: Which graph.
        out: For logs and settings.
        seed: Of the simulator.
        rtf: Simulated seconds in a second, at most.

    Attributes:
        setup: As given.
        relay: Between the simulator and the nodes.
        watch: What is heard.
        children: The processes.
        T_world_goals: Where the frame of the goals is.
        expected_dead: Names of processes that a fault ended.
        notes: What a fault found out on its way, by name; for its checks.
    """

    def __init__(self, setup: Setup, out: Path, seed: int, rtf: float = 1.0) -> None:
        self.setup, self.out, self._seed, self.rtf = setup, out, seed, rtf
        self.world, self.model, self.T_world_goals = setup.load()
        self.expected_dead: set[str] = set()
        self.notes: dict[str, Any] = {}
        self._starts: dict[str, int] = {}

    def __enter__(self) -> FaultGraph:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        goals = self.T_world_goals.inverse() @ self.setup.goals
        topics = {topic: _KINDS[topic] for topic in self.setup.topics}
        self.relay = FaultRelay(topics, {"cmd_vel": Twist})
        has_paths = "wavefront_planner" in self.setup.nodes
        self.watch = FaultWatch(self.relay, goals, self.setup.frame, has_paths=has_paths)
        self.relay.on_sent["cmd_vel"] = self.watch.on_command
        self._executor = make_executor()
        for node in (self.relay, self.watch):
            self.add(node)
        environ = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self.children = Processes(self.out / "logs", environ)
        return self

    def __exit__(self, *_: object) -> None:
        self.children.stop_all()
        for node in (self.relay, self.watch):
            node.destroy_node()
        rclpy.try_shutdown()

    def add(self, node: Any) -> None:
        """Let a node of ours work too."""
        self._executor.add_node(node)

    def remove(self, node: Any) -> None:
        """Take it away."""
        self._executor.remove_node(node)
        node.destroy_node()

    @property
    def sim_s(self) -> float:
        """The simulator's time."""
        return self.relay.now_ns * 1e-9

    def start(self, say: Callable[[str], None]) -> None:
        """Start all processes, the simulator last, and wait until its time goes on."""
        self._settings = self.setup.write(self.out / "nodes", self.world, self.model)
        for name in self.setup.nodes:
            self.start_node(name, waits=False)
        for name in self.setup.nodes:
            say(f"waiting for {name} ...")
            self.wait_ready(name)
        say(f"waiting for {SIMULATOR} ...")
        self.start_node(SIMULATOR)
        self.wait(lambda: self.relay.now_ns > 0, "simulated time", _READY_S)

    def start_node(self, name: str, *words: str, waits: bool = True) -> None:
        """Start a process, again if it ended, told some words more; earlier logs are kept."""
        number = self._starts[name] = self._starts.get(name, 0) + 1
        log = self.out / "logs" / f"{name}.log"
        if log.exists():
            log.rename(log.with_name(f"{name}-{number - 1}.log"))
        command = (
            self._simulator() if name == SIMULATOR else self.setup.command(name, self._settings)
        )
        self.children.start(name, [*command, *words])
        self.expected_dead.discard(name)
        if waits:
            self.wait_ready(name)

    def wait_ready(self, name: str) -> None:
        """Wait until a process says that it is ready; those that a fault ended do not matter."""
        log, end = self.out / "logs" / f"{name}.log", time.monotonic() + _READY_S
        while "ready" not in log.read_text(errors="replace"):
            self.spin(0.05)
            self._check()
            if time.monotonic() > end:
                raise GraphError(f"{name} is not ready:\n{self.children.tail(name)}")

    def send_signal(self, name: str, sign: signal.Signals) -> None:
        """Send a signal to a process; it may end."""
        self.expected_dead.add(name)
        os.kill(self.children.pids[name], sign)

    def wait_for_end(self, name: str, timeout_s: float = 60.0) -> int:
        """Return the exit code of a process that ends, real time."""
        end = time.monotonic() + timeout_s
        while (code := self.children.exit_code(name)) is None:
            self.spin(0.02)
            if time.monotonic() > end:
                raise GraphError(f"{name} does not end")
        return code

    def spin(self, seconds: float) -> None:
        """Work for a while of real time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.01)
            self.watch.look()

    def spin_sim(self, seconds: float) -> None:
        """Work for a while of the simulator's time."""
        end_ns = self.relay.now_ns + round(seconds * 1e9)
        self.wait(lambda: self.relay.now_ns >= end_ns, f"{seconds} s of simulated time", np.inf)

    def wait(self, is_so: Callable[[], bool], what: str, sim_s: float = 60.0) -> None:
        """Work until something is so.

        Raises:
            GraphError: It was not within simulated seconds, or the simulator stood still.
        """
        began_ns = moved_ns = self.relay.now_ns
        moved_at = time.monotonic()
        while not is_so():
            self.spin(0.02)
            self._check()
            if self.relay.now_ns != moved_ns:
                moved_ns, moved_at = self.relay.now_ns, time.monotonic()
            if time.monotonic() - moved_at > _STANDS_STILL_S:
                raise GraphError(f"{what}: the simulator stands still at {self.sim_s:.1f} s")
            if 0 <= began_ns < moved_ns - sim_s * 1e9:
                raise GraphError(f"{what}: not so within {sim_s:.0f} s")

    def call(self, service: str) -> Any:
        """Return the answer of a Trigger service."""
        client = self.watch.create_client(Trigger, service)
        try:
            self.wait(client.service_is_ready, f"service {service}")
            answer = client.call_async(Trigger.Request())
            self.wait(answer.done, f"an answer of {service}")
            return answer.result()
        finally:
            self.watch.destroy_client(client)

    def count_logged(self, words: str) -> int:
        """Return how often the logs of all processes hold some words."""
        logs = (self.out / "logs").glob("*.log")
        return sum(log.read_text(errors="replace").count(words) for log in logs)

    def _check(self) -> None:
        for name in self._starts:
            if name not in self.expected_dead and self.children.exit_code(name) is not None:
                tail = self.children.tail(name)
                raise GraphError(f"{name} ended by itself; its last lines:\n{tail}")

    def _simulator(self) -> list[str]:
        told = {
            "world": self.setup.world, "seed": str(self._seed), "real_time_factor": str(self.rtf),
            "start_nodes": "[fault_relay, fault_watch]",
            "pace_lag_s": str(_PACE_LAG_S), "pace_timeout_s": str(_PACE_TIMEOUT_S),
            "clock_period_s": str(_CLOCK_PERIOD_S),
        }  # fmt: skip
        if self.setup.is_paced:
            told["pace_topics"] = "[cmd_vel]"
        words = [word for key, value in told.items() for word in ("-p", f"{key}:={value}")]
        stereo = stereo_topics(self.model) if self.setup.relays_stereo else ()
        for topic in {*self.relay.passed, *stereo}:
            words += ["-r", f"{topic}:={raw_name(topic)}"]
        return [sys.executable, "-m", "sim_bridge.nodes.sim_bridge_node", "--ros-args", *words]


def stereo_topics(model: RobotModel) -> dict[str, type]:
    """Return what a robot's stereo pairs publish."""
    pairs = () if model.config.stereo is None else model.config.stereo.pairs
    kinds = {"image_rect": Image, "camera_info": CameraInfo}
    return {
        f"stereo/{pair}/{side}/{name}": kind
        for pair in pairs
        for side in ("left", "right")
        for name, kind in kinds.items()
    }


def parameter_client(graph: FaultGraph, node: str) -> Any:
    """Return what sets parameters of a node."""
    from rclpy.parameter_client import AsyncParameterClient

    return AsyncParameterClient(graph.watch, node)


def set_parameters(graph: FaultGraph, node: str, **values: Any) -> list[Any]:
    """Set parameters of a running node, and return what it says to each."""
    from rclpy.parameter import Parameter

    client = parameter_client(graph, node)
    graph.wait(client.services_are_ready, f"parameters of {node}")
    answer = client.set_parameters([Parameter(k, value=v) for k, v in values.items()])
    graph.wait(answer.done, f"parameters of {node}")
    return list(answer.result().results)
