"""The planner behind Nav2's action FollowPath: sent, preempted, canceled, given up."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from nav2_build import CannotBuildError, nav2_environment  # noqa: E402
from node_process import NodeProcess  # noqa: E402
from test_local_planner import NODE, Robot, speed_of  # noqa: E402

from sjmc_planner.planning import DRIVING, Decision, Velocity  # noqa: E402

CLIENT = Path(__file__).with_name("follow_path_client.py")
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6  # of action_msgs/GoalStatus
TF_ERROR, INVALID_PATH, PATIENCE_EXCEEDED, NO_PROGRESS, TIMED_OUT = 102, 103, 104, 105, 107


class Client(NodeProcess):
    """The client's process, told what to do."""

    def __init__(self, env: dict[str, str]) -> None:
        super().__init__([sys.executable, str(CLIENT)], env, stdin=subprocess.PIPE)

    def tell(self, line: str) -> None:
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def result(self, number: int) -> tuple[int, int, str] | None:
        """Return status, error code and message of a goal; None while it runs."""
        for line in list(self.lines):
            if line.startswith(f"result {number} "):
                status, code, *text = line.split()[2:]
                return int(status), int(code), " ".join(text)
        return None


@pytest.fixture
def environment(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let what is started find nav2_msgs."""
    try:
        paths = nav2_environment()
    except CannotBuildError as error:
        pytest.skip(f"nav2_msgs is not installed and cannot be built here: {error}")
    for name, value in paths.items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def launch(
    environment: None, start: Callable[..., Any], peer: Any
) -> Iterator[Callable[..., SimpleNamespace]]:
    """Return what starts the planner, a robot around it, and a client of the action."""
    clients: list[Client] = []

    def _launch(*words: str) -> SimpleNamespace:
        source = ("-p", "goal_source:=follow_path")
        node = start(*NODE, "--ros-args", *source, *words)
        node.wait_for("ready", 120.0)
        clients.append(Client(dict(os.environ)))
        robot = Robot(peer, node)
        clients[-1].wait_for("server is there")
        return SimpleNamespace(node=node, robot=robot, client=clients[-1])

    yield _launch
    for client in clients:
        client.process.stdin.close()
        client.kill()


def drive(run: SimpleNamespace) -> None:
    """Send a path ahead and wait until it is followed."""
    run.client.tell("send odom 0 0 1 0 2 0")
    run.robot.until(run.robot.is_in("driving"))
    run.robot.until(lambda: run.robot.commands and speed_of(run.robot.commands[-1]) > 0.1)


def ends(run: SimpleNamespace, number: int = 0) -> tuple[int, int, str]:
    """Return how a goal ended, and see that the robot stands then."""
    run.robot.until(lambda: run.client.result(number) is not None)
    run.robot.until(lambda: speed_of(run.robot.commands[-1]) == 0.0)
    return run.client.result(number)


def test_a_path_is_followed_with_feedback_and_succeeds_at_its_end(launch):
    run = launch("-p", "goal_tolerance_m:=0.1")
    drive(run)
    run.robot.until(lambda: any(line.startswith("feedback 0 2.00 ") for line in run.client.lines))
    run.client.tell("send odom 0 0 0.05 0")  # the robot of this test stands where it is
    assert ends(run, 1)[:2] == (SUCCEEDED, 0)
    run.robot.until(run.robot.is_in("idle"))


def test_a_canceled_path_stops_the_robot(launch):
    run = launch()
    drive(run)
    run.client.tell("cancel")
    assert ends(run)[:2] == (CANCELED, 0)
    run.robot.until(run.robot.is_in("idle"))


def test_the_command_of_the_period_in_which_the_action_ends_is_zero():
    """The client hears of the end in that period: nothing that moves may go out after it."""
    from sjmc_planner.nodes.local_planner_node import LocalPlannerNode

    sent: list[str] = []
    goals = MagicMock(frame="odom")
    goals.note.side_effect = lambda *_: setattr(goals, "target", None)
    commands = MagicMock(last=Velocity(0.5, 0.0, 0.0))
    commands.drive.side_effect = lambda _: sent.append("drives")
    commands.rest.side_effect = lambda: sent.append("rests")
    method = MagicMock()
    method.decide.return_value = Decision(Velocity(0.5, 0.0, 0.0), DRIVING)
    node = MagicMock(_goals=goals, _commands=commands, _method=method)
    node._tell = lambda *args: LocalPlannerNode._tell(node, *args)
    node._inputs.velocity.return_value = Velocity(0.5, 0.0, 0.0)
    node._since_last.return_value = 0.05
    LocalPlannerNode._drive(node)
    assert sent == ["rests"]


def test_a_new_path_takes_the_place_of_the_old_one_without_a_stop(launch):
    run = launch()
    drive(run)
    run.robot.commands.clear()
    run.client.tell("send odom 0 0 0 1 0 2")
    run.robot.until(lambda: run.client.result(0) is not None)
    status, code, text = run.client.result(0)
    assert (status, code) == (ABORTED, 0) and "another path took its place" in text
    run.robot.until(lambda: run.robot.commands[-1].linear.y > 0.1)
    assert min(speed_of(m) for m in run.robot.commands) > 0.0
    assert run.client.result(1) is None


@pytest.mark.parametrize(
    ("path", "words"), [("odom", "the path is empty"), ("/ 1 0", "its frame_id is empty")]
)
def test_a_path_that_is_none_is_refused_as_that(launch, path, words):
    run = launch()
    run.client.tell(f"send {path}")
    run.robot.until(lambda: run.client.result(0) is not None)
    status, code, text = run.client.result(0)
    assert (status, code) == (ABORTED, INVALID_PATH) and words in text


@pytest.mark.parametrize(
    ("what", "code", "words"),
    [("tf", TF_ERROR, "pose: 'odom' to"), ("scan", TIMED_OUT, "/scan: no longer arriving")],
)
def test_an_input_that_stays_away_ends_it_with_its_error(launch, what, code, words):
    run = launch("-p", "follow.failure_tolerance_s:=0.5")
    drive(run)
    run.robot.silent = {what}
    status, found, text = ends(run)
    assert (status, found) == (ABORTED, code) and words in text


def test_standing_for_too_long_ends_it(launch):
    run = launch("-p", "follow.patience_s:=0.5")
    drive(run)
    run.robot.ranges = np.full_like(run.robot.ranges, np.nan)
    status, code, text = ends(run)
    assert (status, code) == (ABORTED, PATIENCE_EXCEEDED) and text


def test_not_getting_on_for_too_long_ends_it(launch):
    """The robot of this test is told to drive and stays where it is."""
    run = launch("-p", "follow.progress_s:=1.0")
    drive(run)
    status, code, text = ends(run)
    assert (status, code) == (ABORTED, NO_PROGRESS) and text == "moved less than 0.3 m in 1.0 s"
