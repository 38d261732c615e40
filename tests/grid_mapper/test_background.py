"""Work in another process: answers come back, its end is said, nobody waits for it."""

import io
import os
import time

import numpy as np
import pytest

from grid_mapper.background import InlineWorker, ProcessWorker
from grid_mapper.background_side import TAKEN_A_STEP, read_message, serve, write_message


class Adding:
    """Sums what it is given; answers in a step of its own, and ends its process at a negative."""

    def __init__(self, start):
        self._sum, self._has_news = start, False

    def take(self, message):
        if message < 0:
            os._exit(3)
        self._sum, self._has_news = self._sum + message, True
        print("what is printed hurts nobody")
        return ("took", message)

    @property
    def has_work(self):
        return self._has_news

    def work(self):
        self._has_news = False
        return ("sum", self._sum)


class Endless:
    """Always has work, and says at each step how much it was given."""

    has_work = True

    def __init__(self):
        self._num = 0

    def take(self, message):
        self._num += 1

    def work(self):
        return self._num


class Sleepy:
    """Takes a while for each message."""

    has_work = False

    def take(self, message):
        time.sleep(0.2)
        return message


class Broken:
    """Comes apart where it is read."""

    def __reduce__(self):
        return (int, ("none",))


class Unreadable:
    """Answers with what cannot be read."""

    has_work = False

    def take(self, message):
        return Broken()


def wait_for(condition):
    until = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.fixture
def worker():
    worker = ProcessWorker(Adding, 5)
    yield worker
    worker.close()


def answers(worker, num):
    found = []

    def has_all():
        while (answer := worker.receive()) is not None:
            found.append(answer)
        return len(found) >= num

    wait_for(has_all)
    return found


def test_the_process_answers_as_the_work_does_here(worker):
    inline = InlineWorker(Adding(5))
    for number in (1, 2):
        inline.send(number)
        worker.send(number)
        expected = [("took", number), ("sum", 5 + (1 if number == 1 else 3))]
        assert [inline.receive(), inline.receive(), inline.receive()] == [*expected, None]
        assert answers(worker, 2) == expected
    assert worker.failure == ""


def test_a_process_that_ends_by_itself_is_said_and_sending_goes_on(worker):
    worker.send(-1)
    wait_for(lambda: bool(worker.failure))
    worker.send(1)
    assert "code 3" in worker.failure and worker.receive() is None


def test_closing_is_no_failure():
    worker = ProcessWorker(Adding, 0)
    worker.send(1)
    worker.close()
    assert worker.failure == ""


def test_work_goes_on_while_messages_come_and_messages_are_taken_while_there_is_work():
    source, sink = io.BytesIO(), io.BytesIO()
    write_message(source, (Endless, ()))
    for _ in range(3 * TAKEN_A_STEP):
        write_message(source, 1)
    source.seek(0)
    serve(source, sink)
    sink.seek(0)
    steps = iter(lambda: read_message(sink), None)
    assert max(np.diff([0, *steps, 3 * TAKEN_A_STEP])) <= TAKEN_A_STEP


def test_a_worker_that_died_begins_anew(worker):
    worker.send(-1)
    wait_for(lambda: worker.failure)
    worker.begin_anew()
    assert worker.failure == ""
    worker.send(2)
    assert answers(worker, 2) == [("took", 2), ("sum", 7)]


def test_one_that_never_gets_through_what_it_was_sent_begins_anew_at_once():
    worker = ProcessWorker(Sleepy)
    for k in range(10_000):
        worker.send(k)
    assert answers(worker, 1) == [0]
    worker.begin_anew()
    worker.send(-5)
    assert answers(worker, 1) == [-5] and worker.failure == ""
    worker.close()


def test_an_answer_that_cannot_be_read_is_a_failure():
    worker = ProcessWorker(Unreadable)
    worker.send(1)
    wait_for(lambda: worker.failure)
    assert "cannot be read" in worker.failure
    worker.close()
