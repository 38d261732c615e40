"""Pictures of the avoidance experiment: ways weighed (Fig. 4c), tracks every 1/3 s (Fig. 9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.avoidance_fields import ROBOT_RADIUS, world_of
from experiments.avoidance_judge import Run
from sim_bridge.solids import solids_of
from sjmc_planner.config import LocalPlannerConfig, OmniConfig, RobotConfig
from sjmc_planner.methods import make_method
from sjmc_planner.planning import Velocity

_TITLES = {"omni_static": "without regard to velocity", "omni_velocity": "with velocity"}


def draw_figure_4c(path: Path) -> tuple[Path, str]:
    """Draw the ways for J = 16 at v_a = (400, 0) mm/s, as the paper does."""
    omni = OmniConfig(num_directions=16)
    method = make_method(LocalPlannerConfig(omni=omni, robot=RobotConfig()))
    ways = method.ways(Velocity(0.4, 0.0, 0.0), 0.4)  # type: ignore[attr-defined]
    figure, (axes,) = _figure(1, 1, (5.0, 5.0))
    for way in ways:
        axes.plot(-way[:, 1], way[:, 0], color="tab:blue", linewidth=1.0)
    axes.plot(0.0, 0.0, "ko")
    axes.set_aspect("equal")
    axes.set_xlabel("- y, m")
    axes.set_ylabel("x, m")
    figure.savefig(path)
    text = (
        "Fig. 4c: ways for J = 16 over 2.75 s; v_a = (400, 0) mm/s, v_c = 400 mm/s, "
        "alpha = 300 mm/s^2, idle time 0.03 s."
    )
    return path, text


def draw_figure_9(path: Path, setting: str, runs: Mapping[str, Run]) -> tuple[Path, str]:
    """Draw the two tracks of the layout, the robot every 1/3 s."""
    figure, all_axes = _figure(2, 1, (8.0, 9.5))
    for axes, mode in zip(all_axes, ("omni_static", "omni_velocity"), strict=True):
        _draw_run(axes, runs[mode])
        axes.set_title(f"{setting}: {_TITLES[mode]}, {_outcome(runs[mode])}", fontsize=10)
    figure.savefig(path)
    return path, f"Fig. 9 with the {setting} template and rule: the robot every 1/3 s."


def draw_fields(path: Path, runs: Mapping[str, Sequence[Run]]) -> tuple[Path, str]:
    """Draw the first random fields, one column a mode."""
    num = max(len(r) for r in runs.values())
    figure, all_axes = _figure(num, 2, (12.0, 3.6 * num))
    for k, mode in enumerate(("omni_static", "omni_velocity")):
        for row, run in enumerate(runs[mode]):
            axes = all_axes[2 * row + k]
            _draw_run(axes, run)
            title = f"{run.field.name}, {_TITLES[mode]}: {_outcome(run)}"
            axes.set_title(title, fontsize=9)
    figure.savefig(path)
    return path, "Random fields with the default template, without and with velocity."


def _outcome(run: Run) -> str:
    how = "touched" if run.has_collided else "reached" if run.is_reached else "gave up"
    return f"{how} after {run.time_s:.1f} s, least clearance {1e3 * run.min_clearance_m:.0f} mm"


def _draw_run(axes: Any, run: Run) -> None:
    import matplotlib.patches

    for solid in solids_of(world_of(run.field, {})):
        if solid.bottom < 0.2 and abs(solid.pose.x) < 2.0 and abs(solid.pose.y) < 1.0:
            axes.fill(*solid.outline().T, color="0.5" if solid.name != "cube" else "tab:brown")
    for x, y in run.track:
        axes.add_patch(
            matplotlib.patches.Circle((x, y), ROBOT_RADIUS, fill=False, color="tab:blue")
        )
    axes.plot(*run.path.T, color="tab:blue", linewidth=0.8)
    axes.plot(*run.field.goal, "r*", markersize=10)
    axes.set_xlim(-1.6, 1.6)
    axes.set_ylim(-0.82, 0.82)
    axes.set_aspect("equal")


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=90, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
