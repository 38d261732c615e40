"""Work in a process of its own, so that it holds nobody up: messages in, answers out, by pipes.

Run as `python -m grid_mapper.background` it is the other side. It ends when its input does, so it
outlives nobody who was killed; it leaves Ctrl-C to the one who started it.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import IO, Any, Protocol

NICENESS = 5
END_TIMEOUT_S = 2.0
TAKEN_A_STEP = 20
"""Messages taken between two steps of work: neither waits for the other for ever."""
_LENGTH_BYTES = 8
_NOTHING = object()


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
        self.failure, self.longest_read_ms = "", 0.0
        self._is_closing = False
        self._answers: deque[Any] = deque()
        self._messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
        path = os.pathsep.join(entry for entry in sys.path if entry)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "grid_mapper.background"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
        self._messages.put((make_work, args))
        self._threads = [
            Thread(target=run, name="background", daemon=True)
            for run in (self._send_all, self._receive_all)
        ]
        for thread in self._threads:
            thread.start()

    def send(self, message: Any) -> None:
        """Hand a message over; a thread of its own writes it."""
        self._messages.put(message)

    def receive(self) -> Any | None:
        """Return the next answer; None while there is none."""
        return self._answers.popleft() if self._answers else None

    def close(self) -> None:
        """End the process."""
        self._is_closing = True
        self._messages.put(None)
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
            while (message := self._messages.get()) is not None:
                write_message(stream, message)

    def _receive_all(self) -> None:
        stream = self._process.stdout
        assert stream is not None
        with stream:
            while (data := _read_data(stream)) is not None:
                started = time.thread_time()
                self._answers.append(pickle.loads(data))
                took_ms = 1e3 * (time.thread_time() - started)
                self.longest_read_ms = max(self.longest_read_ms, took_ms)
        code = self._process.wait()
        if not self._is_closing:
            self.failure = f"the process in the background has ended with code {code}"


def write_message(stream: IO[bytes], message: Any) -> None:
    """Write one message."""
    data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(len(data).to_bytes(_LENGTH_BYTES, "little"))
    stream.write(data)
    stream.flush()


def read_message(stream: IO[bytes]) -> Any | None:
    """Return the next message; None at the end."""
    data = _read_data(stream)
    return None if data is None else pickle.loads(data)


def _read_data(stream: IO[bytes]) -> bytes | None:
    head = stream.read(_LENGTH_BYTES)
    if len(head) < _LENGTH_BYTES:
        return None
    size = int.from_bytes(head, "little")
    data = stream.read(size)
    return data if len(data) == size else None


def serve(source: IO[bytes], sink: IO[bytes]) -> None:
    """Make the work that the first message names, and do it until the messages end."""
    first = read_message(source)
    if first is None:
        return
    make_work, args = first
    work: Work = make_work(*args)
    messages: queue.SimpleQueue[Any] = queue.SimpleQueue()
    Thread(target=_read_all, args=(source, messages), daemon=True).start()
    num_taken = 0
    while True:
        message = _NOTHING
        if not work.has_work or num_taken < TAKEN_A_STEP:
            with suppress(queue.Empty):
                message = messages.get(block=not work.has_work)
        if message is None:
            return
        if message is _NOTHING:
            num_taken, answer = 0, work.work()
        else:
            num_taken, answer = num_taken + 1, work.take(message)
        if answer is not None:
            write_message(sink, answer)


def _read_all(source: IO[bytes], messages: queue.SimpleQueue[Any]) -> None:
    while (message := read_message(source)) is not None:
        messages.put(message)
    messages.put(None)


def main() -> None:
    """Serve over standard input and output; what is printed goes to standard error."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    os.nice(NICENESS)
    with os.fdopen(os.dup(1), "wb") as sink:
        os.dup2(2, 1)
        try:
            serve(sys.stdin.buffer, sink)
        except BrokenPipeError:
            os._exit(0)  # nobody listens any more
        sink.flush()
    os._exit(0)  # the reading thread may be in the middle of a read


if __name__ == "__main__":
    main()
