"""The team's localizer over DDS: every robot its own process, and one for all."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from robot_messages import S, statuses, time_of
from rosgraph_msgs.msg import Clock
from team_scene import ODOMETRY_START, POLES, POSES, TeamVoices, write_landmarks
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from floornav_common.ros.diagnostics import ERROR, OK, STALE, WARN
from floornav_common.ros.messages import pose_to_se2
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from multi_localizer.pose_estimate import normalized_error
from multi_localizer.ros_conversions import estimate_from_msg

NODE = (Path(__file__).with_name("listening.py"), "multi_localizer.nodes.team_localizer_node")
TEAM = "[r1, r2, r3, r4]"
# The sway (0.03 m, 0.02 rad) and two deviations as told right after a start (0.06 m, 0.02 rad).
NEAR_M, NEAR_RAD = 0.15, 0.07
FAR_OFF = 40.0  # chi-squared of 3 degrees: once in 10^8
ROUND_S = 0.1


@pytest.fixture
def landmarks(tmp_path: Path) -> Path:
    return write_landmarks(tmp_path)


@pytest.fixture
def localizer(start: Any, landmarks: Path) -> Callable[..., Any]:
    """Return a function that starts a localizer and waits until it is ready."""

    def make(name: str = "", *words: str, team: str = TEAM) -> Any:
        given = ["-p", f"team:={team}", "-p", f"landmarks:={landmarks}", *words]
        given += ["-r", f"__ns:=/{name}"] if name else ["-p", "publish_for:=all"]
        process = start(*NODE, "--ros-args", *given)
        process.wait_for("ready")
        return process

    return make


class Team:
    """The test's robots, which send a round of messages every tenth of a second."""

    def __init__(self, peer: Any, *nodes: Any, names: Sequence[str] = tuple(POSES)) -> None:
        self.peer = peer
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        make = lambda kind, topic: peer.node.create_publisher(kind, topic, RELIABLE_QOS)  # noqa: E731
        self.voices = TeamVoices(peer.node, names, 0, make)
        for node in nodes:
            for name in names:
                node.wait_to_hear(f"/{name}/bearings/robots")
                node.wait_to_hear(f"/{name}/bearings/pole")
                node.wait_to_hear(f"/{name}/pose")

    def go_on(self, is_done: Callable[[], bool], timeout: float = 60.0, **how: Any) -> None:
        """Send until something is so."""
        end = time.monotonic() + timeout
        while not is_done():
            said = {(s.level, s.message) for a in self.states[-10:] for s in a.status}
            assert time.monotonic() < end, f"not so within {timeout} s; last said: {said}"
            self.voices.say(time.time_ns(), **how)
            self.peer.spin_until(is_done, ROUND_S, must=False)

    def last(self, part: str) -> DiagnosticStatus | None:
        """Return what was last said of a part."""
        found = statuses(self.states, part)
        return found[-1] if found else None

    def says(self, part: str, level: bytes, words: str) -> Callable[[], bool]:
        """Return whether it is what was last said of a part."""

        def is_so() -> bool:
            status = self.last(part)
            return status is not None and status.level == level and words in status.message

        return is_so


def is_near(pose: SE2, name: str) -> bool:
    off = POSES[name].between(pose)
    return off.distance < NEAR_M and abs(off.yaw) < NEAR_RAD


def time_ns(msg: PoseWithCovarianceStamped) -> int:
    return int(msg.header.stamp.sec) * S + int(msg.header.stamp.nanosec)


def values_of(status: DiagnosticStatus) -> dict[str, str]:
    return {each.key: each.value for each in status.values}


