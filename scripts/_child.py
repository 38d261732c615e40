"""Run a command that ends when its starter does: `_child.py STARTER_PID COMMAND...`.

Even a starter that is killed outright leaves nobody behind: Linux then sends its children SIGTERM.
The wish is bound to the process, so it outlives the exec. Standard library only, no site packages.
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1


def main() -> None:
    """Ask for the signal, then become the command."""
    starter, *command = sys.argv[1:]
    prctl = getattr(ctypes.CDLL(None), "prctl", None)
    if prctl is not None:
        prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(starter):
        sys.exit("the starter ended first")
    os.execvp(command[0], command)


if __name__ == "__main__":
    main()
