"""Ctrl-C and SIGTERM as a question that a loop asks, instead of an exception anywhere in it.

`noticed_stop` is for a block of code, `StopSignals` for a process of which only one part may be
interrupted.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_AGAIN_S = 0.05


class StopSignals:
    """Catches SIGINT and SIGTERM from now on, for good; outside the main thread they never come.

    Attributes:
        have_come: Whether one came.
    """

    def __init__(self) -> None:
        """Replace the handlers of before."""
        self.have_come = False
        self._is_raised = self._is_lost = False
        if threading.current_thread() is threading.main_thread():
            for signum in _SIGNALS:
                signal.signal(signum, self._on_signal)

    @contextmanager
    def raised(self) -> Iterator[None]:
        """Raise KeyboardInterrupt inside the block at the first signal, and only at that one.

        One that came before the block is raised at once. One that is lost where Python cannot pass
        an exception on (`__del__` of what a compiler leaves behind) is raised again, not printed;
        nor is what fails in such places because of it, to the end of the process.
        """
        before = sys.unraisablehook

        def on_lost(lost: sys.UnraisableHookArgs) -> None:
            if not self.have_come:
                before(lost)
            elif lost.exc_type is KeyboardInterrupt and not self._is_lost:
                self._is_lost = True
                threading.Timer(_AGAIN_S, self._send_again).start()

        self._is_raised, sys.unraisablehook = True, on_lost
        try:
            if self.have_come:
                raise KeyboardInterrupt
            yield
        finally:
            self._is_raised = False
            if not self.have_come:
                sys.unraisablehook = before

    def _send_again(self) -> None:
        main = threading.main_thread().ident
        if self._is_raised and main is not None:
            signal.pthread_kill(main, signal.SIGINT)

    def _on_signal(self, signum: int, frame: FrameType | None) -> None:
        is_first, self.have_come = not self.have_come, True
        if (is_first or self._is_lost) and self._is_raised:
            self._is_lost = False
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
