"""A thread for work that may take longer than until more of it comes: the newest is done next."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock

Job = Callable[[], None]


class NewestWorker:
    """Does one thing after the other.

    Args:
        name: Of the thread.

    Attributes:
        num_passed_over: Offers that were not taken, because a newer one came before their turn.
    """

    def __init__(self, name: str) -> None:
        self.num_passed_over = 0
        self._thread = ThreadPoolExecutor(1, name)
        self._lock = Lock()
        self._offer: Job | None = None
        self._last: list[Future[None]] = []

    def do(self, job: Job) -> None:
        """Do a job after all that was asked for before; of offers, the one that waits."""
        self._last = [f for f in self._last if not f.done() or f.exception() is not None]
        self._last.append(self._thread.submit(job))

    def offer(self, job: Job) -> None:
        """Do a job, unless a newer offer comes before its turn."""
        with self._lock:
            is_waiting, self._offer = self._offer is not None, job
            self.num_passed_over += is_waiting
        if not is_waiting:
            self.do(self._take)

    def withdraw(self) -> None:
        """Take back the offer that waits."""
        with self._lock:
            self._offer = None if self._offer is None else _nothing

    def check(self) -> None:
        """Raise what a job raised."""
        for done in [f for f in self._last if f.done()]:
            done.result()

    def close(self) -> None:
        """Drop what waits, and wait for what is being done."""
        self._thread.shutdown(cancel_futures=True)

    def _take(self) -> None:
        with self._lock:
            job, self._offer = self._offer, None
        if job is not None:
            job()


def _nothing() -> None:
    """Do nothing."""