def test_every_robot_finds_itself_and_all_others(localizer, peer) -> None:
    """Three processes, three namespaces; the fourth robot has no localizer of its own."""
    names = ("r1", "r2", "r3")
    nodes = [localizer(name) for name in names]
    own = {n: peer.collect(PoseWithCovarianceStamped, f"/{n}/team_pose", 10) for n in names}
    everyone = {n: peer.collect(PoseArray, f"/{n}/team/poses", 10) for n in names}
    team = Team(peer, *nodes)
    team.go_on(lambda: all(len(own[n]) >= 3 and len(everyone[n]) >= 3 for n in names))
    for name in names:
        estimate = estimate_from_msg(own[name][-1])
        assert own[name][-1].header.frame_id == "map"
        assert is_near(estimate.pose, name)
        assert normalized_error(estimate.pose, POSES[name], estimate.cov) < FAR_OFF
        poses = [pose_to_se2(p) for p in everyone[name][-1].poses]
        assert all(is_near(pose, n) for pose, n in zip(poses, POSES, strict=True))
    assert peer.node.count_publishers("/r4/team_pose") == 0
    offset = lambda: (team.last("robot r2") and values_of(team.last("robot r2"))) or {}  # noqa: E731
    team.go_on(lambda: offset().get("its error (s)", "one way") != "one way")
    assert abs(float(offset()["clock offset (s)"])) <= 0.001 + float(offset()["its error (s)"])


def test_one_for_all_tells_where_all_are_and_draws_them(localizer, peer) -> None:
    node = localizer()
    own = {n: peer.collect(PoseWithCovarianceStamped, f"/{n}/team_pose", 10) for n in POSES}
    markers = peer.collect(MarkerArray, "/team/markers", 10)
    team = Team(peer, node)
    team.go_on(lambda: markers and all(len(msgs) >= 3 for msgs in own.values()))
    for name, msgs in own.items():
        assert is_near(estimate_from_msg(msgs[-1]).pose, name)
    kinds = [m.ns for m in markers[-1].markers]
    assert [kinds.count(k) for k in ("robots", "names", "deviations", "sights")] == [4, 4, 4, 1]
    team.go_on(team.says("team", OK, "4 of 4 robots located"))


def test_robots_that_fall_silent_and_come_back(localizer, peer) -> None:
    node = localizer("r1", "-p", "robot_timeout_s:=0.5")
    poses = peer.collect(PoseArray, "/r1/team/poses", 10)
    team = Team(peer, node)
    team.go_on(team.says("team", OK, "4 of 4 robots located"))
    team.go_on(
        team.says("robot r3", STALE, "no bearings on /r3/bearings/robots any"), silent=["r3"]
    )
    poses.clear()
    team.go_on(lambda: len(poses) >= 3, silent=["r3"])
    assert all(is_near(pose_to_se2(poses[-1].poses[k]), n) for k, n in ((0, "r1"), (1, "r2")))
    team.go_on(team.says("team", OK, "4 of 4 robots located"))


def test_a_team_of_one_who_tells_is_no_team(localizer, peer) -> None:
    node = localizer("r1", "-p", "robot_timeout_s:=0.5")
    team = Team(peer, node)
    everyone = ["r1", "r2", "r3", "r4"]
    team.go_on(
        lambda: (
            "1 robots tell, 3 make a triangle" in (team.last("team") or DiagnosticStatus()).message
        ),
        silent=everyone[1:],
    )
    team.go_on(
        team.says("team", STALE, "no robot's bearings arrive, this robot's"), silent=everyone
    )


def test_a_robot_without_a_pose_of_its_own_is_located_by_the_others(localizer, peer) -> None:
    node = localizer("r2")
    own = peer.collect(PoseWithCovarianceStamped, "/r2/team_pose", 10)
    team = Team(peer, node)
    team.go_on(lambda: len(own) >= 3, without_pose=["r2"])
    assert is_near(estimate_from_msg(own[-1]).pose, "r2")
    team.go_on(
        team.says("robot r2", WARN, "located without a pose of its own"), without_pose=["r2"]
    )


def test_a_robot_that_lies_about_its_place_misleads_nobody(localizer, peer) -> None:
    node = localizer("r1", "-p", "poses_use_landmarks:=false")
    own = peer.collect(PoseWithCovarianceStamped, "/r1/team_pose", 10)
    everyone = peer.collect(PoseArray, "/r1/team/poses", 10)
    team = Team(peer, node)
    lies = {"r3": SE2(3.0, 2.0, 0.0)}
    team.go_on(lambda: len(own) >= 5 and len(everyone) >= 5, lies=lies)
    assert is_near(estimate_from_msg(own[-1]).pose, "r1")
    assert is_near(pose_to_se2(everyone[-1].poses[2]), "r3")
    team.go_on(team.says("robot r3", WARN, "which its own pose contradicts"), lies=lies)


