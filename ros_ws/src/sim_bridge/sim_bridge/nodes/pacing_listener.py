"""Lets simulated time wait: first for those who should listen, then for those who answer."""

from __future__ import annotations

from collections.abc import Callable

from floornav_common.ros.node import FloornavNode
from floornav_common.time_watch import Throttle
from sim_bridge.config import SimBridgeConfig
from sim_bridge.nodes.answers import Answers
from sim_bridge.pacing import Audience, Pace

_LOOK_PERIOD_S = 0.1
_SETTLE_S = 1.0
_WARN_PERIOD_NS = 5_000_000_000
_NOT_FOR_US = ("/rosout", "/parameter_events", "/diagnostics")


class PacingListener:
    """Feeds an `Audience` from the graph and a `Pace` from the answers that come.

    Args:
        node: The node.
        config: Topics, nodes and limits.
        stamp_ns: Where simulated time is read.
    """

    def __init__(
        self, node: FloornavNode, config: SimBridgeConfig, stamp_ns: Callable[[], int]
    ) -> None:
        """Wait for publishers."""
        self._node, self._stamp_ns = node, stamp_ns
        waited_for = (*config.pace_topics, *config.pace_nodes)
        listeners = {self._full_name(name) for name in config.start_nodes}
        known = [name for name in config.pace_nodes if self._full_name(name) in listeners]
        self._pace = Pace(waited_for, config.pace_lag_s, config.pace_timeout_s, known)
        self._answers = Answers(node, config, self._pace, stamp_ns) if waited_for else None
        self._audience = self._make_audience(config)
        self._warnings, self._has_said = Throttle(_WARN_PERIOD_NS), False
        self._next_look = 0.0

    @property
    def is_in_use(self) -> bool:
        """Tell whether answers are waited for."""
        return self._answers is not None

    @property
    def is_waiting_for_listeners(self) -> bool:
        """Tell whether time waits for those who should listen before it starts."""
        return self._audience is not None

    def may_go_on(self, now: float) -> bool:
        """Tell whether time may go on, at a steady time (s)."""
        if self._audience is not None and not self._is_audience_there(self._audience, now):
            return False
        stamp_ns = self._stamp_ns()
        for topic in self._pace.give_up(stamp_ns, now):
            self._node.get_logger().warning(f"{topic} does not answer: going on without it")
        return not self._pace.late(stamp_ns)

    def restart(self) -> None:
        """Forget all answers."""
        self._pace.restart()

    def _make_audience(self, config: SimBridgeConfig) -> Audience | None:
        names = [self._full_name(name) for name in config.start_nodes]
        return Audience(names, _SETTLE_S) if names else None

    def _full_name(self, name: str) -> str:
        return name if name.startswith("/") else f"{self._node.get_namespace().rstrip('/')}/{name}"

    def _is_audience_there(self, audience: Audience, now: float) -> bool:
        if now < self._next_look:
            return False
        self._next_look = now + _LOOK_PERIOD_S
        names, num_known, num_matched = set(), 0, 0
        for publisher in self._node.publishers:
            if publisher.topic_name not in _NOT_FOR_US:
                infos = self._node.get_subscriptions_info_by_topic(publisher.topic_name)
                names |= {f"{i.node_namespace.rstrip('/')}/{i.node_name}" for i in infos}
                num_known += len(infos)
                num_matched += publisher.get_subscription_count()
        if audience.is_there(now, names, num_known, num_matched):
            self._audience = None
            return True
        if audience.missing and self._warnings.is_due(round(now * 1e9)):
            self._say_missing(audience.missing)
        return False

    def _say_missing(self, names: list[str]) -> None:
        """Say who is waited for; the second time it may be a wrong name: say who is there."""
        text = f"time waits for {', '.join(names)} to listen"
        if not self._has_said:
            self._has_said = True
            self._node.get_logger().info(text)
            return
        there = self._node.get_node_names_and_namespaces()
        full = sorted({f"{space.rstrip('/')}/{name}" for name, space in there})
        self._node.get_logger().warning(f"{text} (start_nodes); nodes there are: {', '.join(full)}")
