"""A node as a process of its own, with all it says."""

from __future__ import annotations

import signal
import subprocess
import threading
import time

import pytest

EVENTUALLY_S = 60.0  # what must come at last, on a slow and busy machine too
ENDING_S = 20.0  # for a node to end by itself, before it is killed


class NodeProcess:
    """A node that runs in a process of its own; its output is kept line by line."""

    def __init__(self, command: list[str], env: dict[str, str], stdin: int | None = None) -> None:
        """Start it."""
        self.process = subprocess.Popen(
            command, env=env, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True,
        )  # fmt: skip
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def text(self) -> str:
        """All it has said so far."""
        return "\n".join(self.lines)

    @property
    def has_ended(self) -> bool:
        """Whether it has, and all it said was read."""
        if self.process.poll() is None:
            return False
        self._reader.join(EVENTUALLY_S)
        return True

    def wait_for(self, words: str, timeout: float = EVENTUALLY_S) -> str:
        """Return the first line that holds words; fails with all it said if none comes."""
        end = time.monotonic() + timeout
        is_last = False
        while not is_last:
            is_last = time.monotonic() > end or self.has_ended
            for line in list(self.lines):
                if words in line:
                    return line
            time.sleep(0.02)
        pytest.fail(f"no line with '{words}' within {timeout} s in:\n{self.text}")

    def wait_to_hear(self, topic: str, num: int = 1) -> None:
        """Wait until it has found that many publishers of a topic (full name); see listening.py."""
        self.wait_for(f"{topic} is heard from {num}")

    def wait_for_exit(self, timeout: float = EVENTUALLY_S) -> int:
        """Return the exit code."""
        code = self.process.wait(timeout)
        self._reader.join(EVENTUALLY_S)
        return code

    def stop(self, sign: signal.Signals = signal.SIGTERM, timeout: float = EVENTUALLY_S) -> int:
        """Ask it to stop and return the exit code."""
        self.process.send_signal(sign)
        return self.wait_for_exit(timeout)

    def kill(self) -> None:
        """End it, this one process only; one that was killed leaves shared memory of DDS behind."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(ENDING_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait(EVENTUALLY_S)
        self._reader.join(EVENTUALLY_S)
        assert self.process.stdout is not None
        self.process.stdout.close()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))
