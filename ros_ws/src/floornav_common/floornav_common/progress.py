"""Progress of a long command: a live bar on a terminal, plain lines now and then elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

_PLAIN_PERIOD_S = 5.0


def say(text: str, *, is_quiet: bool = False) -> None:
    """Print one line at once, unless quiet."""
    if not is_quiet:
        print(text, flush=True)


class Progress:
    """Show how far a task is; use it as a context manager.

    Args:
        title: What is being done.
        total: The amount that is all of it, in any unit; None if unknown.
        is_quiet: Show nothing.
    """

    def __init__(self, title: str, total: float | None = None, *, is_quiet: bool = False) -> None:
        self._title = title
        self._total = total
        self._is_quiet = is_quiet
        self._bar: Any = None
        self._task: Any = None
        self._next_line_at = 0.0
        self._last_line = ""

    def __enter__(self) -> Progress:
        if not self._is_quiet and sys.stdout.isatty():
            self._bar = _make_bar()
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task(self._title, total=self._total, note="")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update(self, done: float, note: str = "", *, is_last: bool = False) -> None:
        """Show the amount done so far and a short note beside it.

        Args:
            done: Amount in the unit of `total`.
            note: Text such as `12.3 m driven`.
            is_last: True prints the plain line even if one was printed just now.
        """
        if self._is_quiet:
            return
        if self._bar is not None:
            self._bar.update(self._task, completed=done, note=note)
            return
        line = f"{self._title}: {self._amount(done)}{note and '  ' + note}"
        if (is_last or time.monotonic() >= self._next_line_at) and line != self._last_line:
            self._next_line_at = time.monotonic() + _PLAIN_PERIOD_S
            self._last_line = line
            print(line, flush=True)

    def _amount(self, done: float) -> str:
        return f"{done:.0f}" if not self._total else f"{100.0 * done / self._total:3.0f} %"


def _make_bar() -> Any:
    try:
        from rich import progress
    except ImportError:
        return None
    return progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(bar_width=30),
        progress.TaskProgressColumn(),
        progress.TimeElapsedColumn(),
        progress.TextColumn("{task.fields[note]}"),
    )
