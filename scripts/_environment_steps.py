"""Say what a set-up does and how long it takes.

Standard library only, and syntax that Python 3.9 reads.
"""

import sys
import time
from contextlib import contextmanager


@contextmanager
def step(name):
    """Say what is done and how long it took; yields a function that shows progress in between."""
    start = time.monotonic()
    is_screen = sys.stderr.isatty()
    shown = [start]

    def report(text):
        now = time.monotonic()
        if is_screen:
            sys.stderr.write(f"\r\033[K  {name}: {text} ({now - start:.0f} s)")
            sys.stderr.flush()
        elif now - shown[0] > 20:
            shown[0] = now
            say(f"  {name}: {text} ({now - start:.0f} s)")

    report("...")
    try:
        yield report
    finally:
        if is_screen:
            sys.stderr.write("\r\033[K")
    say(f"  {name}: {time.monotonic() - start:.0f} s")


def say(text):
    """Tell the user; on stderr, so that results on stdout stay clean."""
    print(f"floornav: {text}", file=sys.stderr, flush=True)
