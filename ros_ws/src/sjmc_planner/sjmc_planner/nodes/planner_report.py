"""What the planner says of itself: `planner/state`, `planner/markers`."""

from __future__ import annotations

import re

from diagnostic_msgs.msg import DiagnosticStatus
from visualization_msgs.msg import MarkerArray

from floornav_common.ros.diagnostics import ERROR, OK, WARN, Status
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from sjmc_planner.planning import BACKING, BLOCKED, BRAKING, WAITING, Debug
from sjmc_planner.ros_conversions import debug_to_msg, state_to_msg

STOPPED = "stopped"
_STATE_PERIOD_NS, _MARKER_PERIOD_NS = 500_000_000, 200_000_000
_LOG_PERIOD_NS = 2_000_000_000
_LEVELS = {STOPPED: ERROR, BLOCKED: WARN, BRAKING: WARN, WAITING: WARN, BACKING: WARN}
_FIGURES = re.compile(r"[-\d.]+")  # a reason is no other one for its figures


class PlannerReport:
    """Publishes the state on change and twice a second; part `planning` on diagnostics.

    Args:
        node: The node.
    """

    def __init__(self, node: FloornavNode) -> None:
        self._node = node
        self._state, self._reason, self._left_m = "starting", "", None
        self._waiting_since_ns: int | None = None
        self._goal, self._logged = "", self._state
        self._said_ns = self._drew_ns = 0
        self._logged_ns: int | None = None
        self._state_pub = create_publisher(node, DiagnosticStatus, "planner/state", RELIABLE_QOS)
        self._marker_pub = create_publisher(node, MarkerArray, "planner/markers", RELIABLE_QOS)
        node.time.on_restart(self._forget_waiting)
        node.time.on_look(self._look)
        node.diagnostics.add("planning", self.status)

    def set(self, state: str, reason: str, left_m: float | None = None, goal: str = "") -> None:
        """Take the state of now, and the goal's name."""
        if _LEVELS.get(state) is None:
            self._forget_waiting()
        elif self._waiting_since_ns is None:
            self._waiting_since_ns = self._node.time.read_ns()
        is_new = state != self._state or _words(reason) != _words(self._reason)
        is_new |= goal != self._goal
        self._state, self._reason, self._left_m, self._goal = state, reason, left_m, goal
        if is_new:
            self._say()
            self._log()

    @property
    def wants_markers(self) -> bool:
        """Whether somebody looks at the markers, and it is time for new ones."""
        is_time = self._node.time.steady_ns() - self._drew_ns >= _MARKER_PERIOD_NS
        return is_time and self._marker_pub.get_subscription_count() > 0

    def draw(self, debug: Debug) -> None:
        """Publish what the method saw, with the state that was set last."""
        self._drew_ns = self._node.time.steady_ns()
        stamp = self._node.get_clock().now().to_msg()
        self._marker_pub.publish(debug_to_msg(debug, self._line, stamp, self._node.frames.base))

    def status(self) -> Status:
        """Return how it goes."""
        return Status(_LEVELS.get(self._state, OK), self._line)

    @property
    def _waited_s(self) -> float:
        if self._waiting_since_ns is None:
            return 0.0
        return (self._node.time.read_ns() - self._waiting_since_ns) * 1e-9

    def _forget_waiting(self) -> None:
        self._waiting_since_ns = None

    def _look(self) -> None:
        if self._node.time.steady_ns() - self._said_ns >= _STATE_PERIOD_NS:
            self._say()
            self._log()

    def _log(self) -> None:
        """Write the state to the log if it is another one, a change in 2 s; a stop at once."""
        now_ns, line = self._node.time.steady_ns(), self._line
        is_soon = self._logged_ns is not None and now_ns - self._logged_ns < _LOG_PERIOD_NS
        if is_soon and (self._state != STOPPED or self._logged.startswith(STOPPED)):
            return
        if _words(line) == _words(self._logged):
            return
        self._logged, self._logged_ns = line, now_ns
        if self._state == STOPPED:
            self._node.get_logger().warning(line)
        else:
            self._node.get_logger().info(line)

    @property
    def _line(self) -> str:
        return f"{self._state}: {self._reason}" if self._reason else self._state

    def _say(self) -> None:
        self._said_ns = self._node.time.steady_ns()
        name = f"{self._node.get_fully_qualified_name()}: planning"
        level = _LEVELS.get(self._state, OK)
        said = (self._state, self._reason, self._waited_s, self._left_m, self._goal)
        self._state_pub.publish(state_to_msg(name, level, *said))


def _words(reason: str) -> str:
    return _FIGURES.sub("", reason.split(" is ")[0])
