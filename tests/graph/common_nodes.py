"""Small nodes on floornav_common for the graph tests: `common_nodes.py NAME [--ros-args]`."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field
from typing import Any

from listening import say_others_when_ready
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import LaserScan

from floornav_common.config import param, validate
from floornav_common.ros.main import run_nodes
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import declare_config
from floornav_common.ros.qos import RELIABLE_QOS, SENSOR_QOS, create_subscription
from floornav_common.ros.transform_owner import TransformOwner
from floornav_common.ros.transformed_subscription import TransformedSubscription
from floornav_common.ros.watchdog import Watchdog
from floornav_common.transform3 import Transform3


class ScanEcho(FloornavNode):
    """Says each scan whose transform it has."""

    def __init__(self) -> None:
        super().__init__("scan_echo")
        self._scans = TransformedSubscription(
            self, LaserScan, "scan", SENSOR_QOS, self.frames.odom, self._on_scan
        )
        self.ready()

    def _on_scan(self, scan: LaserScan, T_odom_laser: Transform3) -> None:
        x = T_odom_laser.to_se2().x
        print(f"scan {stamp_to_ns(scan.header.stamp)} at x {x:.3f}", flush=True)


class Picky(FloornavNode):
    """Wants reliable scans; watches them."""

    def __init__(self) -> None:
        super().__init__("picky")
        create_subscription(self, LaserScan, "scan", self._on_scan, RELIABLE_QOS)
        self._watchdog = Watchdog(self, "/scan", 0.5)
        self.ready()

    def _on_scan(self, _scan: LaserScan) -> None:
        self._watchdog.feed()
        print("scan", flush=True)


@dataclass(frozen=True, kw_only=True)
class FilterConfig:
    """A group of parameters."""

    window: int = param(5, "Window.", ge=1)

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class TunedConfig:
    """Parameters of every kind."""

    gain: float = param(0.5, "Gain.", gt=0.0, le=1.0)
    count: int = param(3, "Count.", ge=1, le=9)
    name: str = param("a", "Name.", choices=("a", "b"))
    topics: tuple[str, ...] = param(("sonar",), "Topics.")
    team: tuple[str, ...] = param((), "Team.")
    limits: tuple[float, float] = param((-1.0, 1.0), "Limits.", unit="m")
    size: int = param(10, "Size.", read_only=True)
    filter: FilterConfig = field(default_factory=FilterConfig)

    def __post_init__(self) -> None:
        validate(self)


class Tuned(FloornavNode):
    """Says its configuration after each change."""

    def __init__(self) -> None:
        super().__init__("tuned")
        print(declare_config(self, TunedConfig, on_change=self._on_change), flush=True)
        self.ready()

    def _on_change(self, config: TunedConfig) -> None:
        print("changed to", config, flush=True)


class Owner(FloornavNode):
    """Sends map -> odom while nobody else does."""

    def __init__(self) -> None:
        super().__init__("owner")
        self._owner = TransformOwner(self, "map", "odom")
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._was_sent: bool | None = None
        self.create_timer(0.05, self._on_timer, clock=self._steady)
        self.ready()

    def _on_timer(self) -> None:
        is_sent = self._owner.send(self.get_clock().now().nanoseconds, Transform3.identity())
        if is_sent != self._was_sent:
            self._was_sent = is_sent
            print("sending" if is_sent else "silent", flush=True)


class Building(FloornavNode):
    """Is never done with its construction."""

    def __init__(self) -> None:
        super().__init__("building")
        print("building", flush=True)
        time.sleep(600.0)


class Unusable(FloornavNode):
    """Finds while it warms up that it cannot work with what it was given."""

    def __init__(self) -> None:
        super().__init__("unusable")
        self.ready(self._warm_up)

    def _warm_up(self) -> None:
        raise ValueError("the camera must see floor")


class Broken(FloornavNode):
    """Fails in a callback."""

    def __init__(self) -> None:
        super().__init__("broken")
        self.time.on_look(self._fail)
        self.ready()

    def _fail(self) -> Any:
        raise RuntimeError("broken on purpose")


NODES = {
    "scan_echo": [ScanEcho], "picky": [Picky], "tuned": [Tuned], "owner": [Owner],
    "broken": [Broken], "building": [Building], "both": [ScanEcho, Picky],
    "tuned_and_picky": [Tuned, Picky], "unusable": [Unusable],
}  # fmt: skip

if __name__ == "__main__":
    say_others_when_ready()
    sys.exit(run_nodes(NODES[sys.argv[1]]))
