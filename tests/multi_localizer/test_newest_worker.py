from threading import Event

import pytest

from multi_localizer.newest_worker import NewestWorker

WAIT_S = 60.0


@pytest.fixture
def worker():
    worker = NewestWorker("test")
    yield worker
    worker.close()


def test_of_offers_that_wait_the_newest_is_done(worker):
    begun, go_on, done = Event(), Event(), []

    def long() -> None:
        begun.set()
        go_on.wait(WAIT_S)
        done.append("long")

    worker.offer(long)
    assert begun.wait(WAIT_S)
    for name in ("old", "older", "newest"):
        worker.offer(lambda name=name: done.append(name))
    go_on.set()
    worker.close()
    assert done in (["long", "newest"], ["long"])  # closing drops what waits
    assert worker.num_passed_over == 2


def test_all_that_must_be_done_is_done_in_order(worker):
    done, last = [], Event()
    for k in range(5):
        worker.do(lambda k=k: done.append(k))
    worker.offer(last.set)
    assert last.wait(WAIT_S)
    assert done == [0, 1, 2, 3, 4]


def test_what_is_withdrawn_is_not_done_and_the_next_offer_is(worker):
    begun, go_on, last, done = Event(), Event(), Event(), []
    worker.offer(lambda: (begun.set(), go_on.wait(WAIT_S)))
    assert begun.wait(WAIT_S)
    worker.offer(lambda: done.append("withdrawn"))
    worker.withdraw()
    worker.offer(last.set)
    go_on.set()
    assert last.wait(WAIT_S)
    assert not done


def test_what_goes_wrong_in_the_thread_is_raised_where_it_is_asked(worker):
    failed, last = Event(), Event()

    def fail() -> None:
        failed.set()
        raise ValueError("no such view")

    worker.offer(fail)
    assert failed.wait(WAIT_S)
    worker.offer(last.set)
    assert last.wait(WAIT_S)
    with pytest.raises(ValueError, match="no such view"):
        worker.check()
