"""What a demo with goals hears, and how it sends them: one node beside the processes it started."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseStamped, PoseWithCovarianceStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, LaserScan, Range
from std_msgs.msg import Bool
from stereo_msgs.msg import DisparityImage
from visualization_msgs.msg import MarkerArray

from _day_goals import GoalSender
from _day_heard import DayHeard, Shot
from _day_latency import Latencies, StampClock
from experiments.goal_record import GoalRecord
from floornav_common.grid import OccupancyMap
from floornav_common.ros.messages import (
    grid_from_msg,
    image_to_array,
    pose_to_se2,
    poses_from_msg,
    se2_to_pose,
    stamp_to_ns,
)
from floornav_common.ros.qos import CLOCK_QOS, LATCHED_QOS, RELIABLE_QOS
from floornav_common.se2 import SE2
from multi_localizer.ros_conversions import disparities_from_msg
from sim_bridge.robot_model import RobotModel

_SHOT_NS = 8_000_000_000
_PEOPLE_NS = 200_000_000


class DayWatch(Node):
    """Hears the graph and sends the goals.

    Args:
        model: The robot.
        goals: In the map's frame, (N, 2), m.
        goal_limit_s: A goal not reached in this time is left for the next.

    Attributes:
        heard: What came.
        latencies: Counts and delays of it.
        clock: Real time of simulated instants.
    """

    def __init__(self, model: RobotModel, goals: np.ndarray, goal_limit_s: float) -> None:
        super().__init__("demo_watch")
        self.heard = DayHeard(GoalRecord(num_goals=len(goals)))
        self.clock = StampClock()
        self.latencies = Latencies(self.clock)
        self._shot_ns: dict[str, int] = {}
        self._people_ns = -_PEOPLE_NS
        self._deep = RELIABLE_QOS.__class__(depth=200, reliability=RELIABLE_QOS.reliability)
        self._goal_pub = self.create_publisher(PoseStamped, "goal_pose", RELIABLE_QOS)
        self.goals = GoalSender(goals, goal_limit_s, self._send_goal, self.heard.record)
        self._listen(model)

    @property
    def is_done(self) -> bool:
        """Whether the last goal is reached or left."""
        return self.goals.is_done

    def _listen(self, model: RobotModel) -> None:
        self.create_subscription(Clock, "/clock", self._on_clock, CLOCK_QOS)
        self._hear(Odometry, "ground_truth/odom", self._on_truth, is_hop=False)
        self._hear(PoseArray, "ground_truth/people", self._on_people, is_hop=False)
        self._hear(Bool, "ground_truth/contact", self._on_touch, LATCHED_QOS, is_hop=False)
        self._hear(Odometry, "odom", self._on_odometry)
        self._hear(LaserScan, "scan")
        self._hear(PoseWithCovarianceStamped, "pose", partial(self._on_pose, "grid_mapper"))
        self._hear(OccupancyGrid, "map", partial(self._on_map, "grid"), LATCHED_QOS)
        self._hear(OccupancyGrid, "map/glass", partial(self._on_map, "glass"), LATCHED_QOS)
        self._hear(Path, "path", self._on_path, LATCHED_QOS)
        self._hear(Twist, "cmd_vel")
        self._hear(DiagnosticStatus, "planner/state", self._on_state)
        self._hear(MarkerArray, "planner/markers")
        if model.config.sonar is not None:
            self._hear(Range, "sonar")
        if model.config.omni is not None:
            self._hear(LaserScan, "floor/free_space")
            self._hear(Image, "floor/overlay", partial(self._on_image, "floor/overlay"))
            self._hear(PoseArray, "bearings/robots")
        for pair in () if model.config.stereo is None else model.config.stereo.pairs:
            left = f"stereo/{pair}/left/image_rect"
            self._hear(Image, left, partial(self._on_image, left))
            topic = f"stereo/{pair}/disparity"
            self._hear(DisparityImage, topic, partial(self._on_disparity, topic))
        if model.config.stereo is not None:
            found = partial(self._on_pose, "stereo_localizer")
            self._hear(PoseWithCovarianceStamped, "stereo_pose", found)
            self._hear(PoseArray, "stereo_pose/candidates")

    def _hear(
        self, kind: type, topic: str, what: Any = None, qos: Any = None, *, is_hop: bool = True
    ) -> None:
        def take(msg: Any) -> None:
            wall = time.monotonic()
            if is_hop:
                header = getattr(msg, "header", None)
                stamp = None if header is None else stamp_to_ns(header.stamp)
                self.latencies.note(topic, stamp, wall)
            if what is not None:
                what(msg)

        self.create_subscription(kind, topic, take, self._deep if qos is None else qos)

    def _on_clock(self, msg: Any) -> None:
        self.clock.tick(stamp_to_ns(msg.clock), time.monotonic())
        self.goals.look(self.clock.newest_ns)

    def _on_truth(self, msg: Any) -> None:
        self.heard.record.truth.append((stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)))

    def _on_people(self, msg: Any) -> None:
        stamp_ns = stamp_to_ns(msg.header.stamp)
        if stamp_ns - self._people_ns >= _PEOPLE_NS:
            self._people_ns = stamp_ns
            places = [(pose.x, pose.y) for pose in poses_from_msg(msg)]
            self.heard.record.people.append((stamp_ns, np.array(places).reshape(-1, 2)))

    def _on_touch(self, msg: Any) -> None:
        self.heard.record.note_touch(self.clock.newest_ns, bool(msg.data))

    def _on_odometry(self, msg: Any) -> None:
        self.heard.odometry.append((stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)))

    def _on_pose(self, name: str, msg: Any) -> None:
        track = self.heard.poses.setdefault(name, [])
        track.append((stamp_to_ns(msg.header.stamp), pose_to_se2(msg.pose.pose)))

    def _on_map(self, layer: str, msg: Any) -> None:
        grid = grid_from_msg(msg)
        kept = OccupancyMap(grid.cells.copy(), grid.resolution, grid.origin)
        setattr(self.heard, layer, kept)
        if layer == "grid":
            self.heard.maps.append((stamp_to_ns(msg.header.stamp), kept, self.heard.glass))

    def _on_path(self, msg: Any) -> None:
        if msg.poses:
            self.goals.has_way()

    def _on_state(self, msg: Any) -> None:
        said = {value.key: value.value for value in msg.values}
        state, reason = said.get("state", ""), said.get("reason", "")
        self.heard.record.note_state(self.clock.newest_ns, state, reason)
        self.goals.take_state(state, reason, self.clock.newest_ns)

    def _on_image(self, topic: str, msg: Any) -> None:
        if self._is_shot_due(topic, stamp_to_ns(msg.header.stamp)):
            self._keep(topic, msg, image_to_array(msg, "rgb8").copy())

    def _on_disparity(self, topic: str, msg: Any) -> None:
        if self._is_shot_due(topic, stamp_to_ns(msg.header.stamp)):
            found = np.nan_to_num(disparities_from_msg(msg))
            shade = np.clip(255.0 * found / max(float(msg.max_disparity), 1.0), 0.0, 255.0)
            self._keep(topic, msg, np.repeat(shade.astype(np.uint8)[..., None], 3, axis=2))

    def _is_shot_due(self, topic: str, stamp_ns: int) -> bool:
        return stamp_ns - self._shot_ns.get(topic, -_SHOT_NS) >= _SHOT_NS

    def _keep(self, topic: str, msg: Any, image: np.ndarray) -> None:
        stamp_ns = stamp_to_ns(msg.header.stamp)
        self._shot_ns[topic] = stamp_ns
        self.heard.shots.append(Shot(topic, stamp_ns * 1e-9, image))

    def _send_goal(self, place: np.ndarray) -> None:
        goal = PoseStamped(pose=se2_to_pose(SE2(float(place[0]), float(place[1]), 0.0)))
        goal.header.frame_id = "map"
        self._goal_pub.publish(goal)
