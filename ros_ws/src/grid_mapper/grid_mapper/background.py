"""Work in a process of its own, so that it holds nobody up: messages in, answers out, by pipes."""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import Any, Protocol

from grid_mapper.background_side import read_data, write_message

END_TIMEOUT_S = 2.0


class Work(Protocol):
    """What is done in the background."""

    def take(self, message: Any) -> Any | None:
        """Take a message; return an answer or None."""
        ...

    @property
    def has_work(self) -> bool:
        """Whether `work` would do anything."""
        ...

    def work(self) -> Any | None:
        """Do a small step of what there is to do; return an answer or None."""
        ...


class Worker(Protocol):
    """Where work is done."""

    def send(self, message: Any) -> None:
        """Hand a message over; returns at once."""
        ...

    def receive(self) -> Any | None:
        """Return the next answer; None while there is none."""
        ...

    @property
    def failure(self) -> str:
        """Why nothing is done any more; "" while all is well."""
        ...

    @property
    def longest_read_ms(self) -> float:
        """The longest that an answer took to be read: meanwhile no other thread goes on."""
        ...

    def begin_anew(self) -> None:
        """Give up what is being done and all that was sent; work made anew takes what comes."""
        ...

    def close(self) -> None:
        """End it."""
        ...


class InlineWorker:
    """Does all work at once, where it is sent: for runs that have to come out the same."""

    failure, longest_read_ms = "", 0.0

    def __init__(self, work: Work) -> None:
        self._work = work
        self._answers: deque[Any] = deque()

    def send(self, message: Any) -> None:
        """Do all that the message asks for."""
        self._answer(self._work.take(message))
        while self._work.has_work:
            self._answer(self._work.work())

    def receive(self) -> Any | None:
        """Return the next answer."""
        return self._answers.popleft() if self._answers else None

    def begin_anew(self) -> None:
        """Do nothing: here work never ends, and is never behind."""

    def close(self) -> None:
        """Do nothing."""

    def _answer(self, answer: Any | None) -> None:
        if answer is not None:
            self._answers.append(answer)


class ProcessWorker:
    """Runs work in another process of the same Python.

    Args:
        make_work: Makes the work over there: a function or class of a module.
        args: For it.
    """

    def __init__(self, make_work: Callable[..., Work], *args: Any) -> None:
        self._first = make_work, args
        self._side = _OtherSide(self._first)

    @property
    def failure(self) -> str:
        """Why nothing is done any more; "" while all is well."""
        return self._side.failure

    @property
    def longest_read_ms(self) -> float:
        """The longest that an answer took to be read."""
        return self._side.longest_read_ms

    def send(self, message: Any) -> None:
        """Hand a message over; a thread of its own writes it."""
        self._side.messages.put(message)

    def receive(self) -> Any | None:
        """Return the next answer; None while there is none."""
        answers = self._side.answers
        return answers.popleft() if answers else None

    def begin_anew(self) -> None:
        """End the process in the middle of its work, and start another; returns at once."""
        self._side.kill()
        self._side = _OtherSide(self._first)

    def close(self) -> None:
        """End the process."""
        self._side.close()


class _OtherSide:
    """A process, and the threads that write to it and read from it.

    Args:
        first: The first message, which names the work.
    """

    def __init__(self, first: Any) -> None:
        self.failure, self.longest_read_ms = "", 0.0
        self.answers: deque[Any] = deque()
        self.messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._is_closing = False
        path = os.pathsep.join(entry for entry in sys.path if entry)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "grid_mapper.background_side"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
        self.messages.put(first)
        self._threads = [
            Thread(target=run, name="background", daemon=True)
            for run in (self._send_all, self._receive_all)
        ]
        for thread in self._threads:
            thread.start()

    def kill(self) -> None:
        """End it now, whatever it does; the threads end by that."""
        self._is_closing = True
        self._process.kill()
        self.messages.put(None)

    def close(self) -> None:
        """End it at the end of what it was sent, or after a while."""
        self._is_closing = True
        self.messages.put(None)
        try:
            self._process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for thread in self._threads:
            thread.join(END_TIMEOUT_S)

    def _send_all(self) -> None:
        stream = self._process.stdin
        assert stream is not None
        # Where the other side has ended, the receiving thread says so.
        with suppress(OSError, ValueError), stream:
            while (message := self.messages.get()) is not None:
                write_message(stream, message)

    def _receive_all(self) -> None:
        failure = ""
        try:
            self._read_all()
        except Exception as error:
            failure = f"an answer of the background cannot be read: {error!r}"
            self._process.kill()
        code = self._process.wait()
        if not self._is_closing:
            self.failure = failure or f"the process in the background has ended with code {code}"

    def _read_all(self) -> None:
        stream = self._process.stdout
        assert stream is not None
        with stream:
            while (data := read_data(stream)) is not None:
                started = time.thread_time()
                self.answers.append(pickle.loads(data))
                took_ms = 1e3 * (time.thread_time() - started)
                self.longest_read_ms = max(self.longest_read_ms, took_ms)
