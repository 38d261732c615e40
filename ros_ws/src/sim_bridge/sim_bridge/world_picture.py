"""A picture of a world from above, with what laser and sonars gave from several places."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.drawing import (
    draw_beams,
    draw_cones,
    draw_from_above,
    draw_laser,
    draw_legend,
    draw_robot,
    draw_sonar,
    extent_of,
    plain,
)
from sim_bridge.schema import WorldError
from sim_bridge.simulation import Simulation
from sim_bridge.snapshot import Snapshot, snapshot, stops_of
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import World

_PANEL_IN = 9.0
_WIDE = 1.15
_NUM_PANES = 3


def write_world_picture(path: Path, world: World, seed: int = 0, max_stops: int = 12) -> int:
    """Write a picture of a world with what laser and sonars gave, one panel each.

    Measured from standstill at the start and the route's waypoints; beams and cones of one of
    those places, near glass if there is any, are drawn whole.

    Returns:
        From how many places it was measured.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    views = _views(world, seed, max_stops)
    sheet = plain(without_cameras(world))
    shown = _nearest_to_glass(views, solids_of(world))
    simulation = Simulation(
        sheet if shown is None else placed(sheet, shown.T_world_base), seed=seed
    )
    extent = np.subtract(*extent_of(simulation)[::-1])
    count = 1 + any(view.sonar for view in views)
    figure, axes = plt.subplots(
        *_shape(count, extent), figsize=_figure_size(count, extent),
        layout="constrained", squeeze=False, sharex=True, sharey=True,
    )  # fmt: skip
    for panel, is_sonar in zip(axes.ravel(), (False, True), strict=False):
        draw_from_above(panel, simulation)
        _draw_views(panel, views, shown, is_sonar=is_sonar)
        panel.label_outer()
    simulation.close()
    draw_legend(figure, axes.ravel())
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return len(views)


def placed(world: World, pose: SE2) -> World:
    """Return the world with its first robot elsewhere, and no other."""
    there = replace(world.robots[0], position_m=(pose.x, pose.y), yaw_deg=math.degrees(pose.yaw))
    return replace(world, robots=(there,))


def without_cameras(world: World) -> World:
    """Return the world with robots that have none: nothing is drawn for them in each step."""
    off = {"omni": None, "stereo": None}
    robots = tuple(replace(r, overrides={**r.overrides, **off}) for r in world.robots)
    return replace(world, robots=robots)


def _draw_views(
    axes: Any, views: list[Snapshot], shown: Snapshot | None, *, is_sonar: bool
) -> None:
    for k, view in enumerate(views):
        label = None if k else f"robot, at {len(views)} places"
        draw_robot(axes, view, label=label)
        if is_sonar:
            draw_sonar(axes, view, label=None if k else "sonar: first echo, somewhere on the arc")
        else:
            draw_laser(axes, view, label=None if k else "laser: end of a beam")
    if shown is not None and is_sonar:
        draw_cones(axes, shown)
    elif shown is not None:
        draw_beams(axes, shown, with_open=False)


def _nearest_to_glass(views: list[Snapshot], solids: list[Solid]) -> Snapshot | None:
    """Return the view nearest to some panes at once; without glass one of the middle ones."""
    panes = np.array([(s.pose.x, s.pose.y) for s in solids if s.glass is not None]).reshape(-1, 2)
    if not views or not len(panes):
        return views[len(views) // 3] if views else None
    return min(views, key=lambda view: _distance(panes, view.T_world_base))


def _distance(points: np.ndarray, pose: SE2) -> float:
    distances = np.sort(np.hypot(*(points - (pose.x, pose.y)).T))
    return float(distances[:_NUM_PANES].mean())


def _shape(count: int, extent: np.ndarray) -> tuple[int, int]:
    return (count, 1) if extent[0] > _WIDE * extent[1] else (1, count)


def _figure_size(count: int, extent: np.ndarray) -> tuple[float, float]:
    rows, columns = _shape(count, extent)
    width = _PANEL_IN if columns == 1 else 1.45 * _PANEL_IN
    return width, rows * (width / columns) * float(extent[1] / extent[0]) + 0.7


def _views(world: World, seed: int, max_stops: int) -> list[Snapshot]:
    stops = stops_of(world)
    picked = [stops[round(k)] for k in np.linspace(0, len(stops) - 1, min(len(stops), max_stops))]
    views = []
    for k, pose in enumerate(picked):
        try:
            views.append(snapshot(world, pose, seed + k))
        except WorldError:
            continue  # the robot fits there only the other way round
    return views
