"""The rule of time over real DDS: slow, fast and halted /clock of the test's own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from robot_messages import Robot, S, hear_diagnostics, scan_of, statuses, tf_of, time_of
from rosgraph_msgs.msg import Clock

NODES = Path(__file__).parent / "common_nodes.py"
NodeProcess = Peer = Any  # of conftest.py
OK, ERROR, STALE = b"\x00", b"\x02", b"\x03"
CLOCK_PERIOD_S = 0.01
STOPPED_AFTER_S = 2.0
SCAN_PERIOD_NS = S // 10
START_NS = 100 * S


class World:
    """Simulated time at some factor of real time, and the scans and transforms that belong to it.

    Args:
        peer: The test's own node.
        node: The process `both`: ScanEcho, and Picky with a timeout of 0.5 s on /scan.
    """

    def __init__(self, peer: Peer, node: NodeProcess) -> None:
        self._peer, self._node = peer, node
        self.now_ns = START_NS
        self.told_at = 0.0
        self.arrays = hear_diagnostics(peer)
        self._robot = Robot(peer, node)
        self._clock = peer.publisher(Clock, "/clock", 10, to=node)
        self._next_scan_ns = START_NS
        self.num_scans = 0

    def run(self, factor: float, seconds: float, *, has_scans: bool = True) -> None:
        """Let so many simulated seconds pass; each scan's transform comes one scan later.

        On a busy machine time passes more slowly: never by more than a scan at once, and no scan
        comes before the nodes have had the last but one.
        """
        before = time.monotonic()
        end_ns = self.now_ns + round(seconds * S)
        while self.now_ns < end_ns:
            self._peer.spin(CLOCK_PERIOD_S)
            now = time.monotonic()
            passed_ns, before = round(factor * (now - before) * S), now
            self.now_ns += min(passed_ns, SCAN_PERIOD_NS)
            self.told_at = time.monotonic()
            self._clock.publish(Clock(clock=time_of(self.now_ns)))
            if has_scans and self.now_ns >= self._next_scan_ns:
                self._send_scan()

    def _send_scan(self) -> None:
        stamp_ns = self._next_scan_ns
        self._robot.tf.publish(tf_of("odom", "base_link", stamp_ns - SCAN_PERIOD_NS // 2, 0.0))
        self._robot.scans.publish(scan_of(stamp_ns))
        self._next_scan_ns += SCAN_PERIOD_NS
        self.num_scans += 1
        self.wait_for_scans()

    def wait_for_scans(self) -> None:
        """Wait until the nodes have had all scans whose transforms came."""
        if self.num_scans > 1:
            last_ns = self._next_scan_ns - 2 * SCAN_PERIOD_NS
            self._node.wait_for(f"scan {last_ns} at x 0.500")

    def levels(self, part: str) -> set[bytes]:
        """Return the levels said of a part since the last call, a clock that halts left out."""
        found = self.levels_but_halt(part)
        self.arrays.clear()
        return found

    def levels_but_halt(self, part: str) -> set[bytes]:
        """Return the same and keep what was said."""
        said = statuses(self.arrays, part)
        return {s.level for s in said if "stands still" not in s.message}


@pytest.fixture
def both(start: Callable[..., Any]) -> NodeProcess:
    node = start(NODES, "both", "--ros-args", "-p", "use_sim_time:=true")
    node.wait_for("[picky]: ready")
    return node


@pytest.mark.parametrize(("factor", "seconds"), [(0.1, 0.4), (1.0, 1.5), (10.0, 12.0)])
def test_at_any_speed_scans_wait_and_inputs_are_silent_in_simulated_time(
    both: NodeProcess, peer: Peer, factor: float, seconds: float
) -> None:
    world = World(peer, both)
    part = "input /scan"
    world.run(factor, 2 * SCAN_PERIOD_NS / S)
    peer.spin_until(lambda: OK in world.levels(part))
    # At a tenth of the speed a scan waits 1 s for its transform, longer than the 0.5 s allowed in
    # real time; at ten times the speed the silence that is allowed lasts 0.05 s.
    world.run(factor, seconds)
    peer.spin_until(lambda: bool(statuses(world.arrays, part)))
    assert "dropped" not in both.text
    assert world.levels(part) <= {OK}

    def is_silent() -> bool:
        world.run(factor, 2 * factor * CLOCK_PERIOD_S, has_scans=False)
        return STALE in world.levels(part)

    silent_since_ns = world.now_ns
    peer.spin_until(is_silent)
    assert world.now_ns - silent_since_ns > 0.2 * S


def test_a_pause_is_no_silence_but_a_fault_of_the_clock_and_then_all_goes_on(
    both: NodeProcess, peer: Peer
) -> None:
    world, part = World(peer, both), "input /scan"
    world.run(1.0, 0.5)
    peer.spin_until(lambda: OK in world.levels(part))
    peer.spin_until(lambda: ERROR in {s.level for s in statuses(world.arrays, "clock")})
    assert time.monotonic() - world.told_at >= STOPPED_AFTER_S
    assert world.levels_but_halt(part) <= {OK}
    peer.spin_until(lambda: "stands still" in statuses(world.arrays, part)[-1].message)
    num_before = len([line for line in both.lines if line.startswith("scan 1")])
    world.arrays.clear()
    world.run(1.0, 0.5)
    assert len([line for line in both.lines if line.startswith("scan 1")]) > num_before
    assert "dropped" not in both.text and "jumped back" not in both.text
    peer.spin_until(lambda: OK in {s.level for s in statuses(world.arrays, "clock")})
