"""sim_bridge over DDS: people, several robots, TF schemes, pause, named answers, refusals."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.qos import CLOCK_QOS, LATCHED_QOS, RELIABLE_QOS, SENSOR_QOS

LISTENING = Path(__file__).with_name("listening.py")
START_S = 60.0
WALL = "walls: [{from_m: [-3, 0], to_m: [3, 0]}]\n"
ROBOTS = """\
robots:
  - {name: r1, model: segway_rmp50, position_m: [-1, 2]}
  - {name: r2, model: segway_rmp50, position_m: [1, 2]}
"""
PEOPLE = "people: [{name: anna, path_m: [[0, 4], [0, 6]], speed_m_s: 1.0}]\n"


@pytest.fixture
def sim(start: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """Return a function that starts the node with a world file of a text."""

    def begin(text: str, *parameters: str, is_ready: bool = True) -> Any:
        path = tmp_path / "w.yaml"
        path.write_text("name: w\n" + text)
        given = [word for p in (f"world:={path}", *parameters) for word in ("-p", p)]
        module = "sim_bridge.nodes.sim_bridge_node"
        process = start(LISTENING, module, "--ros-args", *given)
        if is_ready:
            process.wait_for("ready", START_S)
        return process

    return begin


def test_people_are_on_their_own_topic_and_walk(sim, peer) -> None:
    people = peer.collect(PoseArray, "ground_truth/people", RELIABLE_QOS)
    sim(WALL + ROBOTS + PEOPLE)
    peer.spin_until(lambda: people and stamp_to_ns(people[-1].header.stamp) >= 1_000_000_000)
    assert people[-1].header.frame_id == "ground_truth"
    (pose,) = people[-1].poses
    time = 1e-9 * stamp_to_ns(people[-1].header.stamp)
    assert pose.position.y == pytest.approx(4.0 + min(time, 2.0), abs=0.02)


@pytest.mark.parametrize("scheme", ["prefix", "topic"])
def test_each_robot_has_its_topics_and_frames(sim, peer, scheme: str) -> None:
    tf2 = pytest.importorskip("tf2_msgs.msg", reason="no tf2_msgs")
    topic = {"prefix": "/tf", "topic": "r1/tf"}[scheme]
    moving = peer.collect(tf2.TFMessage, topic, RELIABLE_QOS)
    static = peer.collect(tf2.TFMessage, f"{topic}_static", LATCHED_QOS)
    scans = {r: peer.collect(LaserScan, f"{r}/scan", SENSOR_QOS) for r in ("r1", "r2")}
    sim(WALL + ROBOTS, f"tf_scheme:={scheme}")
    peer.spin_until(lambda: len(moving) > 5 and static and all(scans.values()))
    frames = {t.child_frame_id for msg in moving for t in msg.transforms}
    assert frames == ({"r1/base_link", "r2/base_link"} if scheme == "prefix" else {"base_link"})
    laser = "r1/laser" if scheme == "prefix" else "laser"
    assert laser in {t.child_frame_id for t in static[-1].transforms}
    assert scans["r1"][-1].header.frame_id == laser


def test_pause_stops_time_and_step_still_goes_on(sim, peer) -> None:
    odometry = peer.collect(Odometry, "r1/odom", RELIABLE_QOS)
    process = sim(WALL + ROBOTS, "paused:=true", "step_s:=0.5")
    peer.spin(0.5)
    assert not odometry
    assert peer.trigger("sim_bridge/step", process).message == "at 0.50 s"


def test_the_clock_comes_at_the_chosen_rate(sim, peer) -> None:
    clock = peer.collect(Clock, "/clock", CLOCK_QOS)
    sim(WALL + ROBOTS, "clock_period_s:=0.05")
    peer.spin_until(lambda: len(clock) > 5)
    assert all(stamp_to_ns(msg.clock) % 50_000_000 == 0 for msg in clock)


def test_time_waits_for_a_named_node_to_listen_and_then_for_its_answers(sim, peer) -> None:
    lag_ns, name = 500_000_000, peer.node.get_name()
    named = (f"start_nodes:=[{name}]", f"pace_nodes:=[{name}]")
    limits = ("pace_lag_s:=0.5", "pace_timeout_s:=1000.0")
    process = sim(WALL + ROBOTS, *named, *limits, "real_time_factor:=5.0")
    process.wait_for(f"time waits for /{name} to listen")
    answers = peer.node.create_publisher(Odometry, "any_topic_of_it", RELIABLE_QOS)
    truth = peer.collect(Odometry, "r1/ground_truth/odom", RELIABLE_QOS)

    def now_ns() -> int:
        return stamp_to_ns(truth[-1].header.stamp) if truth else 0

    peer.spin_until(lambda: now_ns() == lag_ns)  # no answer came yet
    answered = Odometry()
    for _ in range(3):
        answered.header.stamp = truth[-1].header.stamp
        answered_ns = now_ns()
        peer.publish_until(answers, answered, lambda end=answered_ns + lag_ns: now_ns() == end)
        peer.spin(0.3)
        assert now_ns() == answered_ns + lag_ns
    assert stamp_to_ns(truth[0].header.stamp) < lag_ns


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("walls: [{from_m: [1, 2], to_m: [1, 2]}]\n", "zero length"),
        (ROBOTS.replace("r2", "r1"), "two robots have the name 'r1'"),
        (ROBOTS.replace("r2", "2 r"), "name must be letters"),
        (ROBOTS.replace("[1, 2]", "[-1, 2.2]"), "inside"),
        (WALL + ROBOTS.replace("[1, 2]", "[1, 0.1]"), "inside 'wall'"),
        (ROBOTS + "recorded_people: {file: not/there.txt}\n", "not/there.txt: No such file"),
    ],
)
def test_a_bad_world_is_one_line_and_exit_code_2(sim, text: str, words: str) -> None:
    process = sim(text, is_ready=False)
    assert process.wait_for_exit(START_S) == 2
    assert words in process.text and "Traceback" not in process.text


def test_an_unknown_world_parameter_is_refused(sim) -> None:
    process = sim(WALL + ROBOTS, "world_parameters:=[distance=2]", is_ready=False)
    assert process.wait_for_exit(START_S) == 2
    assert "no parameter named 'distance'" in process.text
