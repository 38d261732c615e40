"""Processor time and memory of processes, read from /proc."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")
_KIB, _MIB = 1024, 1024.0**2
_UTIME, _STIME = 11, 12  # behind the name of /proc/PID/stat, proc(5)


@dataclass
class Load:
    """What a process took.

    Attributes:
        cpu_s: Processor time since it was first looked at, s.
        rss_mb: Largest memory seen, MiB.
    """

    cpu_s: float = 0.0
    rss_mb: float = 0.0


class LoadMeter:
    """Adds up what processes take from the first look on."""

    def __init__(self) -> None:
        self.loads: dict[str, Load] = {}
        self._first: dict[str, float] = {}

    def look(self, pids: Mapping[str, int]) -> None:
        """Look at processes by name; one that is gone keeps what it had."""
        for name, pid in pids.items():
            try:
                spent = cpu_seconds(Path(f"/proc/{pid}/stat").read_text())
                memory = resident_mb(Path(f"/proc/{pid}/status").read_text())
            except (OSError, ValueError):
                continue
            load = self.loads.setdefault(name, Load())
            load.cpu_s = spent - self._first.setdefault(name, spent)
            load.rss_mb = max(load.rss_mb, memory)


def cpu_seconds(stat: str) -> float:
    """Return the processor time that a text of /proc/PID/stat names, s.

    Raises:
        ValueError: If it is no such text.
    """
    words = stat.rpartition(")")[2].split()
    if len(words) <= _STIME:
        raise ValueError(f"stat must hold the times of a process, got {stat!r}")
    return (int(words[_UTIME]) + int(words[_STIME])) / _TICKS


def resident_mb(status: str) -> float:
    """Return the resident memory that a text of /proc/PID/status names, MiB; 0 for a zombie."""
    for line in status.splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * _KIB / _MIB
    return 0.0
