"""The live view over DDS: what comes in is shown, a click goes out, and nothing ends the node."""

from __future__ import annotations

import math
import re
from typing import Any

import cv2
import numpy as np
import pytest
from browsers import Looker
from websockets.exceptions import InvalidStatus

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import PoseStamped  # noqa: E402, I001
from live_scene import CORNER, Scene, glass_cells, room, room_cells  # noqa: E402
from pathlib import Path  # noqa: E402

TOL_M = 1e-3
NODE = (
    Path(__file__).with_name("listening.py"), "floornav_common.nodes.live_view_node", "--ros-args",
)  # fmt: skip


def begin(start, *words: str, port: int = 0) -> tuple[Any, str]:
    """Return a running node and the address that it says."""
    node = start(*NODE, "-p", f"port:={port}", *words)
    line = node.wait_for("in a browser on this machine", 120.0)
    return node, re.search(r"http://\S+", line).group()


def floats(payload: bytes) -> np.ndarray:
    return np.frombuffer(payload, "<f4").reshape(-1, 2)


@pytest.fixture
def looked_at(start, peer):
    """Return a node, one who looks at it, and the robot's own nodes."""
    node, url = begin(start)
    looker = Looker(url)
    yield node, url, looker, Scene(peer, node)
    looker.close()


def parts(looker: Looker) -> dict[str, tuple[int, str]]:
    """Return level and words of all parts of nodes."""
    rows = looker.values("diagnostics").get("parts", [])
    return {row["name"]: (row["level"], row["message"]) for row in rows}


def problems(looker: Looker) -> list[str]:
    return looker.values("health").get("problems", [])


def goal_text(x: float, y: float, yaw: float) -> str:
    return f'{{"kind": "goal", "x": {x}, "y": {y}, "yaw": {yaw}}}'


def test_map_scan_and_pose_come_to_a_browser(looked_at) -> None:
    _, _, looker, scene = looked_at
    cells = room_cells()
    cells[7, 3] = -1
    scene.maps.publish(room(cells))
    looker.until(lambda: {"map", "scan"} <= set(looker.heard), scene.stand)
    head, png = looker.heard["map"]
    grey = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(grey[::-1].astype(int) - 1, cells)
    assert (head["origin"]["x"], head["resolution"]) == (CORNER, pytest.approx(0.1))
    looker.until(lambda: looker.values("pose")["pose"], scene.stand)
    assert looker.values("pose")["pose"] == {"x": 1.0, "y": 0.0, "yaw": 0.0}
    # The laser is at x = 1.5: a wall 2 m ahead of it, and one 1 m to its left.
    assert np.allclose(floats(looker.heard["scan"][1]), [[3.5, 0.0], [1.5, 1.0]], atol=TOL_M)


def test_a_map_is_sent_again_only_when_it_changed(looked_at) -> None:
    _, _, looker, scene = looked_at
    cells = room_cells()
    scene.maps.publish(room(cells))
    looker.until(lambda: looker.counts.get("map") == 1, scene.stand)
    for _ in range(5):
        scene.maps.publish(room(cells))
        scene.stand()
    cells[20, 20] = 100
    scene.maps.publish(room(cells))
    looker.until(lambda: looker.counts["map"] == 2, scene.stand)
    grey = cv2.imdecode(np.frombuffer(looker.heard["map"][1], np.uint8), cv2.IMREAD_UNCHANGED)
    assert grey[::-1][20, 20] == 101


