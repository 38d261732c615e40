"""What the planner of ways says of itself: part `path` on /diagnostics, and the log."""

from __future__ import annotations

from typing import Any

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import publisher_names
from sjmc_planner.goal_progress import goal_name
from sjmc_planner.route_keeper import NO_WAY, WAITING, Route

_LEVELS = {WAITING: STALE, NO_WAY: ERROR}


class WayReport:
    """Says how it stands with the goal, and which goal that is.

    Args:
        node: The node.
    """

    def __init__(self, node: FloornavNode) -> None:
        self._node = node
        self._goal = self._end = self._found = ""

    def take_goal(self, msg: Any) -> None:
        """Take the goal that the next words are about."""
        place = msg.pose.position
        self._goal, self._end = goal_name(msg.header.frame_id, place.x, place.y), ""

    def rest(self, map_frame: str) -> None:
        """Say that there is no goal; or no map, and who would send it."""
        if map_frame:
            self._set(OK, "idle: no goal")
            return
        topic = self._node.resolve_topic_name("map")
        senders = ", ".join(publisher_names(self._node, topic)) or "nobody"
        text = f"waiting for a map: {topic}: never arrived; published by {senders}"
        self._set(STALE, text)
        self._node.get_logger().info(text, once=True)

    def say(self, route: Route, map_frame: str, *, has_goal: bool) -> None:
        """Say how it stands; that a way was found once, however often the goal is sent."""
        level = _LEVELS.get(route.state, OK)
        if route.state == WAITING and has_goal:
            level = WARN
        if route.points is not None:
            self._end = goal_name(map_frame, *route.points[-1]) if len(route.points) else ""
        self._set(level, f"{route.state}: {route.text}")
        if level != OK:
            text = f"{route.state}: {route.text}"
            self._node.get_logger().warning(text, throttle_duration_sec=5.0)
        elif self._end and self._found != self._goal and route.points is not None:
            self._found = self._goal
            left = route.text.removesuffix(" left")
            self._node.get_logger().info(f"way of {left} to {self._end} found")
        if level != OK:
            self._found = ""

    def _set(self, level: bytes, text: str) -> None:
        values = {"goal": self._goal, "path ends at": self._end}
        self._node.diagnostics.set("path", Status(level, text, values))
