"""Messages that wait in stamp order."""

from __future__ import annotations

from floornav_common.waiting_queue import WaitingQueue


def test_the_head_is_the_oldest_stamp_whatever_came_first() -> None:
    queue = WaitingQueue(10)
    for stamp in (30, 10, 20):
        queue.push(stamp, 0, f"m{stamp}")
    heads = [queue.pop_head(lambda w: True) for _ in range(3)]
    assert [w.msg for w in heads if w] == ["m10", "m20", "m30"]
    assert queue.pop_head(lambda w: True) is None


def test_a_head_that_is_not_ready_holds_the_others() -> None:
    queue = WaitingQueue(10)
    queue.push(10, 0, "a")
    queue.push(20, 0, "b")
    assert queue.pop_head(lambda w: w.stamp_ns > 10) is None
    assert len(queue) == 2


def test_equal_stamps_keep_their_order_and_need_not_compare() -> None:
    queue = WaitingQueue(10)
    queue.push(10, 0, {"a": 1})
    queue.push(10, 0, {"b": 2})
    first = queue.pop_head(lambda w: True)
    assert first is not None and first.msg == {"a": 1}


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
