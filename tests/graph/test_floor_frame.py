"""When the floor frame is sent: a clock and a graph by hand, no DDS."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import pytest
from painted_floors import upright_camera

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")

from builtin_interfaces.msg import Time

from floor_perception.nodes import floor_frame
from floor_perception.nodes.floor_frame import FloorFrame
from floornav_common.transform3 import Transform3

WAIT_S = 7.0


class Graph:
    """A node whose time, /tf_static and log are set and read by hand."""

    def __init__(self) -> None:
        self.seconds, self.num_senders, self.is_known = 0.0, 0, False
        self.place = Transform3.identity()
        self.said: list[str] = []
        self.warned: list[str] = []
        self.sent: list[tuple[str, str]] = []
        looks: list[Callable[[], None]] = []
        self.node = SimpleNamespace(
            time=SimpleNamespace(
                on_look=looks.append, steady_ns=lambda: int(1e9 * (100.0 + self.seconds))
            ),
            transforms=SimpleNamespace(
                buffer=SimpleNamespace(
                    can_transform=lambda *frames: self.is_known, lookup=lambda *frames: self.place
                )
            ),
            frames=SimpleNamespace(base="base_link"),
            count_publishers=lambda topic: self.num_senders,
            get_logger=lambda: SimpleNamespace(info=self.said.append, warning=self.warned.append),
            get_clock=lambda: SimpleNamespace(now=lambda: SimpleNamespace(to_msg=Time)),
        )
        FloorFrame(self.node, "omni_camera_floor", upright_camera(), WAIT_S)
        (self._look,) = looks

    def at(self, seconds: float) -> Graph:
        """Look at a time after the start, s."""
        self.seconds = seconds
        self._look()
        return self


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    made = Graph()

    def send(parent: str, child: str, *rest: object) -> None:
        made.sent.append((parent, child))

    broadcaster = SimpleNamespace(send=send)
    monkeypatch.setattr(floor_frame, "StaticTransformBroadcaster", lambda node: broadcaster)
    return made


def test_nobody_sends_it_so_it_is_sent_once_after_the_wait(graph: Graph) -> None:
    graph.at(0.0).at(WAIT_S - 0.1)
    assert graph.sent == []
    graph.at(WAIT_S).at(WAIT_S + 0.1).at(60.0)
    assert graph.sent == [("base_link", "omni_camera_floor")]


def test_a_sender_that_comes_begins_the_wait_anew_and_one_that_goes_does_not(graph: Graph) -> None:
    graph.at(0.0)
    graph.num_senders = 2
    graph.at(5.0)
    graph.num_senders = 1
    graph.at(6.0).at(5.0 + WAIT_S - 0.1)
    assert graph.sent == []
    graph.at(5.0 + WAIT_S)
    assert len(graph.sent) == 1


def test_what_the_description_sends_is_left_alone_for_good(graph: Graph) -> None:
    graph.at(0.0)
    graph.num_senders = 1
    graph.at(1.0)
    graph.is_known = True
    graph.at(1.1)
    graph.is_known = False
    graph.at(60.0)
    assert graph.sent == []
    (said,) = graph.said
    assert said.startswith("base_link -> omni_camera_floor is sent by the robot's description")


def test_a_second_sender_is_warned_of_once_if_it_says_another_place(graph: Graph) -> None:
    graph.at(0.0).at(WAIT_S)
    x, y = upright_camera().position_m
    graph.is_known, graph.place = True, Transform3.from_parts((x, y, 0.0), (0.0, 0.0, 0.0, 1.0))
    graph.at(20.0)
    assert graph.warned == []
    graph.place = Transform3.from_parts((x - 0.1, y, 0.0), (0.0, 0.0, 0.0, 1.0))
    graph.at(21.0).at(22.0)
    (warned,) = graph.warned
    assert "is also sent by somebody else" in warned
