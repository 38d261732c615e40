"""The rule of time over real DDS: slow, fast and halted /clock of the test's own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from robot_messages import Robot, S, scan_of, statuses, tf_of, time_of
from rosgraph_msgs.msg import Clock

NODES = Path(__file__).parent / "common_nodes.py"
NodeProcess = Peer = Any  # of conftest.py
OK, ERROR, STALE = b"\x00", b"\x02", b"\x03"
CLOCK_PERIOD_S = 0.01
SCAN_PERIOD_NS = S // 10
START_NS = 100 * S


class World:
    """Simulated time at some factor of real time, and the scans and transforms that belong to it.

    Args:
        peer: The test's own node.
        node: The process `both`: ScanEcho, and Picky with a timeout of 0.5 s on /scan.
    """

    def __init__(self, peer: Peer, node: NodeProcess) -> None:
        self._peer = peer
        self.now_ns = START_NS
        self.arrays = peer.collect(DiagnosticArray, "/diagnostics", 50)
        self._robot = Robot(peer, node)
        self._clock = peer.publisher(Clock, "/clock", 10, to=node)
        self._next_scan_ns = START_NS
        self.num_scans = 0

    def run(self, factor: float, seconds: float, *, has_scans: bool = True) -> None:
        """Let so many simulated seconds pass; each scan's transform comes one scan later."""
        before = time.monotonic()
        end_ns = self.now_ns + round(seconds * S)
        while self.now_ns < end_ns:
            self._peer.spin(CLOCK_PERIOD_S)
            now = time.monotonic()
            self.now_ns, before = self.now_ns + round(factor * (now - before) * S), now
            self._clock.publish(Clock(clock=time_of(self.now_ns)))
            if has_scans and self.now_ns >= self._next_scan_ns:
                self._send_scan()

    def _send_scan(self) -> None:
        stamp_ns = self._next_scan_ns
        self._robot.tf.publish(tf_of("odom", "base_link", stamp_ns - SCAN_PERIOD_NS // 2, 0.0))
        self._robot.scans.publish(scan_of(stamp_ns))
        self._next_scan_ns += SCAN_PERIOD_NS
        self.num_scans += 1

    def levels(self, part: str) -> set[bytes]:
        """Return the levels said of a part since the last call."""
        found = {s.level for s in statuses(self.arrays, part)}
        self.arrays.clear()
        return found


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
    world.run(factor, 2 * SCAN_PERIOD_NS / S)
    peer.spin(0.3)
    world.levels("input /scan")
    # At a tenth of the speed a scan waits 1 s for its transform, longer than the 0.5 s allowed in
    # real time; at ten times the speed the silence that is allowed lasts 0.05 s.
    world.run(factor, seconds)
    both.wait_for(f"scan {START_NS + (world.num_scans - 2) * SCAN_PERIOD_NS} at x 0.500")
    assert "dropped" not in both.text
    assert world.levels("input /scan") == {OK}
    world.run(factor, 0.52 + 0.05 * factor, has_scans=False)
    peer.spin_until(lambda: STALE in world.levels("input /scan"))


def test_a_pause_is_no_silence_but_a_fault_of_the_clock_and_then_all_goes_on(
    both: NodeProcess, peer: Peer
) -> None:
    world = World(peer, both)
    world.run(1.0, 0.5)
    peer.spin(0.2)
    world.arrays.clear()
    peer.spin(1.2)
    assert OK in {s.level for s in statuses(world.arrays, "input /scan")}
    assert not {s.level for s in statuses(world.arrays, "clock")} & {ERROR}
    peer.spin_until(lambda: ERROR in {s.level for s in statuses(world.arrays, "clock")})
    input_status = "input /scan"
    peer.spin_until(lambda: "stands still" in statuses(world.arrays, input_status)[-1].message)
    num_before = len([line for line in both.lines if line.startswith("scan 1")])
    world.arrays.clear()
    world.run(1.0, 0.5)
    peer.spin(0.2)
    assert len([line for line in both.lines if line.startswith("scan 1")]) > num_before
    assert "dropped" not in both.text and "jumped back" not in both.text
    assert statuses(world.arrays, "clock")[-1].level == OK
