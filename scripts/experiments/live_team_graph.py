"""The graph of `live_team`: simulator, nodes of each robot, and what is heard of them."""

from __future__ import annotations

import math
import os
import sys
import time
from collections import defaultdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from _processes import Processes, free_domain
from floornav_common.ros.messages import pose_to_se2, ros_cov_to_se2, stamp_to_ns
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference
from multi_localizer.stamped_values import StampedValues

RUN_NODE = Path(__file__).resolve().parent.parent / "run_node.py"
ROBOTS = {"r1": 0.5, "r2": 0.5, "r3": -0.5, "r4": 0.5}
"""How each turns, rad/s."""
SPEED = 0.3
_NODES = (
    ("floor_perception", "marker_detector"),
    ("multi_localizer", "landmark_localizer"),
    ("multi_localizer", "team_localizer"),
)
_READY_S = 600.0  # the first time kernels are compiled, maybe on a busy machine
_ALL_NS = 3600 * 10**9


def run_graph(duration_s: float, rate: float, seed: int, log_dir: Path) -> Heard:
    """Run simulator and nodes for a while of simulated time, and return what was heard."""
    domain = free_domain()
    parameters = _write_parameters(log_dir / "team.yaml")
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain), "PYTHONUNBUFFERED": "1"}
    with Processes(log_dir, env) as processes, Heard(domain) as heard:
        for name in ROBOTS:
            processes.start(name, [sys.executable, *_robot_words(name, parameters)])
        for name in ROBOTS:
            for _, node in _NODES:
                ready = f"[{name}.{node}]: ready"
                processes.wait_for_line(name, ready, _READY_S, heard.spin)
        processes.start("sim_bridge", [
            sys.executable, str(RUN_NODE), "sim_bridge", "sim_bridge", "--ros-args",
            "-p", "world:=middle_size_field", "-p", f"seed:={seed}",
            "-p", f"real_time_factor:={rate}",
        ])  # fmt: skip
        processes.wait_for_line("sim_bridge", "ready", _READY_S, heard.spin)
        end = time.monotonic() + _READY_S + 20.0 * duration_s / rate
        while heard.time_s < duration_s:
            processes.check()
            heard.drive()
            heard.spin()
            if time.monotonic() > end:
                raise RuntimeError(f"the simulator stands still at {heard.time_s:.1f} s")
    return heard


def _robot_words(name: str, parameters: Path) -> list[str]:
    words = [str(RUN_NODE), "floornav_common", "compose", *(f"{p}/{n}" for p, n in _NODES)]
    words += ["--ros-args", "-r", f"__ns:=/{name}", "--params-file", str(parameters)]
    return [*words, "-p", "use_sim_time:=true", "-p", f"frame_prefix:={name}/"]


