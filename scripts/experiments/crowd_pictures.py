"""Pictures of the crowd experiment: the same run by each method, from above."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.crowd_runs import Outcome
from experiments.crowd_scenes import Scene
from experiments.run_panels import draw_panels
from floornav_common.se2 import SE2
from sim_bridge.robot_model import load_robot
from sim_bridge.solids import solids_of

_COLUMNS = 3


def draw_scene(path: Path, scene: Scene, outcomes: Mapping[str, Outcome]) -> None:
    """Draw a run by each method: outlines every second, people's ways to the end of the drive."""
    outline = np.array(load_robot(scene.world.robots[0]).config.footprint_m)
    panels = {
        f"{method}: {_words(outcome)}": partial(_draw_run, scene, outline, outcome)
        for method, outcome in outcomes.items()
    }
    draw_panels(path, *_extent(scene, outcomes), panels, _COLUMNS, width_in=5.0)


def _draw_run(scene: Scene, outline: np.ndarray, outcome: Outcome, axes: Any) -> None:
    for solid in solids_of(scene.world):
        axes.fill(*solid.outline().T, color="0.6")
    for track in outcome.people.values():
        axes.plot(track[:, 1], track[:, 2], color="tab:orange", linewidth=0.6)
        axes.scatter(track[::10, 1], track[::10, 2], s=6, color="tab:orange")
        axes.add_patch(_circle(track[-1, 1:], scene.world.people_model.torso_radius_m))
    for pose in outcome.track[::2]:
        corners = SE2(*pose.tolist()) @ outline
        axes.fill(*corners.T, fill=False, edgecolor="tab:blue", linewidth=0.6)
    axes.plot(outcome.track[:, 0], outcome.track[:, 1], color="tab:blue", linewidth=1.2)
    axes.plot(*scene.goal, "k+", markersize=9)


def _circle(middle: np.ndarray, radius: float):  # type: ignore[no-untyped-def]
    from matplotlib.patches import Circle

    return Circle(tuple(middle), radius, color="tab:orange", alpha=0.5)


def _extent(scene: Scene, outcomes: Mapping[str, Outcome]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and the upper corner of what is shown: all drives and 1.5 m round them."""
    ends = np.array([scene.world.robots[0].position_m, scene.goal])
    places = np.concatenate([ends, *(o.track[:, :2] for o in outcomes.values())])
    return places.min(axis=0) - 1.5, places.max(axis=0) + 1.5


def _words(outcome: Outcome) -> str:
    """Return what came of a run, in a line."""
    said = (
        f"{outcome.time_s:.1f} s" if outcome.is_reached else f"not there in {outcome.time_s:.0f} s"
    )
    if outcome.caused or outcome.theirs:
        said += f", touched {outcome.caused} people, {outcome.theirs} touched it"
    return said + (f", {outcome.things} things touched" if outcome.things else "")
