"""The command that sends a goal to the planner, over DDS."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped  # noqa: E402
from test_local_planner import launch  # noqa: E402, F401, a fixture

SENDER = (Path(__file__).with_name("listening.py"), "sjmc_planner.nodes.send_goal_node")


def test_a_goal_sent_by_the_command_is_followed_until_it_is_reached(launch, start):  # noqa: F811
    run = launch(goal=False)
    far = start(*SENDER, "--ros-args", "-p", "x_m:=2.0", "-p", "y_m:=-0.5")
    run.robot.until(lambda: "driving, 2.06 m left" in far.text)
    assert far.stop(signal.SIGINT) == 0 and "reached" not in far.text
    here = start(*SENDER, "--ros-args", "-p", "x_m:=0.0")
    run.robot.until(lambda: here.has_ended)
    assert here.wait_for_exit() == 0 and "reached, 0.00 m left" in here.text


def test_a_goal_that_nobody_listens_to_is_said_and_one_sent_without_waiting_is_enough(start, peer):
    given = ("--ros-args", "-p", "x_m:=1", "-p", "y_m:=-0.5", "-p", "waits:=false")
    sender = start(*SENDER, *given)
    sender.wait_for("nobody listens to /goal_pose")
    goals = peer.collect(PoseStamped, "goal_pose", 5)
    peer.spin_until(lambda: sender.has_ended)
    assert sender.wait_for_exit() == 0
    peer.spin_until(lambda: goals)
    assert goals[0].header.frame_id == "odom"
    assert (goals[0].pose.position.x, goals[0].pose.position.y) == (1.0, -0.5)
