#!/usr/bin/env python3
"""Set up the environment and run the tests: `python3 scripts/test.py [pytest arguments]`.

Without arguments all tests run, in up to four processes; the exit code is pytest's.
"""

import os
import sys
from pathlib import Path

from _environment import ROOT, ensure_environment

MAX_WORKERS = 4  # each has a graph of nodes running at a time


def main() -> None:
    """Hand over to pytest in the checkout; paths on the command line are those of the caller."""
    if sys.argv[1:] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return
    ensure_environment(needs="node")
    words = [
        str(Path(word).absolute()) if Path(word.split("::")[0]).exists() else word
        for word in sys.argv[1:]
    ]
    os.chdir(ROOT)
    os.execv(sys.executable, [sys.executable, "-m", "pytest", *(words or _on_all_cores())])


def _on_all_cores() -> list[str]:
    """Return what spreads whole files of tests, so that what a file starts is started once.

    One worker more than cores: many tests wait for messages most of the time.
    """
    num = min(len(os.sched_getaffinity(0)) + 1, MAX_WORKERS)
    return ["--numprocesses", str(num), "--dist", "loadfile"]


if __name__ == "__main__":
    main()
