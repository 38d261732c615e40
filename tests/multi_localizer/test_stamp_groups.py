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


def test_the_other_keys_are_not_waited_for_after_a_jump_back() -> None:
    groups = StampGroups(WAIT)
    groups.add("gone", 1000, 1, 0)
    groups.clear()
    assert groups.add("a", 10, 2, 1) == [(10, {"a": 2})]


def test_stamps_set_back_begin_a_new_order_after_some_moments() -> None:
    """Nobody says that the clock jumped: late values of moment after moment do."""
    groups, now_ns = StampGroups(WAIT), 0
    left: list[int] = []
    for stamp_ns in (*range(100_000, 101_000, 100), *range(1_000, 3_000, 100)):
        now_ns += 100
        for key in ("a", "b"):
            left += [stamp for stamp, _ in groups.add(key, stamp_ns, 0, now_ns)]
    assert left[-10:] == list(range(2_000, 3_000, 100))
    assert groups.num_late < 15


def test_what_is_always_late_does_not_begin_a_new_order() -> None:
    groups, left = StampGroups(WAIT), []
    for k in range(1, 50):
        left += groups.add("a", 100 * k, k, 100 * k)
        left += groups.overdue(100 * k + WAIT)
        left += groups.add("slow", 100 * (k - 1), k, 100 * k + WAIT)
    assert [stamp for stamp, _ in left] == [100 * k for k in range(1, 50)]
    assert all(set(group) == {"a"} for _, group in left)


def test_cameras_not_triggered_together_do_not_wait_for_each_other_for_long() -> None:
    groups, waited = StampGroups(WAIT), []
    for k in range(10):
        for key, skew in (("front", 0), ("rear", 13)):
            stamp = 1000 + 100 * k + skew
            left = groups.add(key, stamp, k, stamp)
            waited.append(not left or left[-1][0] != stamp)
    assert any(waited[:8]) and not any(waited[10:])


def test_what_comes_together_again_is_waited_for_again() -> None:
    groups = StampGroups(WAIT)
    for k in range(10):
        for key, skew in (("front", 0), ("rear", 13)):
            groups.add(key, 1000 + 100 * k + skew, k, 1000 + 100 * k + skew)
    assert groups.add("front", 3000, 1, 3000) == [(3000, {"front": 1})]
    assert groups.add("rear", 3000, 1, 3001) == []
    assert (groups.num_late, groups.num_parted) == (1, 1)
    assert groups.add("rear", 2990, 1, 3002) == []
    assert (groups.num_late, groups.num_parted) == (2, 1)
    assert groups.add("front", 3100, 2, 3100) == []
    assert groups.add("rear", 3100, 2, 3101) == [(3100, {"front": 2, "rear": 2})]
