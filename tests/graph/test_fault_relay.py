"""The relay of the faults, over DDS: what goes through, what is changed, and its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
import rclpy  # noqa: E402
from geometry_msgs.msg import Twist  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import LaserScan  # noqa: E402

from experiments.faults_changes import drop, edited, no_ranges  # noqa: E402
from experiments.faults_relay import FaultRelay, through_qos  # noqa: E402
from floornav_common.ros.messages import ns_to_stamp, stamp_to_ns  # noqa: E402

S = 1_000_000_000


class Both:
    """A relay, and what a simulator and a node beside it send and hear."""

    def __init__(self, peer: Any) -> None:
        from rclpy.executors import SingleThreadedExecutor

        self.peer = peer
        self.relay = FaultRelay({"/clock": Clock, "scan": LaserScan}, {"cmd_vel": Twist})
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.relay)
        self.scans = peer.collect(LaserScan, "scan", through_qos("scan"))
        self.clocks = peer.collect(Clock, "/clock", through_qos("/clock"))
        self.obeyed = peer.collect(Twist, "raw/cmd_vel", through_qos("cmd_vel"))
        self.raw = peer.node.create_publisher(LaserScan, "raw/scan", through_qos("scan"))
        self.tick = peer.node.create_publisher(Clock, "raw/clock", through_qos("/clock"))
        self.commands = peer.node.create_publisher(Twist, "cmd_vel", through_qos("cmd_vel"))
        pubs = (self.raw, self.tick, self.commands)
        self.until(lambda: all(p.get_subscription_count() for p in pubs))
        peer.wait_to_hear("scan", "/clock", "raw/cmd_vel")
        self.until(lambda: all(p.publisher.get_subscription_count() for p in self.all))

    @property
    def all(self) -> list[Any]:
        return list(self.relay.passed.values())

    def until(self, is_so: Callable[[], bool]) -> None:
        def look() -> bool:
            self._executor.spin_once(timeout_sec=0.0)
            return is_so()

        self.peer.spin_until(look)

    def time_is(self, stamp_ns: int) -> None:
        """Tell the time until it has come, which best effort does not promise."""
        before = self.relay.passed["/clock"].num
        while self.relay.passed["/clock"].num == before:
            self.tick.publish(Clock(clock=ns_to_stamp(stamp_ns)))
            for _ in range(20):
                self._executor.spin_once(timeout_sec=0.01)

    def scan(self, stamp_ns: int) -> None:
        before = self.relay.passed["scan"].num
        msg = LaserScan(ranges=[1.0, 2.0])
        msg.header.stamp = ns_to_stamp(stamp_ns)
        self.raw.publish(msg)
        self.until(lambda: self.relay.passed["scan"].num > before)

    def close(self) -> None:
        self._executor.shutdown()
        self.relay.destroy_node()


@pytest.fixture
def both(peer: Any, domain: int) -> Iterator[Both]:
    rclpy.init(domain_id=domain)
    made = Both(peer)
    yield made
    made.close()
    rclpy.try_shutdown()


def test_what_no_fault_concerns_goes_through_as_it_is(both: Both) -> None:
    both.scan(3 * S)
    both.until(lambda: bool(both.scans))
    assert list(both.scans[0].ranges) == [1.0, 2.0]
    assert stamp_to_ns(both.scans[0].header.stamp) == 3 * S


def test_a_change_begins_with_the_next_message_and_ends_when_it_is_taken_away(both: Both) -> None:
    both.time_is(5 * S)
    both.relay.set_change("scan", edited(no_ranges))
    both.scan(6 * S)
    assert both.relay.passed["scan"].changed_ns == 5 * S
    both.relay.set_change("scan", drop)
    both.scan(7 * S)
    both.relay.set_change("scan", None)
    both.scan(8 * S)
    both.until(lambda: len(both.scans) == 2)
    assert both.scans[0].ranges[0] != both.scans[0].ranges[0]
    assert [stamp_to_ns(m.header.stamp) for m in both.scans] == [6 * S, 8 * S]


def test_what_is_late_waits_for_the_simulators_time(both: Both) -> None:
    both.time_is(5 * S)
    both.relay.set_change("scan", lambda msg, _now: [(S, msg)])
    both.scan(5 * S)
    both.time_is(5 * S + S // 2)
    assert both.scans == []
    both.time_is(6 * S)
    both.until(lambda: len(both.scans) == 1)


def test_time_can_be_moved_for_the_nodes_and_stays_what_it_is_for_the_relay(both: Both) -> None:
    both.relay.shift_ns, both.relay.clock_shift_ns = 60 * S, 5 * S
    both.time_is(5 * S)
    both.scan(5 * S)
    both.until(lambda: bool(both.scans) and bool(both.clocks))
    assert both.relay.now_ns == 5 * S
    assert stamp_to_ns(both.clocks[0].clock) == 70 * S
    assert stamp_to_ns(both.scans[0].header.stamp) == 65 * S


def test_time_goes_on_where_another_simulator_begins_at_0(both: Both) -> None:
    both.time_is(100 * S)
    both.time_is(S)
    assert both.relay.now_ns == 101 * S


def test_commands_reach_the_simulator_and_are_noted_with_its_time(both: Both) -> None:
    noted: list[tuple[int, float]] = []
    both.relay.on_sent["cmd_vel"] = lambda now, msg: noted.append((now, msg.linear.x))
    both.time_is(5 * S)
    msg = Twist()
    msg.linear.x = 0.4
    both.commands.publish(msg)
    both.until(lambda: bool(both.obeyed))
    assert noted == [(5 * S, 0.4)] and both.obeyed[0].linear.x == pytest.approx(0.4)
