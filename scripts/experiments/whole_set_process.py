"""One experiment of the whole set in a process of its own: what came of it, and what it took."""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import time
import traceback
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from floornav_common.reporting import Section

LOG = "log.txt"


@dataclass(frozen=True)
class Outcome:
    """What came of one experiment.

    Attributes:
        name: Of the experiment.
        state: done, failed or not run.
        reason: Of the last two; "" for done.
        values: What its summary.json holds; None if it came to none.
        sections: Of its report.
        wall_s: From start to end.
        cpu_s: Processor time of it and its processes.
        words: After `evaluate.py`.
    """

    name: str
    state: str
    reason: str
    values: dict[str, Any] | None
    sections: list[Section]
    wall_s: float | None
    cpu_s: float | None
    words: list[str] = field(default_factory=list)

    def row(self) -> dict[str, Any]:
        """Return all but the values and the report."""
        keys = ("name", "state", "reason", "wall_s", "cpu_s")
        return {**{key: getattr(self, key) for key in keys}, "command": " ".join(self.words)}


def run_item(name: str, words: list[str], out: Path) -> Outcome:
    """Run an experiment; what it prints goes to `log.txt` in its folder."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    log = out.parent / f"{name}.{LOG}"
    started = time.monotonic()
    process = context.Process(target=_experiment, args=([*words, "--out", str(out)], log, theirs))
    process.start()
    theirs.close()
    try:
        state, reason, values, sections, cpu_s = ours.recv()
    except EOFError:  # it died
        process.join()
        reason = f"ended with exit code {process.exitcode}; {log}"
        state, values, sections, cpu_s = "failed", None, [], None
    process.join()
    if out.is_dir():
        log.replace(out / LOG)
    wall_s = round(time.monotonic() - started, 2)
    return Outcome(name, state, reason, values, sections, wall_s, cpu_s, words)


def _experiment(argv: list[str], log: Path, answer: Connection) -> None:
    """Run in the process: answer with state, reason, values, sections, processor time."""
    with open(log, "w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    from evaluate import run_experiment  # it imports this module for the whole set

    values: dict[str, Any] | None = None
    sections: list[Section] = []
    try:
        values, sections = run_experiment(argv)
        state, reason = ("done", "") if values["ok"] else ("failed", "it says so itself")
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        traceback.print_exc()
        state, reason = "failed", f"{type(error).__name__}: {error}"
    answer.send((state, reason, values, sections, _processor_s()))


def _processor_s() -> float:
    """Return what this process and those that it waited for have computed."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return round(sum(one.ru_utime + one.ru_stime for one in used), 2)
