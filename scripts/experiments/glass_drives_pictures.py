"""Pictures of the glass drives: the same run of each row, from above."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.glass_drives_runs import Outcome
from experiments.glass_drives_worlds import Place
from experiments.run_panels import draw_panels
from floornav_common.se2 import SE2
from sim_bridge.robot_model import load_robot
from sim_bridge.solids import solids_of

_COLUMNS = 2
_EVERY = 4  # kept poses between two outlines


def draw_runs(path: Path, place: Place, outcomes: Mapping[str, Outcome]) -> None:
    """Draw a run by each row: outlines on the way, true glass, and the glass of its map."""
    corners = np.vstack([s.outline() for s in solids_of(place.world)])
    low, high = corners.min(axis=0) - 0.3, corners.max(axis=0) + 0.3
    outline = np.array(load_robot(place.world.robots[0]).config.footprint_m)
    panels = {
        f"{name}: {_words(outcome)}": partial(_draw, place, outline, outcome)
        for name, outcome in outcomes.items()
    }
    draw_panels(path, low, high, panels, _COLUMNS, width_in=6.0)


def _draw(place: Place, outline: np.ndarray, outcome: Outcome, axes: Any) -> None:
    for solid in solids_of(place.world):
        if solid.bottom < 0.4:
            is_glass = solid.glass is not None
            color = "deepskyblue" if is_glass else "0.55"
            axes.fill(*solid.outline().T, facecolor=color, edgecolor=color, linewidth=1.5)
    axes.plot(*outcome.glass.T, ".", color="tab:red", markersize=1.5)
    for pose in [*outcome.track[::_EVERY], *outcome.track[-1:]]:
        axes.fill(*(SE2(*pose.tolist()) @ outline).T, fill=False, edgecolor="tab:blue", lw=0.6)
    axes.plot(outcome.track[:, 0], outcome.track[:, 1], color="tab:blue", linewidth=1.2)
    axes.plot(*np.array(place.goals).T, "k+", markersize=9)


def _words(outcome: Outcome) -> str:
    """Return what came of a run, in a line."""
    if outcome.touched:
        return f"touched {outcome.touched} after {outcome.time_s:.0f} s"
    there = "there" if outcome.is_reached else f"{outcome.num_reached} of 2 goals"
    return f"{there} in {outcome.time_s:.0f} s, least to glass {outcome.min_glass_m:.2f} m"
