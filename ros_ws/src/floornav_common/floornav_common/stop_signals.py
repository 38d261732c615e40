"""Ctrl-C and SIGTERM as a question that a loop asks, instead of an exception anywhere in it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def noticed_stop() -> Iterator[Callable[[], bool]]:
    """Notice SIGINT and SIGTERM inside the block; a second one raises KeyboardInterrupt.

    An exception that a signal raises inside compiled code comes out of it as a SystemError, or
    leaves half a result behind. Outside the main thread signals never come, and nothing changes.

    Yields:
        A function that tells whether a signal came.
    """
    came: list[int] = []

    def notice(signum: int, frame: FrameType | None) -> None:
        if came:
            raise KeyboardInterrupt
        came.append(signum)

    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before = {s: signal.signal(s, notice) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(came)
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)