def test_all_that_is_known_comes_to_who_looks_later(looked_at) -> None:
    node, url, looker, scene = looked_at
    scene.begin_all(node)
    kinds = {
        "info", "map", "glass", "scan", "pose", "path", "sonar", "markers", "planner",
        "diagnostics", "health", "image",
    }  # fmt: skip
    looker.until(lambda: kinds <= set(looker.heard), scene.say_all)
    looker.until(lambda: "/driver: motor" in parts(looker), scene.say_all)
    later = Looker(url)
    later.until(lambda: kinds <= set(later.heard))
    later.close()
    glass = cv2.imdecode(np.frombuffer(later.heard["glass"][1], np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(glass[::-1].astype(int) - 1, glass_cells())
    assert floats(later.heard["path"][1]).tolist() == [[1.0, 0.0], [1.0, 2.0], [3.5, 2.0]]
    groups = later.values("markers")["groups"]
    assert [(g["name"], g["num"]) for g in groups] == [("zones", 256), ("people", 256)]
    places = floats(later.heard["markers"][1])
    assert np.allclose(places[32:].min(axis=0), [2.2, 1.2], atol=TOL_M)  # around (2.5, 1.5) on map
    (cone,) = later.values("sonar")["cones"]
    assert (cone["x"], cone["reach"], cone["echo"]) == (0.5, pytest.approx(0.8), True)
    planner = later.values("planner")
    assert (planner["level"], planner["values"]["reason"]) == (1, "a person is on the way")
    assert parts(later)["/driver: motor"] == (2, "hot")
    jpeg = np.frombuffer(later.heard["image"][1], np.uint8)
    assert cv2.imdecode(jpeg, cv2.IMREAD_COLOR).shape == (40, 60, 3)


def test_a_click_becomes_a_goal_and_the_browser_hears_of_it(looked_at, peer) -> None:
    node, _, looker, scene = looked_at
    goals = peer.collect(PoseStamped, "/goal_pose", 10)
    node.wait_for("/goal_pose is sent to 2")  # to the test and to itself
    looker.say(goal_text(2.5, -1.0, math.pi / 2))
    looker.until(lambda: goals and looker.values("answer"), scene.stand)
    (goal,) = goals
    assert goal.header.frame_id == "map"
    assert (goal.pose.position.x, goal.pose.position.y) == (2.5, -1.0)
    assert goal.pose.orientation.z == pytest.approx(math.sin(math.pi / 4))
    assert looker.values("answer")["ok"] is True
    assert "(2.50, -1.00) sent on /goal_pose" in looker.values("answer")["text"]
    looker.until(lambda: looker.values("goal"), scene.stand)
    assert looker.values("goal")["yaw"] == pytest.approx(math.pi / 2, abs=1e-4)


def test_a_goal_that_nobody_listens_to_is_answered_so(looked_at) -> None:
    _, _, looker, scene = looked_at
    looker.say(goal_text(1.0, 1.0, 0.0))
    looker.until(lambda: looker.values("answer"), scene.stand)
    assert looker.values("answer")["ok"] is False
    assert "no planner listens" in looker.values("answer")["text"]


def test_pages_from_elsewhere_are_refused_nonsense_answered_and_a_goal_still_sent(
    looked_at, peer
) -> None:
    node, url, looker, scene = looked_at
    with pytest.raises(InvalidStatus) as refused:
        Looker(url, origin="http://evil.example")
    assert refused.value.response.status_code == 403
    goals = peer.collect(PoseStamped, "/goal_pose", 10)
    node.wait_for("/goal_pose is sent to 2")
    for text in ('{"kind": ', "[1, 2]", b"\xff\xfe", goal_text(1.0, 2.0, 0.0)[:-1] + ', "x": "a"}'):
        looker.heard.pop("answer", None)
        looker.say(text)
        looker.until(lambda: looker.values("answer"))
        assert looker.values("answer")["ok"] is False
    looker.say(goal_text(1.0, 2.0, 0.0))
    looker.until(lambda: goals, scene.stand)
    assert len(goals) == 1
    assert not node.has_ended
    assert "Traceback" not in node.text


def test_messages_that_cannot_be_drawn_are_named_and_the_node_lives(looked_at) -> None:
    node, _, looker, scene = looked_at
    bad = room(room_cells())
    bad.data = [0, 1, 2]
    scene.maps.publish(bad)
    told = "/map cannot be drawn: grid data must be 80 x 40 cells, got 3"
    looker.until(lambda: told in looker.values("health").get("problems", []), scene.stand)
    lost = room(room_cells(), frame="elsewhere")
    scene.maps.publish(lost)
    looker.until(lambda: "scan" in looker.heard, scene.stand)
    told = "what is in 'elsewhere' cannot be drawn: frame 'elsewhere' is not in the transform tree"
    looker.until(lambda: any(told in text for text in problems(looker)), scene.stand)
    assert "map" not in looker.heard
    scene.maps.publish(room(room_cells()))
    looker.until(lambda: "map" in looker.heard, scene.stand)
    looker.until(lambda: not looker.values("health")["problems"], scene.stand)
    assert not node.has_ended


def test_what_is_missing_is_said_and_who_should_send_it(looked_at, peer) -> None:
    _, _, looker, scene = looked_at
    looker.until(lambda: looker.values("health").get("problems"))
    looker.until(lambda: "waiting for /map: published by /test_peer" in problems(looker))
    assert any("no pose of the robot" in text for text in problems(looker))
    scene.maps.publish(room(room_cells()))
    looker.until(lambda: not problems(looker), scene.stand)
    looker.until(lambda: any("/scan is silent for" in text for text in problems(looker)))
    looker.until(lambda: any("pose is" in text and "s old" in text for text in problems(looker)))
    assert any("/test_peer" in text for text in problems(looker))


def test_pictures_and_markers_are_asked_for_only_while_somebody_looks(start, peer) -> None:
    node, url = begin(start)
    Scene(peer, node).begin_all(node)
    node.wait_for("/floor/overlay is heard from 1")
    topics = "/floor/overlay", "/planner/markers", "/scan", "/map"
    counts = lambda: [peer.node.count_subscribers(topic) for topic in topics]  # noqa: E731
    peer.spin_until(lambda: counts() == [0, 0, 0, 0])  # nobody has looked for a while
    looker = Looker(url)
    peer.spin_until(lambda: counts() == [1, 1, 1, 1])
    looker.until(lambda: "map" in looker.heard)  # latched: it comes again
    looker.close()
    peer.spin_until(lambda: counts() == [0, 0, 0, 0])


@pytest.mark.parametrize(
    ("prefix", "words"),
    [
        ("r2/", ("-p", "frame_prefix:=r2/")),
        ("", ("-r", "/tf:=tf", "-r", "/tf_static:=tf_static")),
    ],
    ids=["prefixed frames", "own TF topic"],
)
def test_a_robot_with_a_namespace_in_both_usual_ways(start, peer, prefix: str, words) -> None:
    node, url = begin(start, "-r", "__ns:=/r2", *words)
    scene = Scene(peer, node, "/r2", prefix, tf="/tf" if prefix else "/r2/tf")
    goals = peer.collect(PoseStamped, "/r2/goal_pose", 10)
    node.wait_for("/r2/goal_pose is sent to 2")
    looker = Looker(url)
    scene.maps.publish(room(room_cells(), f"{prefix}map"))
    looker.until(lambda: {"map", "scan", "info"} <= set(looker.heard), scene.stand)
    assert np.allclose(floats(looker.heard["scan"][1])[0], [3.5, 0.0], atol=TOL_M)
    assert looker.values("info")["robot"] == "/r2"
    looker.say(goal_text(1.0, 2.0, 0.0))
    looker.until(lambda: goals, scene.stand)
    assert goals[0].header.frame_id == f"{prefix}map"
    looker.close()


def test_a_port_that_is_taken_is_said_in_one_line(start) -> None:
    _, url = begin(start)
    port = url.rstrip("/").rpartition(":")[2]
    second = start(*NODE, "-p", f"port:={port}")
    assert second.wait_for_exit() == 2
    assert f"/live_view: port {port} cannot be had" in second.text
    assert "Traceback" not in second.text


def test_a_machine_without_the_server_library_is_told_in_one_line(
    start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "websockets.py").write_text("# an old one: it has no asyncio.server\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    node = start(*NODE)
    assert node.wait_for_exit(120.0) == 2
    assert "/live_view: the package websockets, 13 or newer, is not installed" in node.text
    assert "Traceback" not in node.text