def test_other_things_are_located_by_two_or_more(localizer, peer) -> None:
    node = localizer("r1", "-p", "object_classes:=[ball]")
    objects = peer.collect(PoseArray, "/r1/objects", 10)
    team = Team(peer, node)
    ball = np.array([[0.9, 0.4]])
    balls = {
        n: peer.publisher(PoseArray, f"/{n}/bearings/ball", RELIABLE_QOS, to=node) for n in POSES
    }

    def is_found() -> bool:
        stamp = time.time_ns()
        team.voices.say(stamp)
        for name, publisher in balls.items():
            publisher.publish(team.voices.bearings_msg(name, stamp, team.voices.seen(name, ball)))
        peer.spin(ROUND_S)
        return any(len(msg.poses) == 1 for msg in objects)

    peer.spin_until(is_found)
    (pose,) = next(msg.poses for msg in objects if msg.poses)
    assert math.hypot(pose.position.x - 0.9, pose.position.y - 0.4) < NEAR_M


def test_bearings_of_nan_and_doubled_messages_are_counted_and_harmless(localizer, peer) -> None:
    node = localizer("r1")
    own = peer.collect(PoseWithCovarianceStamped, "/r1/team_pose", 10)
    team = Team(peer, node)
    team.go_on(lambda: len(own) >= 1)
    places = np.array([[p.x, p.y] for n, p in POSES.items() if n != "r2"])
    for _ in range(5):
        stamp = time.time_ns()
        team.voices.say(stamp, silent=["r2"])
        good = team.voices.seen("r2", POLES)
        team.voices.say_bearings("r2", "pole", stamp, good)
        with_nan = np.append(team.voices.seen("r2", places), math.nan)
        team.voices.say_bearings("r2", "robots", stamp, with_nan)
        team.voices.say_bearings("r2", "robots", stamp, with_nan)
        peer.spin(ROUND_S)
    counted = lambda: values_of(team.last("robot r2") or DiagnosticStatus())  # noqa: E731
    team.go_on(lambda: counted().get("void bearings") == "10" and counted().get("doubled") == "5")
    assert all(is_near(estimate_from_msg(msg).pose, "r1") for msg in own)


def test_map_to_odom_comes_from_the_team_where_that_is_wanted(localizer, peer) -> None:
    """The odometry began elsewhere, and turned."""
    node = localizer("r1", "-p", "publish_tf:=true", "-p", "frame_prefix:=r1/")
    sent = peer.collect(TFMessage, "/tf", 100)
    team = Team(peer, node)
    T_map_odom = POSES["r1"] @ ODOMETRY_START.inverse()
    found: list[SE2] = []

    def is_sent() -> bool:
        found[:] = [
            Transform3.from_parts((t.x, t.y, t.z), (q.x, q.y, q.z, q.w)).to_se2()
            for msg in sent
            for each in msg.transforms
            if (each.header.frame_id, each.child_frame_id) == ("r1/map", "r1/odom")
            for t, q in [(each.transform.translation, each.transform.rotation)]
        ]
        return len(found) >= 3

    team.go_on(is_sent)
    off = T_map_odom.between(found[-1])
    assert off.distance < 6.0 * NEAR_RAD + NEAR_M and abs(off.yaw) < NEAR_RAD


def test_a_clock_that_jumps_back_begins_all_anew(localizer, peer) -> None:
    node = localizer("r1", "-p", "use_sim_time:=true")
    own = peer.collect(PoseWithCovarianceStamped, "/r1/team_pose", 10)
    clock = peer.publisher(Clock, "/clock", 10, to=node)
    team = Team(peer, node)
    for start_s in (200, 10):
        own.clear()
        stamp_ns = start_s * S
        while sum(msg.header.stamp.sec <= start_s + 90 for msg in own) < 3:
            stamp_ns += S // 10
            assert stamp_ns < (start_s + 90) * S
            clock.publish(Clock(clock=time_of(stamp_ns)))
            team.voices.say(stamp_ns)
            peer.spin(ROUND_S)
        assert is_near(estimate_from_msg(own[-1]).pose, "r1")
    assert own[-1].header.stamp.sec < 100


