"""Messages of one moment, put together."""

from __future__ import annotations

from multi_localizer.stamp_groups import StampGroups

WAIT = 150


def test_a_group_leaves_when_all_usual_keys_are_there() -> None:
    groups = StampGroups(WAIT)
    assert groups.add("a", 10, 1, 0) == [(10, {"a": 1})]  # nothing else is known yet
    assert groups.add("b", 10, 2, 1) == [] and groups.num_late == 1
    assert groups.add("b", 20, 3, 10) == []
    assert groups.add("a", 20, 4, 11) == [(20, {"b": 3, "a": 4})]


def test_what_does_not_come_is_waited_for_and_then_not() -> None:
    groups = StampGroups(WAIT)
    groups.add("b", 0, 0, 0)
    assert groups.add("a", 10, 1, 100) == []
    assert groups.overdue(100 + WAIT - 1) == []
    assert groups.overdue(100 + WAIT) == [(10, {"a": 1})]


def test_older_groups_leave_before_a_complete_one() -> None:
    groups = StampGroups(WAIT)
    groups.add("b", 0, 0, 0)
    groups.add("a", 10, 1, 1)
    groups.add("a", 20, 2, 2)
    assert groups.add("b", 20, 3, 3) == [(10, {"a": 1}), (20, {"a": 2, "b": 3})]


def test_doubled_values_count_once() -> None:
    groups = StampGroups(WAIT)
    groups.add("b", 0, 0, 0)
    groups.add("a", 10, 1, 1)
    groups.add("a", 10, 9, 2)
    assert groups.add("b", 10, 2, 3) == [(10, {"a": 1, "b": 2})]


def test_a_key_long_silent_is_not_waited_for() -> None:
    groups = StampGroups(WAIT)
    groups.add("b", 0, 0, 0)
    assert groups.add("a", 20 * WAIT, 1, 1) == [(20 * WAIT, {"a": 1})]


def test_after_a_jump_back_all_begins_anew() -> None:
    groups = StampGroups(WAIT)
    groups.add("a", 1000, 1, 0)
    groups.clear()
    assert groups.add("a", 10, 2, 1) == [(10, {"a": 2})]


def test_what_waits_is_bounded() -> None:
    groups = StampGroups(WAIT)
    groups.add("b", 0, 0, 0)
    left = [g for k in range(1, 100) for g in groups.add("a", k, k, 0)]
    assert [stamp for stamp, _ in left] == list(range(1, 80))
