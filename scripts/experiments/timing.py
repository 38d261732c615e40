"""Timing that can be trusted on a noisy machine: what is compared takes turns, call by call."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Case:
    """One row of a benchmark.

    Attributes:
        name: What was done.
        median_ms: Ours, ms.
        p99_ms: Ours, ms.
        peer: Name of what it is held against.
        peer_median_ms: The peer's, ms.
        floor_ms: What any solution has to pay, ms.
        extra: Further figures of this case.
    """

    name: str
    median_ms: float
    p99_ms: float
    peer: str | None = None
    peer_median_ms: float | None = None
    floor_ms: float | None = None
    extra: Mapping[str, Any] = field(default_factory=dict)

    @property
    def ratio(self) -> float | None:
        """Ours over the peer's."""
        return self.median_ms / self.peer_median_ms if self.peer_median_ms else None

    def as_dict(self) -> dict[str, Any]:
        """Return the row as `summary.json` holds it."""
        values = asdict(self)
        del values["name"], values["extra"]
        return {**values, "ratio": self.ratio, **self.extra}


def take_turns(calls: Mapping[str, Callable[[], object]], num: int) -> dict[str, np.ndarray]:
    """Call each function `num` times, in turns, after one call that does not count.

    Returns:
        Milliseconds of each call by name, shape (num,).
    """
    for call in calls.values():
        call()
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(num):
        for name, call in calls.items():
            started = time.perf_counter()
            call()
            times[name].append(1e3 * (time.perf_counter() - started))
    return {name: np.array(ms) for name, ms in times.items()}


def median_and_p99(ms: np.ndarray) -> tuple[float, float]:
    """Return the median and the 99th percentile."""
    return float(np.median(ms)), float(np.percentile(ms, 99))
