"""What the planner knows beside the scan: glass of a map, and echoes of sonars close by."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import Range

from floornav_common.readings import RangeReading
from floornav_common.ros.messages import grid_from_msg, range_from_msg
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import LATCHED_QOS, SENSOR_QOS, copy_qos, create_subscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.known_obstacles import near_points, occupied_corners
from sjmc_planner.near_echoes import Heard, NearEchoes
from sjmc_planner.nodes.input_missing import InputMissing
from sjmc_planner.planning import Obstacles, Velocity

_SONAR_QOS = copy_qos(SENSOR_QOS)
_SONAR_QOS.depth = 100  # a ring of sonars on one topic sends in bursts
_MOST_WAITING = 200  # readings that wait for a decision


class KnownInputs:
    """The newest glass, and what was heard since the last decision.

    Args:
        node: The node.
        config: What to mind.
    """

    def __init__(self, node: FloornavNode, config: LocalPlannerConfig) -> None:
        self._node, self._config = node, config.known
        self._map_points, self._map_frame, self._bad_map = np.zeros((0, 2)), "", ""
        self._heard: list[tuple[RangeReading, str]] = []
        self._sonars: Watchdog | None = None  # from the first reading on
        self._topics = ""
        self.forget()
        if config.known.minds_map:
            glass = create_subscription(node, OccupancyGrid, "map/glass", self._on_map, LATCHED_QOS)
            self._map_topic = glass.topic_name
        for topic in config.known.sonar_topics if config.known.echo_m > 0.0 else ():
            heard = create_subscription(node, Range, topic, self._on_range, _SONAR_QOS)
            self._topics = f"{self._topics}, {heard.topic_name}".lstrip(", ")

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take other limits."""
        self._config = config.known
        self.forget()
        if self._sonars is not None:
            self._sonars.set_timeout(self._config.sonar_timeout_s)

    def forget(self) -> None:
        """Forget what was heard: the robot may be elsewhere."""
        self._echoes = NearEchoes(self._config)
        self._heard = []

    def beside(
        self, seen: Obstacles, moved: SE2, dt: float, pose_in: Any, velocity: Velocity
    ) -> np.ndarray:
        """Return what is known beside a scan, in the base frame, shape (K, 2), m.

        Args:
            seen: The scan.
            moved: The robot's motion since the last decision.
            dt: Time since then, s.
            pose_in: Gives the robot's pose in a frame, at a velocity.
            velocity: Of the robot.

        Raises:
            InputMissing: If there is glass and the robot does not know where it is on the map,
                or sonars that were heard are silent.
        """
        if self._bad_map:
            raise InputMissing(f"{self._map_topic}: {self._bad_map}")
        near = self._map_points
        if len(near):
            near = near_points(near, pose_in(self._map_frame, velocity), self._config.reach_m)
        heard = self._new_echoes()
        return np.concatenate((near, self._echoes.update(heard, seen, moved, dt)))

    def _new_echoes(self) -> list[Heard]:
        """Return the readings since the last decision, each with where its sonar looks."""
        if self._sonars is not None and not self._sonars.is_fresh:
            raise InputMissing(f"{self._sonars.topic}: {self._sonars.status().message}")
        buffer, base, heard = self._node.transforms.buffer, self._node.frames.base, []
        waiting, self._heard = self._heard, []
        for reading, frame in waiting:
            try:
                heard.append((reading, buffer.lookup(base, frame).to_se2()))
            except (TransformUnavailable, ValueError) as error:
                raise InputMissing(f"{self._topics}: {error}") from error
        return heard

    def _on_map(self, msg: Any) -> None:
        try:
            grid = grid_from_msg(msg)
            self._map_points = occupied_corners(grid, self._config.occupied_from)
            self._map_frame, self._bad_map = msg.header.frame_id, ""
        except ValueError as error:
            self._bad_map = str(error)

    def _on_range(self, msg: Any) -> None:
        if msg.radiation_type == Range.INFRARED:  # sees through glass
            return
        if math.isnan(msg.range):  # REP 117: no measurement, which is as silence
            return
        if self._sonars is None:
            self._sonars = Watchdog(self._node, self._topics, self._config.sonar_timeout_s)
        self._sonars.feed()
        self._heard = [*self._heard[-_MOST_WAITING:], (range_from_msg(msg), msg.header.frame_id)]