@pytest.mark.parametrize("back_s", [2.0, 8.0])
def test_stamps_set_back_without_a_clock_begin_all_anew(localizer, peer, back_s: float) -> None:
    node = localizer()
    own = peer.collect(PoseWithCovarianceStamped, "/r2/team_pose", 200)
    team = Team(peer, node)
    team.go_on(lambda: len(own) >= 10)
    turn_ns = time.time_ns()
    behind = dict.fromkeys(POSES, back_s)
    late = lambda: [m for m in own if time_ns(m) > turn_ns - round((back_s - 1.0) * S)]  # noqa: E731
    own.clear()
    team.go_on(lambda: len(late()) >= 10 and time.time_ns() - turn_ns > 3 * S, behind_s=behind)
    assert all(time_ns(m) < time.time_ns() - (back_s - 0.5) * S for m in late()[-10:])
    assert all(is_near(estimate_from_msg(m).pose, "r2") for m in own)


def test_when_the_leader_falls_silent_one_whose_clock_is_behind_leads(localizer, peer) -> None:
    """The others' stamps are those of the leader, so that theirs step back as well."""
    node = localizer("", "-p", "robot_timeout_s:=0.6")
    own = peer.collect(PoseWithCovarianceStamped, "/r3/team_pose", 200)
    team = Team(peer, node)
    behind = {"r2": 2.5}
    team.go_on(lambda: len(own) >= 15, behind_s=behind)
    first_ns = time_ns(own[-1])
    is_back = lambda: any(time_ns(m) < first_ns for m in own[15:])  # noqa: E731
    team.go_on(is_back, behind_s=behind, silent=["r1"])
    own.clear()
    team.go_on(lambda: len(own) >= 5, behind_s=behind, silent=["r1"])
    assert all(is_near(estimate_from_msg(m).pose, "r3") for m in own)


def test_two_robots_of_one_name_are_not_believed(localizer, peer, make_peer) -> None:
    node = localizer("r1")
    team = Team(peer, node)
    team.go_on(team.says("team", OK, "4 of 4 robots located"))
    twin = make_peer("twin")
    twin.publisher(PoseArray, "/r2/bearings/robots", RELIABLE_QOS, to=node, num=2)
    team.go_on(team.says("robot r2", ERROR, "2 nodes publish /r2/bearings/robots"))
    team.go_on(team.says("team", WARN, "r2: 2 nodes publish"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-p", "team:=[r1, r1, r2]"], "team must name each robot once, got 'r1' twice"),
        (["-p", "team:=[r2, r3, r4]"], "namespace 'r1' is not in team"),
        ([], "parameter team must name the robots"),
        (["-p", "team:=[r1, r2, r3]", "-p", "landmarks:=nowhere"], "'nowhere'"),
    ],
)
def test_a_team_that_cannot_be_is_refused_in_one_line(start, words, said) -> None:
    node = start(*NODE, "--ros-args", "-r", "__ns:=/r1", *words)
    assert node.wait_for_exit() == 2
    assert said in node.text and len(node.lines) == 1


def test_a_misspelled_teammate_and_the_state_of_all_are_in_the_log(localizer, peer) -> None:
    node = localizer("r1", team="[r1, r2, r3, rr4]")
    team = Team(peer)
    for name in ("r1", "r2", "r3"):
        node.wait_to_hear(f"/{name}/bearings/robots")
    is_said = lambda *words: all(w in node.text for w in words)  # noqa: E731
    team.go_on(
        lambda: is_said(
            "/r4 sends bearings/robots and is not in team [r1, r2, r3, rr4]: is a name misspelled?",
            "rr4: no bearings on /rr4/bearings/robots",
            "r2: located",
        )
    )
    team.go_on(team.says("team list", WARN, "/r4 sends"))
    assert "where its camera sits" not in node.text
    team.go_on(lambda: is_said("r2: no bearings on /r2/bearings/robots any more"), silent=["r2"])
