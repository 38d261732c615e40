"""A demo does not mix with a simulation that is in its ROS domain already."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

rclpy = pytest.importorskip("rclpy", reason="no ROS: the demo talks over DDS")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

DEMO = Path(__file__).resolve().parents[2] / "scripts" / "demo.py"


@pytest.mark.parametrize("world", ["furnished_floor", "fleet"])
def test_another_clock_in_the_chosen_domain_is_one_line(
    ros_domain_id: int, tmp_path: Path, world: str
) -> None:
    from rosgraph_msgs.msg import Clock

    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain_id)
    node = rclpy.create_node("other_simulator", context=context)
    node.create_publisher(Clock, "/clock", 1)
    try:
        done = subprocess.run(
            [sys.executable, str(DEMO), world, "--headless", "--out", str(tmp_path / "out")],
            env={**os.environ, "FLOORNAV_ENV_READY": "1"}, capture_output=True, text=True,
            timeout=300.0,
        )  # fmt: skip
    finally:
        node.destroy_node()
        context.try_shutdown()
    text = done.stdout + done.stderr
    assert done.returncode == 1, text
    assert text.count("\n") == 1 and "/other_simulator" in text
    assert f"domain {ros_domain_id}" in text and "unset ROS_DOMAIN_ID" in text
    assert not (tmp_path / "out").exists()
