"""Files that are none: worlds and maps which a node must refuse in one line, and a full disk."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

_HEAD = "name: w\n"
_ROBOT = "robots:\n  - {model: segway_rmp50, position_m: [1, 1]}\n"
_WORLDS = {
    "empty": "",
    "no-yaml": "name: [",
    "a-list": "- 1\n- 2\n",
    "no-name": _ROBOT,
    "unknown-key": _HEAD + _ROBOT + "wals: []\n",
    "text-for-number": _HEAD + _ROBOT + "ceiling_m: high\n",
    "nan-place": _HEAD + "robots:\n  - {model: segway_rmp50, position_m: [.nan, 1]}\n",
    "no-such-robot": _HEAD + "robots:\n  - {model: nothing, position_m: [1, 1]}\n",
    "wall-of-no-length": _HEAD + _ROBOT + "walls:\n  - {from_m: [0, 0], to_m: [0, 0]}\n",
    "key-twice": _HEAD + "name: v\n" + _ROBOT,
    "unknown-parameter": _HEAD + "robots:\n  - {model: segway_rmp50, position_m: [$x, 1]}\n",
    "bytes": "\x00\x01\x02",
}
_MAP = "image: map.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
_MAPS = {
    "empty": "",
    "no-yaml": "image: [",
    "a-list": "- 1\n",
    "no-origin": "image: map.pgm\nresolution: 0.05\n",
    "no-resolution": _MAP.replace("0.05", "0.0"),
    "nan-resolution": _MAP.replace("0.05", ".nan"),
    "text-resolution": _MAP.replace("0.05", "fine"),
    "nan-origin": _MAP.replace("[0.0,", "[.nan,"),
    "short-origin": _MAP.replace("[0.0, 0.0, 0.0]", "[0.0]"),
    "no-image": _MAP.replace("map.pgm", "nothing.pgm"),
    "bad-image": _MAP.replace("map.pgm", "bad.pgm"),
    "unknown-mode": _MAP + "mode: colors\n",
    "nan-thresholds": _MAP + "occupied_thresh: .nan\nfree_thresh: .nan\n",
}
_PGM = b"P5\n4 4\n255\n" + bytes([254] * 16)
_AT_ONCE, _END_S = 3, 180.0


@dataclass(frozen=True)
class Attempt:
    """A start of a node that must be refused, or may run.

    Attributes:
        name: Of the attempt.
        code: Exit code; None if it said that it is ready, and was ended.
        text: All that it said.
    """

    name: str
    code: int | None
    text: str

    @property
    def problem(self) -> str:
        """What is wrong with how it was refused; "" if nothing is."""
        lines = [line for line in self.text.splitlines() if line.strip()]
        if "Traceback" in self.text:
            return f"{self.name}: {lines[-1] if lines else 'a traceback'}"
        if self.code != 2:
            return f"{self.name}: {'runs' if self.code is None else f'ended with {self.code}'}"
        return ""


def write_worlds(folder: Path) -> dict[str, Path]:
    """Write malformed worlds, and return them by name."""
    return _write(folder, _WORLDS)


def write_maps(folder: Path) -> dict[str, Path]:
    """Write malformed maps, and return them by name; one is a file that is not there."""
    written = _write(folder, _MAPS)
    (folder / "map.pgm").write_bytes(_PGM)
    (folder / "bad.pgm").write_bytes(b"not an image")
    return {**written, "not-there": folder / "not-there.yaml"}


def _write(folder: Path, texts: Mapping[str, str]) -> dict[str, Path]:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    return {name: folder / f"{name}.yaml" for name in texts}


def module_command(module: str, *words: str) -> list[str]:
    """Return the command of a node apart from the graph: in a namespace, with its own TF."""
    apart = ["-r", "__ns:=/apart", "-r", "/tf:=/apart/tf", "-r", "/tf_static:=/apart/tf_static"]
    return [
        sys.executable,
        "-m",
        module,
        "--ros-args",
        *apart,
        "-r",
        "/clock:=/apart/clock",
        *words,
    ]


def try_starts(
    commands: Mapping[str, list[str]], logs: Path, work: Callable[[], None]
) -> Iterator[Attempt]:
    """Start processes, a few at a time, and give what became of each.

    Args:
        commands: By name.
        logs: Folder for what they say.
        work: Called while they run.
    """
    logs.mkdir(parents=True, exist_ok=True)
    waiting, running = dict(commands), {}
    try:
        while waiting or running:
            while waiting and len(running) < _AT_ONCE:
                name = next(iter(waiting))
                running[name] = _Start(waiting.pop(name), logs / f"{name}.txt")
            work()
            for name in [name for name, start in running.items() if start.is_over()]:
                yield running.pop(name).attempt(name)
    finally:
        for start in running.values():
            start.end()


class _Start:
    """One process, with what it says in a file."""

    def __init__(self, command: list[str], log: Path) -> None:
        self._log, self._end = log, time.monotonic() + _END_S
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
            )  # fmt: skip

    def is_over(self) -> bool:
        """Whether it ended, runs, or takes too long."""
        is_late = time.monotonic() > self._end
        return self._process.poll() is not None or is_late or "]: ready" in self._text()

    def attempt(self, name: str) -> Attempt:
        """Return what became of it."""
        code = self._process.poll()
        self.end()
        return Attempt(name, code, self._text())

    def end(self) -> None:
        """End it."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    def _text(self) -> str:
        return self._log.read_text(errors="replace")
