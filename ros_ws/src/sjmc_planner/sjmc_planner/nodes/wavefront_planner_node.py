"""Gives the way over a map to a goal, and gives it anew when the map changes.

In: `map` (OccupancyGrid), `goal_pose` (PoseStamped), TF map->base_link.
Out: `path` (Path, latched, in the map's frame; an empty one cancels).
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Path

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import grid_from_msg, pose_to_se2
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import (
    LATCHED_QOS,
    RELIABLE_QOS,
    create_publisher,
    create_subscription,
)
from floornav_common.se2 import SE2
from floornav_common.transform_errors import TransformUnavailable
from sjmc_planner.nodes.input_missing import InputMissing, fixed_frame
from sjmc_planner.nodes.way_report import WayReport
from sjmc_planner.ros_conversions import path_to_msg
from sjmc_planner.route_keeper import Route, RouteKeeper
from sjmc_planner.warm_up import compile_wavefront
from sjmc_planner.wavefront_config import WavefrontConfig

_PERIOD_S = 0.5


class WavefrontPlannerNode(FloornavNode):
    """Feeds maps, goals and the pose to a RouteKeeper."""

    def __init__(self) -> None:
        """Declare, subscribe, compile, and say ready."""
        super().__init__("wavefront_planner")
        self._config = declare_config(self, WavefrontConfig, on_change=self._set_config)
        self._keeper = RouteKeeper(self._config)
        self._map_frame = ""
        self._goal: PoseStamped | None = None  # until it is known in the map's frame
        self._base = self.frames.base
        self._report = WayReport(self)
        self._path_pub = create_publisher(self, Path, "path", LATCHED_QOS)
        self.transforms  # noqa: B018, listens from now on
        create_subscription(self, OccupancyGrid, "map", self._on_map, LATCHED_QOS)
        create_subscription(self, PoseStamped, "goal_pose", self._on_goal, RELIABLE_QOS)
        self.create_timer(_PERIOD_S, self._look)
        self.ready(compile_wavefront)

    def _set_config(self, config: WavefrontConfig) -> None:
        self._config = config
        self._keeper.set_config(config)

    def _on_map(self, msg: Any) -> None:
        """Take a map; a way over it is looked for at once."""
        try:
            grid = grid_from_msg(msg)
        except ValueError as error:
            self.get_logger().error(f"map refused: {error}", throttle_duration_sec=5.0)
            return
        self._map_frame = msg.header.frame_id
        self._keeper.set_grid(grid)
        self._look()

    def _on_goal(self, msg: Any) -> None:
        """Take a goal; the old way does not count any more."""
        self._keeper.set_goal(None)
        self._goal = msg
        self._report.take_goal(msg)
        self._look()

    def _look(self) -> None:
        """Make a way, or say what is missing for one."""
        if self._goal is None and not self._keeper.has_goal:
            self._report.rest(self._map_frame)
            return
        try:
            if self._goal is not None:
                self._place_goal(self._goal)
            here = self._pose()
        except InputMissing as error:
            self._say(self._keeper.refuse(str(error)))
            return
        except (TransformUnavailable, ValueError) as error:
            self._say(self._keeper.wait(str(error)))
            return
        self._say(self._keeper.update(here))

    def _place_goal(self, goal: PoseStamped) -> None:
        """Give the goal to the keeper in the map's frame.

        Raises:
            TransformUnavailable: If its frame is not known yet.
            ValueError: If there is no map yet, or the goal is no pose.
            InputMissing: If its frame is the robot's own.
        """
        frame = goal.header.frame_id
        if not self._map_frame:
            raise ValueError(f"no map on {self.resolve_topic_name('map')} yet")
        T_map_goal = pose_to_se2(goal.pose)
        if frame != self._map_frame:
            T_map_goal = self._lookup(frame) @ T_map_goal
            if not self.transforms.buffer.newest_common_stamp(frame, self._base):
                raise InputMissing(fixed_frame(frame))
        self._goal = None
        self._keeper.set_goal(np.array([T_map_goal.x, T_map_goal.y]))

    def _pose(self) -> np.ndarray:
        """Return where the robot is on the map.

        Raises:
            TransformUnavailable: If it is not known.
            ValueError: If it is known from too long ago, or from as far ahead.
        """
        pose = self._lookup(self._base)
        stamp_ns = self.transforms.buffer.newest_common_stamp(self._map_frame, self._base)
        age = (self.get_clock().now().nanoseconds - stamp_ns) * 1e-9
        if stamp_ns and age > self._config.pose_timeout_s:
            raise ValueError(f"pose: '{self._map_frame}' to '{self._base}' is {age:.1f} s old")
        if stamp_ns and age < -self._config.pose_timeout_s:
            raise ValueError(f"pose: stamped {-age:.1f} s in the future: two clocks?")
        return np.array([pose.x, pose.y])

    def _lookup(self, frame: str) -> SE2:
        return self.transforms.buffer.lookup(self._map_frame, frame).to_se2()

    def _say(self, route: Route) -> None:
        self._report.say(route, self._map_frame, has_goal=self._keeper.has_goal)
        if route.points is not None:
            stamp = self.get_clock().now().to_msg()
            self._path_pub.publish(path_to_msg(route.points, self._map_frame, stamp))


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(WavefrontPlannerNode, args)


if __name__ == "__main__":
    sys.exit(main())
