"""A camera's free space in place of a scan: simulated field, detector, planner, over DDS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticStatus  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from std_msgs.msg import Bool  # noqa: E402
from test_local_planner import goal_of  # noqa: E402

from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS  # noqa: E402

LISTENING = Path(__file__).with_name("listening.py")
DRIVE_S = 240.0
GOAL = (1.35, 0.5)  # in odom, which begins at (-0.35, -0.1): the first cube is on the line
CUBES = ((0.55, 0.30), (0.70, -0.40))
# For a machine that is busy: a slow clock, and time does not run on without image or command.
SIM = (
    "world:=small_size_field", "real_time_factor:=0.5",
    "pace_topics:=[cmd_vel, floor/free_space]", "pace_lag_s:=0.1",
)  # fmt: skip


def words_of(*parameters: str) -> list[str]:
    return [word for parameter in parameters for word in ("-p", parameter)]


def state_of(states: list[Any]) -> str:
    values = {v.key: v.value for v in states[-1].values} if states else {}
    return values.get("state", "")


@pytest.mark.parametrize("method", ["sjmc", "vfh_plus"])
def test_free_space_drives_it_round_cubes_to_a_goal_without_touching(start, peer, method):
    states = peer.collect(DiagnosticStatus, "planner/state", RELIABLE_QOS)
    truth = peer.collect(Odometry, "ground_truth/odom", RELIABLE_QOS)
    odometry = peer.collect(Odometry, "odom", RELIABLE_QOS)
    touches = peer.collect(Bool, "ground_truth/contact", LATCHED_QOS)
    planner = start(
        LISTENING, "sjmc_planner.nodes.local_planner_node", "--ros-args",
        "-r", "scan:=floor/free_space",
        *words_of("goal_source:=goal_pose", "use_sim_time:=true", f"method:={method}"),
    )  # fmt: skip
    detector = start(LISTENING, "floor_perception.nodes.floor_detector_node")
    planner.wait_for("ready", 120.0)
    detector.wait_for("ready", 120.0)
    simulator = start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *words_of(*SIM))
    simulator.wait_for("ready", 120.0)
    goals = peer.publisher(PoseStamped, "goal_pose", 5, to=planner)
    goals.publish(goal_of(*GOAL))
    peer.spin_until(lambda: state_of(states) == "reached", DRIVE_S)
    way = np.array([(m.pose.pose.position.x, m.pose.pose.position.y) for m in truth])
    at = odometry[-1].pose.pose.position
    assert (at.x, at.y) == pytest.approx(GOAL, abs=0.1)
    assert way[-1] == pytest.approx([GOAL[0] - 0.35, GOAL[1] - 0.1], abs=0.3)  # wheels slip
    assert not any(m.data for m in touches)
    for cube in CUBES:
        assert np.hypot(*(way - cube).T).min() > 0.085 + 0.065
