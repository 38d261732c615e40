"""Who may talk to the live view, what may be asked for, and what waits for a slow browser."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.live_view.commands import goal_of
from floornav_common.live_view.origins import refusal
from floornav_common.live_view.outbox import Outbox


@pytest.mark.parametrize("host", ["127.0.0.1:8765", "localhost:8765", "[::1]:8765", "localhost"])
def test_this_machine_by_any_of_its_names_is_let_in(host: str) -> None:
    assert refusal(host, None) == ""
    assert refusal(host, f"http://{host}") == ""


def test_another_port_is_let_in_as_ssh_forwards_it() -> None:
    assert refusal("localhost:9000", "http://localhost:9000") == ""


@pytest.mark.parametrize(
    "host",
    [
        None, "", "evil.example", "evil.example:8765", "127.0.0.1.evil.example", "localhost.",
        "evil@127.0.0.1", "127.0.0.1/x", "127.0.0.1:x", "0.0.0.0:8765", "192.168.1.2:8765",
    ],
)  # fmt: skip
def test_a_name_that_is_not_this_machines_is_refused(host: str | None) -> None:
    """DNS rebinding: a page's own name leads here, and stays in the header."""
    assert "Host must be" in refusal(host, None)


@pytest.mark.parametrize(
    "origin",
    [
        "https://evil.example", "http://127.0.0.1:9999", "https://127.0.0.1:8765", "null", "",
        "http://localhost:8765", "http://127.0.0.1:8765.evil.example",
    ],
)  # fmt: skip
def test_a_page_from_elsewhere_is_refused(origin: str) -> None:
    assert "Origin must be" in refusal("127.0.0.1:8765", origin)


def test_a_goal_is_a_pose_in_the_map_frame() -> None:
    goal = goal_of('{"kind": "goal", "x": 1, "y": -2.5, "yaw": 0.5}')
    assert (goal.x, goal.y, goal.yaw) == (1.0, -2.5, 0.5)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "must be JSON"),
        ("", "must be JSON"),
        ("[" * 100_000, "must be JSON"),
        ("[]", "must be"),
        ("null", "must be"),
        ('{"kind": "drive"}', "must be"),
        ('{"kind": "goal", "x": 1, "y": 2}', "yaw must be a number"),
        ('{"kind": "goal", "x": true, "y": 2, "yaw": 0}', "x must be a number"),
        ('{"kind": "goal", "x": "1", "y": 2, "yaw": 0}', "x must be a number"),
        ('{"kind": "goal", "x": NaN, "y": 2, "yaw": 0}', "x must be finite"),
        ('{"kind": "goal", "x": 1e999, "y": 2, "yaw": 0}', "x must be finite"),
        ('{"kind": "goal", "x": 1, "y": 1e6, "yaw": 0}', "within"),
        (b"\x00\x01", "must be text"),
    ],
)
def test_what_is_no_goal_is_refused_with_a_reason(text: str | bytes, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        goal_of(text)


def test_an_integer_that_no_float_holds_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        goal_of('{"kind": "goal", "x": 1' + "0" * 400 + ', "y": 0, "yaw": 0}')


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


@given(st.dictionaries(st.sampled_from(["kind", "x", "y", "yaw"]), JSON | st.just("goal")))
def test_whatever_comes_is_a_goal_or_a_reason(message: dict[str, object]) -> None:
    try:
        goal = goal_of(json.dumps(message))
    except ValueError as error:
        assert str(error)
    else:
        assert message["kind"] == "goal"
        assert (goal.x, goal.y) == (message["x"], message["y"])


def test_a_newer_message_takes_the_place_of_one_not_yet_sent() -> None:
    box = Outbox()
    for slot, message in (("map", "m1"), ("scan", "s1"), ("map", "m2"), ("scan", "s2")):
        box.put(slot, message)
    assert box.num_dropped == 2
    assert [box.take(), box.take(), box.take()] == [("map", "m2"), ("scan", "s2"), None]


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers())))
def test_no_more_waits_than_there_are_slots_and_the_newest_of_each_comes_out(
    puts: list[tuple[str, int]],
) -> None:
    box = Outbox()
    for slot, number in puts:
        box.put(slot, str(number))
    assert len(box) <= 3
    taken = dict(iter(box.take, None))
    assert taken == {slot: str(number) for slot, number in puts}
    assert box.num_dropped + len(taken) == len(puts)
