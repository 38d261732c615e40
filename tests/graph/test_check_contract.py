"""The command that holds a live topic against its consumers' rules."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from sensor_msgs.msg import LaserScan

from floornav_common.ros.qos import RELIABLE_QOS

SCRIPT = Path(__file__).parents[2] / "scripts" / "check_contract.py"
NUM = 90


@pytest.mark.parametrize(("num_ranges", "code"), [(NUM, 0), (NUM - 1, 1)])
def test_a_live_scan_is_judged(start, peer, tmp_path: Path, num_ranges: int, code: int) -> None:
    step = 2.0 * math.pi / NUM
    msg = LaserScan(
        angle_min=-math.pi, angle_max=math.pi - step, angle_increment=step, range_min=0.1,
        range_max=2.0, ranges=[1.0] * num_ranges,
    )  # fmt: skip
    msg.header.frame_id = "laser"
    publisher = peer.node.create_publisher(LaserScan, "scan", RELIABLE_QOS)
    words = ("--topics", "/scan", "--duration", "8", "--out", tmp_path / "out")
    process = start(SCRIPT, *words)
    second = 0
    while not process.has_ended:
        second += 1
        msg.header.stamp = Time(sec=second)
        publisher.publish(msg)
        peer.spin(0.1)
    assert process.wait_for_exit() == code, process.text
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    rules = found["topics"]["/scan"]["rules"]
    assert {name for name, rule in rules.items() if rule["result"] == "FAIL"} == (
        set() if code == 0 else {"beam count"}
    )
    assert rules["age"]["result"] == rules["in the tree"]["result"] == "not judged"


def test_a_topic_that_nobody_publishes_is_named(start) -> None:
    process = start(SCRIPT, "--topics", "/nobody", "--duration", "0.5")
    assert process.wait_for_exit() == 2
    assert "nobody publishes /nobody" in process.text
