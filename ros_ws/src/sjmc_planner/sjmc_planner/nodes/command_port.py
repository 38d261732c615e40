"""`cmd_vel`: one sender, limited changes, and silence once the robot has nothing to do."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.duration import Duration

from floornav_common.ros.diagnostics import ERROR, OK, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher, publisher_names
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.limited_motion import ramped
from sjmc_planner.planning import STILL, Velocity
from sjmc_planner.ros_conversions import velocity_to_msg, velocity_to_stamped_msg

_LOOK_PERIOD_NS = 500_000_000
_NAMELESS_LOOKS = 4  # the graph hears of a publisher a moment before its name
_ACK_TIME = Duration(seconds=1)  # a publisher that is gone sends nothing again
_LAST_STOPS = 10  # zeros after the end, so that a lost one does no harm; then others may drive


class CommandPort:
    """Sends commands; part `cmd_vel` on diagnostics.

    Args:
        node: The node.
        config: Limits and the message's kind.

    Attributes:
        last: The command sent last.
    """

    def __init__(self, node: FloornavNode, config: LocalPlannerConfig) -> None:
        self.last = STILL
        self._node, self._config = node, config
        self._num_stops = _LAST_STOPS
        kind = TwistStamped if config.enable_stamped_cmd_vel else Twist
        self._publisher = create_publisher(node, kind, "cmd_vel", RELIABLE_QOS)
        self._others: list[str] = []
        self._num_nameless = 0
        self._looked_ns = node.time.steady_ns()
        node.time.on_look(self._look)
        node.diagnostics.add("cmd_vel", self.status)

    def set_config(self, config: LocalPlannerConfig) -> None:
        """Take other limits."""
        self._config = config

    def drive(self, wanted: Velocity) -> None:
        """Send the next command on the way to the one wanted."""
        self._num_stops = 0
        self._send(ramped(self.last, wanted, self._config.robot, self._config.control_period_s))

    def halt(self) -> None:
        """Send zero at once, and go on doing so."""
        self._num_stops = 0
        self._send(STILL)

    def rest(self) -> None:
        """Send zero a few times more, then nothing."""
        if self._num_stops < _LAST_STOPS:
            self._num_stops += 1
            self._send(STILL)

    def end(self) -> None:
        """Leave a zero as the last word, if the robot was driven; for when the node ends."""
        if self._num_stops < _LAST_STOPS and self._node.context.ok():
            self._send(STILL)
            self._publisher.wait_for_all_acked(_ACK_TIME)

    def status(self) -> Status:
        """Return OK, or ERROR that names who else sends."""
        if not self._others:
            return Status(OK, "no other publisher")
        return Status(ERROR, f"{self._publisher.topic_name}: {self._text()}")

    def _text(self) -> str:
        return f"also published by {', '.join(self._others)}: the robot obeys both"

    def _send(self, velocity: Velocity) -> None:
        self.last = velocity
        if not self._config.enable_stamped_cmd_vel:
            self._publisher.publish(velocity_to_msg(velocity))
            return
        stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(velocity_to_stamped_msg(velocity, stamp, self._node.frames.base))

    def _look(self) -> None:
        steady_ns = self._node.time.steady_ns()
        if steady_ns - self._looked_ns < _LOOK_PERIOD_NS:
            return
        self._looked_ns = steady_ns
        topic, before = self._publisher.topic_name, self._others
        self._others = publisher_names(self._node, topic)
        is_nameless = not self._others and self._node.count_publishers(topic) > 1
        self._num_nameless = self._num_nameless + 1 if is_nameless else 0
        if self._num_nameless >= _NAMELESS_LOOKS:
            self._others = ["a node of this one's name or one that has not given its name"]
        if self._others and self._others != before:
            self._node.get_logger().error(f"{topic}: {self._text()}")
