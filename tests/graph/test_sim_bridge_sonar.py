"""The sonar topics of sim_bridge over DDS."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from sensor_msgs.msg import Range

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import SENSOR_QOS

LISTENING = Path(__file__).with_name("listening.py")
START_S = 60.0


def _start(start: Callable[..., Any], *parameters: str) -> None:
    given = [word for parameter in parameters for word in ("-p", parameter)]
    process = start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *given)
    process.wait_for("ready", START_S)


def test_all_sonars_share_a_topic_and_are_told_apart_by_frame(start, peer) -> None:
    heard = peer.collect(Range, "sonar", SENSOR_QOS)
    _start(start, "real_time_factor:=2.0")
    peer.spin_until(lambda: len({msg.header.frame_id for msg in heard}) == 16)
    msg = heard[-1]
    assert msg.radiation_type == Range.ULTRASOUND
    assert (msg.min_range, msg.max_range) == pytest.approx((0.15, 5.0))
    assert msg.field_of_view == pytest.approx(0.349066)
    assert stamp_to_ns(msg.header.stamp) % 50_000_000 == 0
    assert all(msg.range >= msg.min_range or msg.range < 0.0 for msg in heard)


def test_each_sonar_may_have_a_topic_of_its_own(start, peer) -> None:
    third = peer.collect(Range, "sonar_3", SENSOR_QOS)
    _start(start, "sonar_topics:=each")
    peer.spin_until(lambda: len(third) > 2)
    assert {msg.header.frame_id for msg in third} == {"sonar_3"}
