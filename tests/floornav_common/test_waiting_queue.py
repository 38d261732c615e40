"""Messages that wait in stamp order."""

from __future__ import annotations

from floornav_common.waiting_queue import StampOrder, WaitingQueue


def test_the_head_is_the_oldest_stamp_whatever_came_first() -> None:
    queue = WaitingQueue(10)
    for stamp in (30, 10, 20):
        queue.push(stamp, 0, f"m{stamp}")
    assert [queue.pop_head().msg for _ in range(3)] == ["m10", "m20", "m30"]
    assert queue.head is None


def test_equal_stamps_keep_their_order_and_need_not_compare() -> None:
    queue = WaitingQueue(10)
    queue.push(10, 0, {"a": 1})
    queue.push(10, 0, {"b": 2})
    assert queue.head is not None and queue.head.msg == {"a": 1}
    assert queue.pop_head().msg == {"a": 1}


def test_a_full_queue_pushes_the_oldest_stamp_out() -> None:
    queue = WaitingQueue(2)
    assert queue.push(10, 0, "a") == [] and queue.push(30, 0, "c") == []
    assert [w.msg for w in queue.push(20, 0, "b")] == ["a"]
    assert len(queue) == 2


def test_late_ones_leave_by_the_time_they_waited_not_by_their_stamp() -> None:
    queue = WaitingQueue(10)
    queue.push(50, 100, "early stamp, late arrival")
    queue.push(60, 0, "came first")
    assert [w.msg for w in queue.pop_late(81, 80)] == ["came first"]
    assert queue.pop_late(180, 80) == []
    assert len(queue.pop_late(181, 80)) == 1


def test_clear_empties() -> None:
    queue = WaitingQueue(10)
    queue.push(1, 0, "a")
    assert queue.clear() == 1 and len(queue) == 0


def test_stamps_in_order_and_equal_ones_follow_each_other() -> None:
    order = StampOrder(3)
    assert [order.is_next(stamp) for stamp in (10, 10, 20)] == [True, True, True]


def test_a_stamp_behind_the_newest_does_not_follow_and_changes_nothing() -> None:
    order = StampOrder(3)
    assert [order.is_next(stamp) for stamp in (10, 5, 9, 10, 5, 9)] == [
        True, False, False, True, False, False,
    ]  # fmt: skip


def test_many_behind_in_a_row_are_a_jump_back_that_begins_a_new_order() -> None:
    order = StampOrder(3)
    assert [order.is_next(stamp) for stamp in (10, 5, 6, 7, 8, 7)] == [
        True, False, False, True, True, False,
    ]  # fmt: skip


def test_after_a_restart_any_stamp_is_next() -> None:
    order = StampOrder(3)
    assert order.is_next(10)
    order.restart()
    assert order.is_next(1)
