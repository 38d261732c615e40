"""Pictures of the five-robot recording: each way beside the true one, and errors over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from experiments.mrclam_measures import SKIP_S, Errors
from experiments.mrclam_recording import TeamRecording
from experiments.mrclam_runs import Track

_COLORS = {"odometry": "#8a8f98", "alone": "#d9822b", "team": "#1f6fb4"}
_MARGIN_M = 1.0


def draw_ways(path: Path, recording: TeamRecording, tracks: Mapping[str, Track]) -> Path:
    """Draw a row a method and a column a robot: the true way in black, the estimate over it."""
    logs = recording.robots
    figure, grid = _figure(len(tracks), len(logs), (2.5 * len(logs), 4.0 * len(tracks)))
    points = np.array(list(recording.landmarks.values()))
    for column, (robot, log) in enumerate(logs.items()):
        for row, (method, track) in enumerate(tracks.items()):
            axes = grid[row][column]
            is_late = track.times - recording.start >= SKIP_S
            truth = log.truth_at(track.times)[is_late]
            axes.plot(truth[:, 0], truth[:, 1], color="black", lw=0.8)
            poses = track.poses[is_late, column]
            poses = np.where(np.isfinite(truth[:, :1]), poses, np.nan)
            axes.plot(poses[:, 0], poses[:, 1], color=_COLORS[method], lw=0.9)
            axes.plot(*points.T, "k^", ms=3)
            axes.set_title(f"robot {robot}: {method}", fontsize=9)
            seen = np.concatenate([truth[np.isfinite(truth[:, 0]), :2], points])
            low, high = seen.min(axis=0) - _MARGIN_M, seen.max(axis=0) + _MARGIN_M
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.tick_params(labelsize=7)
    figure.savefig(path)
    return path


def draw_errors(
    path: Path, recording: TeamRecording, tracks: Mapping[str, Track], errors: Mapping[str, Errors]
) -> Path:
    """Draw each robot's position error over time, one line a method; logarithmic."""
    figure, grid = _figure(len(recording.robots), 1, (9.0, 2.0 * len(recording.robots)))
    for row, robot in enumerate(recording.robots):
        axes = grid[row][0]
        for method, track in tracks.items():
            after = track.times - recording.start
            far = np.maximum(errors[method].distances[:, row], 1e-3)
            axes.semilogy(after, far, color=_COLORS[method], lw=0.9, label=method)
        axes.set_ylabel(f"robot {robot}, m", fontsize=8)
        axes.set_ylim(0.01, 10.0)
        axes.grid(alpha=0.3)
        axes.tick_params(labelsize=7)
    grid[0][0].legend(fontsize=8, ncol=3, loc="upper left")
    grid[-1][0].set_xlabel("s after the recording's begin", fontsize=8)
    figure.savefig(path)
    return path


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False)
