"""Shows the robot in a browser on this machine, and takes goals by click.

In: `map`, `map/glass` (OccupancyGrid), `scan` (LaserScan), `sonar` (Range; `sonar_topics`), `path`,
`trajectory` (Path), `goal_pose` (PoseStamped), `planner/state` (DiagnosticStatus),
`planner/markers` (MarkerArray: zones, people, ways weighed), `floor/overlay` (Image;
`image_topic`), `/diagnostics`, TF map->base_link->sensors. Only while somebody looks.
Out: `goal_pose` (PoseStamped in `map_frame`), when somebody clicks one.
Serves http://127.0.0.1:8765/ (`port`), on loopback only.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from geometry_msgs.msg import PoseStamped

from floornav_common.live_view.config import LiveViewConfig
from floornav_common.live_view.encoding import text_message
from floornav_common.nodes.live_health import LiveHealth
from floornav_common.nodes.live_topics import LiveTopics
from floornav_common.ros.diagnostics import OK, Status
from floornav_common.ros.main import run_node
from floornav_common.ros.messages import se2_to_pose
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher

if TYPE_CHECKING:
    from floornav_common.live_view.server import GoalAsked, LiveViewServer

_LINGER_NS = 5_000_000_000  # a page that is loaded again finds everything as it was


class LiveViewNode(FloornavNode):
    """Feeds what the topics say to a server, and its goals to `goal_pose`."""

    def __init__(self) -> None:
        """Declare, subscribe, serve, and say ready."""
        super().__init__("live_view")
        self._config = declare_config(self, LiveViewConfig, on_change=self._set_config)
        self._goal_pub = create_publisher(self, PoseStamped, "goal_pose", RELIABLE_QOS)
        self.frames, self.transforms  # noqa: B018, declares, and listens from now on
        self._topics = LiveTopics(self, self._config)
        self._health = LiveHealth(self, self._topics, self._config.silent_after_s)
        self._server = self._serve()
        self._kept: dict[str, str | bytes] = {}  # for who comes next
        self._num_served = 0
        self._is_open, self._looked_ns = True, self.time.steady_ns()
        self.diagnostics.add("browsers", self._status)
        self.create_timer(1.0 / self._config.rate_hz, self._tick, clock=self.time.steady_clock)
        self.ready()
        self.get_logger().info(f"open {self._server.url} in a browser on this machine")

    def _serve(self) -> LiveViewServer:
        name = self.get_fully_qualified_name()
        try:
            from floornav_common.live_view.server import LiveViewServer

            return LiveViewServer(self._config.port)
        except ImportError as error:
            raise ParameterError(
                f"{name}: the package websockets, 13 or newer, is not installed "
                f"(requirements-robot.txt): {error}"
            ) from error
        except OSError as error:
            raise ParameterError(
                f"{name}: port {self._config.port} cannot be had "
                f"({error.strerror}): give another with -p port:=..., or 0 for any"
            ) from error

    def _set_config(self, config: LiveViewConfig) -> None:
        self._config = config
        self._topics.set_config(config)
        self._health.silent_after_s = config.silent_after_s
        self._num_served = 0  # the outline may be another

    def _tick(self) -> None:
        """Send what is new; to a browser that has just come, all that is known."""
        for asked in self._server.take_goals():
            self._send_goal(asked)
        if not self._is_looked_at():
            return
        news = {**self._topics.news(), **self._health.news()}
        self._kept.update(news)
        if self._num_served != self._server.num_ever:
            self._num_served = self._server.num_ever
            news = {"info": self._info(), **self._kept}
        self._server.send(news)

    def _is_looked_at(self) -> bool:
        """Tell whether somebody looks; listen only while it is so."""
        now_ns = self.time.steady_ns()
        is_seen = self._server.num_browsers > 0
        if is_seen:
            self._looked_ns = now_ns
        if is_seen and not self._is_open:
            self._is_open = True
            self._topics.open()
            self._health.open()
        elif self._is_open and now_ns - self._looked_ns > _LINGER_NS:
            self._is_open = False
            self._topics.close()
            self._health.close()
            self._kept.clear()
        return is_seen

    def _send_goal(self, asked: GoalAsked) -> None:
        msg = PoseStamped(pose=se2_to_pose(asked.pose))
        msg.header.stamp, msg.header.frame_id = self.get_clock().now().to_msg(), self.frames.map
        self._goal_pub.publish(msg)
        name, pose = self._goal_pub.topic_name, asked.pose
        # This node hears its own goals.
        is_heard = self._goal_pub.get_subscription_count() > 1
        text = f"goal ({pose.x:.2f}, {pose.y:.2f}) sent on {name}"
        if not is_heard:
            text += ", but no planner listens to it"
        self.get_logger().info(text)
        self._server.answer(asked.browser, text_message("answer", ok=is_heard, text=text))

    def _info(self) -> str:
        return text_message(
            "info", robot=self.get_namespace(), map_frame=self.frames.map,
            outline=self._config.outline().round(4).tolist(),
            goal_topic=self._goal_pub.topic_name, silent_after_s=self._config.silent_after_s,
            image_topic=self._config.image_topic,
        )  # fmt: skip

    def _status(self) -> Status:
        num = self._server.num_browsers
        who = f"{num} look" if num else "nobody looks"
        return Status(OK, f"{who} at {self._server.url}", self._server.counts)

    def destroy_node(self) -> None:
        """Close the page with the node."""
        self._server.close()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(LiveViewNode, args)


if __name__ == "__main__":
    sys.exit(main())
