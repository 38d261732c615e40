"""Say what takes long, again and again, so that a user need not wonder whether it goes on."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from floornav_common.reporting import say

PERIOD_S = 8.0


@contextmanager
def saying(text: str, *, is_quiet: bool, period: float = PERIOD_S) -> Iterator[None]:
    """Say a text at once and each `period` (s) until the block is left.

    A thread says it: the block may compute without a break.
    """
    started, done = time.monotonic(), threading.Event()

    def repeat() -> None:
        while not done.wait(period):
            say(f"{text} ({time.monotonic() - started:.0f} s)", is_quiet=is_quiet)

    say(text, is_quiet=is_quiet)
    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
