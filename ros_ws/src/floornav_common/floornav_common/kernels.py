"""Compiles numba's kernels before they count: said while it takes long, by one process at a time.

numba keeps what it compiled on disk, so only the first start on a machine takes long. Processes
that start together would each compile the same: the first to begin locks the others out, which
then find most of it on disk.
"""

from __future__ import annotations

import fcntl
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path

_COMPILES = "numba:compile"  # the event of a kernel that was not on disk
_SAY_EVERY_S = 15.0


def compile_once(compile_kernels: Callable[[], None], name: str, say: Callable[[str], None]) -> int:
    """Run what makes numba compile: what is said is when it begins, how far it is, and the end.

    Nothing is said if all of it was compiled before.

    Args:
        compile_kernels: Calls the kernels.
        name: Of this set of kernels: processes with the same name wait for each other.
        say: Takes a line for the user.

    Returns:
        How many kernels had to be compiled.

    Raises:
        Whatever `compile_kernels` raises.
    """
    if "numba" not in sys.modules:
        compile_kernels()
        return 0
    event = import_module("numba.core.event")

    class Listener(event.Listener):  # type: ignore[name-defined, misc]
        num = 0
        begun = said = 0.0

        def on_start(self, _event: object) -> None:
            self.num += 1
            if self.num == 1:
                say("compiling its kernels: the first time on this machine, may take a minute")
                self.begun = self.said = time.monotonic()
                _lock(name, say, stack)
            elif time.monotonic() - self.said >= _SAY_EVERY_S:
                self.said = time.monotonic()
                say(f"still compiling: kernel {self.num}, {self.said - self.begun:.0f} s")

        def on_end(self, _event: object) -> None:
            pass

    listener = Listener()
    with ExitStack() as stack, event.install_listener(_COMPILES, listener):
        compile_kernels()
    if listener.num:
        say(f"kernels compiled in {time.monotonic() - listener.begun:.0f} s")
    return listener.num


def lock_path(name: str) -> Path:
    """Return the file that a process which compiles a set of kernels holds."""
    safe = re.sub(r"\W", "_", name)
    return Path(tempfile.gettempdir()) / f"floornav-kernels-{os.getuid()}-{safe}.lock"


def _lock(name: str, say: Callable[[str], None], stack: ExitStack) -> None:
    """Hold the lock until the stack ends; where there can be none, go on without."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
    try:
        descriptor = os.open(lock_path(name), flags, 0o600)
    except OSError:
        return
    stack.callback(os.close, descriptor)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        say("another process compiles them: waiting for it")
        fcntl.flock(descriptor, fcntl.LOCK_EX)