def _write_parameters(path: Path) -> Path:
    """Write what the nodes of all robots are told; the same file serves each."""
    camera = {"camera_model": "soccer_middle_size"}
    place = {"landmarks": "middle_size_field"}
    team = {"team": list(ROBOTS), "pose_topic": "landmark_pose", "bearing_sd_rad": 0.005}
    told = {
        "marker_detector": camera,
        "landmark_localizer": camera | place,
        "team_localizer": place | team,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    nodes = {f"/**/{node}": {"ros__parameters": values} for node, values in told.items()}
    path.write_text(yaml.safe_dump(nodes))
    return path


class Heard:
    """What the test's own node hears, and how it drives the robots.

    Attributes:
        time_s: Simulated time so far.
        num_images: Rounds of bearings of the first robot.
        last_states: What its team_localizer says of each part: text and values.
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self.time_s = 0.0
        self.num_images = 0
        self.last_states: dict[str, tuple[str, str]] = {}
        self._truth: dict[str, StampedValues[SE2]] = {n: StampedValues(_ALL_NS) for n in ROBOTS}
        self._poses: dict[tuple[str, str], list[tuple[int, SE2, np.ndarray]]] = defaultdict(list)

    def __enter__(self) -> Heard:
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, Twist
        from nav_msgs.msg import Odometry

        rclpy.init(domain_id=self._domain)
        self._node = node = rclpy.create_node("live_team")
        self._drives = {n: node.create_publisher(Twist, f"/{n}/cmd_vel", 5) for n in ROBOTS}
        for name in ROBOTS:
            on_truth = partial(self._on_truth, name)
            node.create_subscription(Odometry, f"/{name}/ground_truth/odom", on_truth, 100)
            for topic in ("landmark_pose", "team_pose"):
                on_pose = partial(self._on_pose, name, topic)
                node.create_subscription(
                    PoseWithCovarianceStamped, f"/{name}/{topic}", on_pose, 100
                )
        first = next(iter(ROBOTS))
        node.create_subscription(PoseArray, f"/{first}/bearings/robots", self._on_image, 100)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_state, 100)
        return self

    def __exit__(self, *_: object) -> None:
        import rclpy

        self._node.destroy_node()
        rclpy.try_shutdown()

    def spin(self) -> None:
        """Work for a tenth of a second."""
        import rclpy

        end = time.monotonic() + 0.1
        while time.monotonic() < end:
            rclpy.spin_once(self._node, timeout_sec=0.05)

    def drive(self) -> None:
        """Tell every robot to go round in its circle."""
        from geometry_msgs.msg import Twist

        for name, publisher in self._drives.items():
            command = Twist()
            command.linear.x, command.angular.z = SPEED, ROBOTS[name]
            publisher.publish(command)

    def errors(self, name: str, topic: str) -> dict[str, Any]:
        """Return how far the poses of one robot and source were off."""
        off, nees = [], []
        for stamp_ns, pose, cov in self._poses[name, topic]:
            truth = self._true_pose(name, stamp_ns)
            if truth is not None:
                off.append(difference(pose, truth))
                nees.append(off[-1] @ np.linalg.solve(cov, off[-1]))
        if not off:
            keys = ("mean_x_mm", "mean_y_mm", "mean_deg", "rms_m", "nees")
            return {"poses": 0} | dict.fromkeys(keys)
        x, y, yaw = np.mean(np.abs(off), axis=0).tolist()
        return {
            "poses": len(off), "mean_x_mm": 1e3 * x, "mean_y_mm": 1e3 * y,
            "mean_deg": math.degrees(yaw), "nees": float(np.mean(nees)),
            "rms_m": float(np.sqrt(np.mean(np.sum(np.square(off)[:, :2], axis=1)))),
        }  # fmt: skip

    def _true_pose(self, name: str, stamp_ns: int) -> SE2 | None:
        before, after = self._truth[name].around(stamp_ns)
        if before is None or after is None:
            return None
        span = after[0] - before[0]
        return before[1].interpolate(after[1], (stamp_ns - before[0]) / span if span else 0.0)

    def _on_truth(self, name: str, msg: Any) -> None:
        stamp_ns = stamp_to_ns(msg.header.stamp)
        self.time_s = stamp_ns / 1e9
        self._truth[name].add(stamp_ns, pose_to_se2(msg.pose.pose))

    def _on_pose(self, name: str, topic: str, msg: Any) -> None:
        estimate = pose_to_se2(msg.pose.pose), ros_cov_to_se2(msg.pose.covariance)
        self._poses[name, topic].append((stamp_to_ns(msg.header.stamp), *estimate))

    def _on_image(self, _msg: Any) -> None:
        self.num_images += 1

    def _on_state(self, msg: Any) -> None:
        own = f"/{next(iter(ROBOTS))}/team_localizer: "
        for status in msg.status:
            if status.name.startswith(own):
                values = ", ".join(f"{v.key} {v.value}" for v in status.values)
                self.last_states[status.name.removeprefix(own)] = status.message, values
