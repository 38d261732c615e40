"""Ctrl-C and SIGTERM as a question that a loop asks, instead of an exception anywhere in it.

`noticed_stop` is for a block of code, `StopSignals` for a process of which only one part may be
interrupted.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """Catches SIGINT and SIGTERM from now on, for good; outside the main thread they never come.

    Attributes:
        have_come: Whether one came.
    """

    def __init__(self) -> None:
        """Replace the handlers of before."""
        self.have_come = False
        self._is_raised = False
        if threading.current_thread() is threading.main_thread():
            for signum in _SIGNALS:
                signal.signal(signum, self._on_signal)

    @contextmanager
    def raised(self) -> Iterator[None]:
        """Raise KeyboardInterrupt inside the block at the first signal, and only at that one.

        One that came before the block is raised at once.
        """
        self._is_raised = True
        try:
            if self.have_come:
                raise KeyboardInterrupt
            yield
        finally:
            self._is_raised = False

    def _on_signal(self, signum: int, frame: FrameType | None) -> None:
        is_first, self.have_come = not self.have_come, True
        if is_first and self._is_raised:
            raise KeyboardInterrupt


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
    before = {s: signal.signal(s, notice) for s in _SIGNALS}
    try:
        yield lambda: bool(came)
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)
