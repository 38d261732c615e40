"""The picture of `evaluate.py faults`: speed over time round each fault; the same as text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from experiments.faults_judge import Moved
from experiments.faults_result import Row, Trace

_COLUMNS, _WIDTH, _HEIGHT = 4, 3.4, 1.9
_COMMAND, _TRUE, _FAULT, _BAD = "tab:blue", "black", "#f3d9a4", "tab:red"


def draw_speeds(path: Path, rows: list[Row]) -> None:
    """Draw a small plot for each fault: what was commanded, and how the robot moved."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = [row for row in rows if row.trace is not None]
    num_rows = max(1, -(-len(shown) // _COLUMNS))
    figure = Figure(figsize=(_COLUMNS * _WIDTH, num_rows * _HEIGHT), layout="constrained")
    FigureCanvasAgg(figure)
    for number, row in enumerate(shown, start=1):
        axes = figure.add_subplot(num_rows, _COLUMNS, number)
        assert row.trace is not None
        _draw_one(axes, row.trace)
        axes.set_title(row.name, fontsize=9, color="black" if row.passed else _BAD)
    figure.savefig(path, dpi=90)


def write_trace(path: Path, trace: Trace) -> None:
    """Write what was commanded and how the robot moved, times from when the fault began."""
    lines = ["what,time_s,speed_m_s,yaw_rate_rad_s"]
    for what, moments in (("command", trace.commands), ("motion", trace.motion)):
        for m in moments:
            time_s = 1e-9 * (m.ns - trace.struck_ns)
            lines.append(f"{what},{time_s:.3f},{m.speed:.4f},{m.yaw_rate:.4f}")
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def _draw_one(axes: Any, trace: Trace) -> None:
    def times(moments: list[Moved]) -> list[float]:
        return [1e-9 * (m.ns - trace.struck_ns) for m in moments]

    axes.axvspan(0.0, 1e-9 * (trace.end_ns - trace.struck_ns), color=_FAULT)
    axes.axvline(1e-9 * (trace.due_ns - trace.struck_ns), color=_BAD, lw=0.8, ls=":")
    speeds = [m.speed for m in trace.commands]
    axes.step(times(trace.commands), speeds, where="post", color=_COMMAND, lw=1.0)
    axes.plot(times(trace.motion), [m.speed for m in trace.motion], color=_TRUE, lw=1.2)
    axes.tick_params(labelsize=7)
    axes.set_ylim(-0.02, None)
