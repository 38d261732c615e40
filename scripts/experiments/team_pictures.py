"""Pictures of `team-localization`: layouts as in Fig. 10 and 11, errors against n and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.team_layouts import BODY_RADIUS, FIELD_X, FIELD_Y, POSTS
from experiments.team_paper_cases import case_scene
from experiments.team_rows import Row, timed

_CASE_NOISE_DEG = 3.0
_ARROW_M = 0.45


def draw_case(path: Path, title: str, seed: int) -> tuple[Path, str]:
    """Draw four robots as Fig. 10 and 11 do: true layout dashed, estimated solid."""
    scene = case_scene(_CASE_NOISE_DEG, seed)
    figure, all_axes = _figure(1, 2, (11.0, 3.7))
    for axes, method in zip(all_axes, ("published", "team"), strict=True):
        solution, _ = timed(scene, Row(table="", title="", num_robots=4, method=method))
        found = [
            estimate.pose.as_array() if (estimate := solution.estimates.get(name)) else None
            for name in scene.layout.names
        ]
        _draw_field(axes)
        _draw_layout(axes, list(scene.layout.poses), "0.35", "--")
        _draw_layout(axes, [pose for pose in found if pose is not None], "tab:red", "-")
        for letter, pose in zip("ABCD", scene.layout.poses, strict=True):
            axes.annotate(letter, pose[:2] + 0.18)
        axes.set_title(f"{title}, {'as published' if method == 'published' else 'ours'}")
    figure.savefig(path)
    text = f"{title}: layout {seed}, {_CASE_NOISE_DEG:g} deg; true dashed, estimated solid."
    return path, text


def draw_sweep(out: Path, rows: Sequence[Mapping[str, Any]]) -> list[tuple[Path, str]]:
    """Draw errors and identities against the number of robots and against noise."""
    numbers = sorted({row["n"] for row in rows})
    noises = sorted({row["noise_deg"] for row in rows})
    by_n = out / "error_against_robots.png"
    figure, (left, right) = _figure(1, 2, (11.0, 4.0))
    for color, noise in enumerate(noises):
        shown = [row for row in rows if row["noise_deg"] == noise]
        _draw_errors(left, shown, "n", f"{noise:g} deg", f"C{color}")
        x = [row["n"] for row in shown]
        right.plot(x, [100 * r["identified_share"] for r in shown], "o-", color=f"C{color}")
        right.plot(x, [100 * r["oracle_share"] for r in shown], "--", color=f"C{color}")
    _label(left, "robots", "rms position error, m", numbers)
    _label(right, "robots", "bearings identified, % (dashed: oracle)", numbers)
    left.legend(title="solid: team, dashed: bound")
    figure.savefig(by_n)
    by_noise = out / "error_against_noise.png"
    figure, (axes,) = _figure(1, 1, (6.0, 4.0))
    for color, num in enumerate(numbers):
        shown = [row for row in rows if row["n"] == num]
        _draw_errors(axes, shown, "noise_deg", f"{num} robots", f"C{color}")
    _label(axes, "deviation of a bearing, deg", "rms position error, m", noises)
    axes.legend(title="solid: team, dashed: bound", fontsize=8)
    figure.savefig(by_noise)
    return [(by_n, "Errors and identities against n."), (by_noise, "Errors against noise.")]


def _draw_errors(
    axes: Any, rows: Sequence[Mapping[str, Any]], key: str, label: str, color: str
) -> None:
    x = [row[key] for row in rows]
    axes.plot(x, [_or_nan(row["rms_m"]) for row in rows], "o-", color=color, label=label)
    axes.plot(x, [_or_nan(row["bound_m"]) for row in rows], "--", color=color)


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value


def _label(axes: Any, x: str, y: str, ticks: Sequence[float]) -> None:
    axes.set_xscale("log")
    if "error" in y:
        axes.set_yscale("log")
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(alpha=0.3)


def _draw_field(axes: Any) -> None:
    x, y = 0.5 * FIELD_X, 0.5 * FIELD_Y
    axes.plot([-x, x, x, -x, -x], [-y, -y, y, y, -y], color="tab:green")
    for kind, places in POSTS.items():
        axes.plot(*places.T, "s", color="gold" if "yellow" in kind else "tab:blue")
    axes.set_aspect("equal")
    axes.set_xlim(-x - 0.4, x + 0.4)
    axes.set_ylim(-y - 0.4, y + 0.4)


def _draw_layout(axes: Any, poses: Sequence[np.ndarray], color: str, style: str) -> None:
    import matplotlib.patches

    for k, pose in enumerate(poses):
        for other in poses[k + 1 :]:
            axes.plot([pose[0], other[0]], [pose[1], other[1]], style, color=color, linewidth=0.8)
        circle = matplotlib.patches.Circle(
            pose[:2], BODY_RADIUS, fill=False, color=color, linestyle=style
        )
        axes.add_patch(circle)
        tip = _ARROW_M * np.array([np.cos(pose[2]), np.sin(pose[2])])
        axes.annotate("", pose[:2] + tip, pose[:2], arrowprops={"arrowstyle": "->", "color": color})


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
