"""Child processes of a script: started with a log each, watched, ended as whole groups.

They end with the script, also when that is killed outright.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

_PATIENCE_S = 8.0
_CHILD = str(Path(__file__).with_name("_child.py"))


class ChildDiedError(RuntimeError):
    """A child ended that should not have; the text names it, its exit code and its last lines."""


@dataclass
class _Child:
    process: subprocess.Popen[bytes]
    log: Path


class Processes:
    """A set of named child processes; leaving the `with` block ends those still running.

    Args:
        log_dir: Folder for `<name>.log`.
        environ: Their environment.
    """

    def __init__(self, log_dir: Path, environ: Mapping[str, str]) -> None:
        self._log_dir = log_dir
        self._environ = dict(environ)
        self._children: dict[str, _Child] = {}
        log_dir.mkdir(parents=True, exist_ok=True)

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop_all()

    def start(self, name: str, command: Sequence[str]) -> None:
        """Start a child in a process group of its own, so that Ctrl-C reaches only the script.

        To be called from the main thread: the child ends with the thread that started it.
        """
        log = self._log_dir / f"{name}.log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                [sys.executable, "-I", "-S", _CHILD, str(os.getpid()), *command],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=self._environ,
                start_new_session=True,
            )
        self._children[name] = _Child(process, log)

    def exit_code(self, name: str) -> int | None:
        """Return the exit code of a child, None while it runs."""
        return self._children[name].process.poll()

    @property
    def pids(self) -> dict[str, int]:
        """Process ids of the children that run, by name."""
        running = {n: c.process for n, c in self._children.items() if c.process.poll() is None}
        return {name: process.pid for name, process in running.items()}

    def check(self, may_end: Sequence[str] = ()) -> None:
        """Look after all children.

        Raises:
            ChildDiedError: One ended, other than with 0 and named in `may_end`.
        """
        for name in self._children:
            code = self.exit_code(name)
            if code is not None and not (code == 0 and name in may_end):
                ended = f"by signal {-code}" if code < 0 else f"with exit code {code}"
                raise ChildDiedError(f"{name} ended {ended}; its last lines:\n{self.tail(name)}")

    def wait_for_line(
        self, name: str, text: str, timeout: float, while_waiting: Callable[[], None]
    ) -> None:
        """Wait until a child's log holds a text.

        Raises:
            ChildDiedError: It ended or did not say so in time (s).
        """
        end = time.monotonic() + timeout
        log = self._children[name].log
        while text not in log.read_text(errors="replace"):
            self.check()
            if time.monotonic() > end:
                raise ChildDiedError(
                    f"{name} was not ready in {timeout:.0f} s; its last lines:\n{self.tail(name)}"
                )
            while_waiting()

    def tail(self, name: str, num_lines: int = 12) -> str:
        """Return the last lines of a child's log."""
        lines = self._children[name].log.read_text(errors="replace").splitlines()
        return "\n".join(f"  {line}" for line in lines[-num_lines:]) or "  (no output)"

    def stop(self, name: str) -> None:
        """End one child with all it started: SIGINT, then SIGTERM, then SIGKILL."""
        if self.exit_code(name) is None:
            _signal_group(self._children[name].process.pid, signal.SIGINT)
        self._wait(name)

    def stop_all(self) -> None:
        """End every child; all are asked at once, so that this takes as long as the slowest."""
        for name, child in self._children.items():
            if self.exit_code(name) is None:
                _signal_group(child.process.pid, signal.SIGINT)
        for name in self._children:
            self._wait(name)

    def _wait(self, name: str) -> None:
        """Wait for a child that was asked to end, then be less polite."""
        process = self._children[name].process
        for patience, signum in ((_PATIENCE_S, signal.SIGTERM), (2.0, signal.SIGKILL)):
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(patience)
                break
            _signal_group(process.pid, signum)
        process.wait()
        _signal_group(process.pid, signal.SIGKILL)  # what it left behind


def _signal_group(pid: int, signum: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signum)


def free_domain() -> int:
    """Return a ROS domain on which nobody discovers, so that a run mixes with no other graph."""
    first = os.getpid() % 100
    for domain in (1 + (first + k) % 100 for k in range(100)):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("127.0.0.1", 7400 + 250 * domain + 10))
            except OSError:
                continue
            return domain
    return 1 + first
