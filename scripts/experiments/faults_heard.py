"""What `evaluate.py faults` hears of the graph, and how it sends its goals: round and round."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from stereo_msgs.msg import DisparityImage

from experiments.faults_judge import DriveRecord, Moved
from experiments.faults_relay import FaultRelay
from floornav_common.ros.messages import pose_to_se2, se2_to_pose, stamp_to_ns
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS
from floornav_common.se2 import SE2
from sjmc_planner.goal_progress import GoalProgress

_AGAIN_NS = 3_000_000_000
_DEEP = QoSProfile(depth=200)
_KEPT_POSES = 3000


class FaultWatch(Node):
    """Hears the graph, and goes through the goals for ever.

    Args:
        relay: Has the simulator's time.
        goals: In `frame`, shape (N, 2), m.
        frame: Of the goals.
        has_paths: Whether a path answers a goal; else the planner takes goals itself.

    Attributes:
        record: For the judge.
        truth: (stamp, pose in the world, speed), newest last.
        poses: (stamp, pose) of the localizer, newest last.
        state: What the planner said last, and why.
        said: Newest (level, text) by name of the diagnostics' part.
        counts: Messages by topic.
        known_cells: Of the newest map.
        free_space: The newest.
        num_goals_again: How often a goal had to be sent once more.
        goal_limit_s: A goal not reached in this time is left for the next.
        num_left: How many were left.
        num_clock_stops: How often the planner said that `/clock` stands still.
    """

    def __init__(
        self, relay: FaultRelay, goals: np.ndarray, frame: str, *, has_paths: bool
    ) -> None:
        super().__init__("fault_watch")
        self._relay, self._goals, self._frame = relay, goals, frame
        self._has_paths = has_paths
        self.record = DriveRecord()
        self.truth: list[tuple[int, SE2, float]] = []
        self.poses: list[tuple[int, SE2]] = []
        self.state = ("", "")
        self.said: dict[str, tuple[int, str]] = {}
        self.counts: dict[str, int] = {}
        self.known_cells = self.num_goals_again = self.number = 0
        self.free_space: Any = None
        self.goal_limit_s, self.num_left, self.num_clock_stops = math.inf, 0, 0
        self.sends_goals = True
        self._progress, self._has_way = GoalProgress(), False
        self._sent_ns, self._since_ns = -_AGAIN_NS, 0
        self._goal_pub = self.create_publisher(PoseStamped, "goal_pose", RELIABLE_QOS)
        for kind, topic, take, qos in (
            (Odometry, "ground_truth/odom", self._on_truth, _DEEP),
            (Bool, "ground_truth/contact", self._on_touch, LATCHED_QOS),
            (PoseWithCovarianceStamped, "pose", self._on_pose, _DEEP),
            (DiagnosticStatus, "planner/state", self._on_state, _DEEP),
            (DiagnosticArray, "/diagnostics", self._on_diagnostics, _DEEP),
            (OccupancyGrid, "map", self._on_map, LATCHED_QOS),
            (Path, "path", self._on_path, LATCHED_QOS),
            (LaserScan, "floor/free_space", self._on_free_space, _DEEP),
        ):
            self._hear(kind, topic, take, qos)

    @property
    def speed(self) -> float:
        """True speed, m/s."""
        return self.truth[-1][2] if self.truth else 0.0

    @property
    def goal(self) -> np.ndarray:
        """The goal in force, in the goals' frame, shape (2,), m."""
        return self._goals[self.number % len(self._goals)]

    def on_command(self, now_ns: int, msg: Any) -> None:
        """Take a command that went on to the simulator."""
        speed = math.hypot(msg.linear.x, msg.linear.y)
        self.record.commands.append(Moved(now_ns, speed, msg.angular.z))

    def look(self) -> None:
        """Send the goal if it is time; to be called often."""
        now_ns = self._relay.now_ns
        is_idle = not self._has_way or self._progress.is_idle
        if now_ns - self._since_ns > self.goal_limit_s * 1e9:
            self.num_left += 1
            self._next()
        if self.sends_goals and is_idle and now_ns - self._sent_ns >= _AGAIN_NS:
            self.num_goals_again += self._sent_ns > 0
            self.send_goal()

    def send_goal(self) -> None:
        """Send the goal in force."""
        self._sent_ns, self._has_way = self._relay.now_ns, not self._has_paths
        self._progress = GoalProgress()
        msg = PoseStamped(pose=se2_to_pose(SE2(*self.goal.tolist(), 0.0)))
        msg.header.frame_id = self._frame
        self._goal_pub.publish(msg)

    def pose_error(self, T_world_frame: SE2) -> float | None:
        """Return how far the newest pose is off, m; None without one of the last second."""
        for stamp_ns, pose in reversed(self.poses):
            if self._relay.now_ns - stamp_ns > 1_000_000_000:
                return None
            true = next((p for at_ns, p, _ in reversed(self.truth) if at_ns <= stamp_ns), None)
            if true is not None:
                found = T_world_frame @ pose
                return math.hypot(found.x - true.x, found.y - true.y)
        return None

    def count_disparities(self) -> None:
        """Count the stereo matcher's answers from now on."""
        if "disparity" in self.counts:
            return
        for pair in ("front", "rear"):
            self._hear(DisparityImage, f"stereo/{pair}/disparity", self._on_disparity, _DEEP)

    def _hear(self, kind: type, topic: str, take: Any, qos: Any) -> None:
        def on_message(msg: Any) -> None:
            self.counts[topic] = self.counts.get(topic, 0) + 1
            take(msg)

        self.create_subscription(kind, topic, on_message, qos)

    def _on_truth(self, msg: Any) -> None:
        twist, stamp_ns = msg.twist.twist, self._relay.base_ns + stamp_to_ns(msg.header.stamp)
        speed = math.hypot(twist.linear.x, twist.linear.y)
        self.truth.append((stamp_ns, pose_to_se2(msg.pose.pose), speed))
        self.record.motion.append(Moved(stamp_ns, speed, twist.angular.z))

    def _on_touch(self, msg: Any) -> None:
        if msg.data:
            self.record.touches.append(self._relay.now_ns)

    def _on_pose(self, msg: Any) -> None:
        stamp_ns = self._relay.base_ns - self._relay.shift_ns + stamp_to_ns(msg.header.stamp)
        self.poses.append((stamp_ns, pose_to_se2(msg.pose.pose)))
        del self.poses[:-_KEPT_POSES]

    def _on_state(self, msg: Any) -> None:
        said = {value.key: value.value for value in msg.values}
        self.state = said.get("state", ""), said.get("reason", "")
        self.num_clock_stops += "/clock" in self.state[1]
        self._progress.update(*self.state)
        if self._has_way and self._progress.is_reached:
            self._next()

    def _next(self) -> None:
        self.number += 1
        self._sent_ns, self._since_ns, self._has_way = -_AGAIN_NS, self._relay.now_ns, False

    def _on_diagnostics(self, msg: Any) -> None:
        for status in msg.status:
            self.said[status.name] = (status.level[0], status.message)

    def _on_map(self, msg: Any) -> None:
        self.known_cells = int(np.count_nonzero(np.asarray(msg.data, np.int8) >= 0))

    def _on_path(self, msg: Any) -> None:
        self._has_way |= bool(msg.poses)

    def _on_disparity(self, _msg: Any) -> None:
        self.counts["disparity"] = self.counts.get("disparity", 0) + 1

    def _on_free_space(self, msg: Any) -> None:
        self.free_space = msg
