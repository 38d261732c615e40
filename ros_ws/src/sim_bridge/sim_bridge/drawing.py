"""A world from above, with what laser and sonars measured in it (matplotlib)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from sim_bridge.schema import WorldError
from sim_bridge.snapshot import Snapshot, snapshot, stops_of
from sim_bridge.solids import Solid, solids_of
from sim_bridge.world import World

GLASS, SOLID, EDGE = "#31b5d6", "#c9cdd3", "#6b7480"
LASER, SONAR, ROBOT = "#d7301f", "#6a3fb5", "#1a7f4b"


def draw_solids(axes: Any, solids: list[Solid], height: float | None = None) -> None:
    """Draw the outlines of a world; with a height (m) only what a plane there cuts, the rest pale.

    Args:
        axes: Of matplotlib.
        solids: The world.
        height: For instance that of the laser.
    """
    for solid in solids:
        outline = solid.outline()
        if solid.glass is not None:
            ends = (outline[[0, 1]] + outline[[3, 2]]) / 2.0
            axes.plot(*ends.T, color=GLASS, lw=2.4, solid_capstyle="butt", zorder=3)
            continue
        is_cut = height is None or solid.is_at_height(height)
        color, edge = (SOLID, EDGE) if is_cut else ("#f3f4f6", "#d5d9de")
        axes.fill(*outline.T, facecolor=color, edgecolor=edge, lw=0.6, zorder=2 if is_cut else 1)


def draw_laser(axes: Any, seen: Snapshot) -> None:
    """Draw where the beams of a scan ended, from the true pose."""
    if seen.scan is None or seen.model.config.laser is None:
        return
    points = _mount(seen, seen.model.config.laser.frame) @ seen.scan.points()
    axes.plot(*points.T, ".", color=LASER, ms=1.6, zorder=5)


def draw_sonar(axes: Any, seen: Snapshot) -> None:
    """Draw each echo as the arc it may have come from, from the true pose."""
    for frame, reading in zip(seen.model.config.sonar_frames, seen.sonar, strict=True):
        if reading.is_hit:
            half = reading.field_of_view / 2.0
            angles = np.linspace(-half, half, 13)
            arc = reading.range * np.column_stack((np.cos(angles), np.sin(angles)))
            axes.plot(*(_mount(seen, frame) @ arc).T, color=SONAR, lw=1.3, zorder=5)


def draw_robot(axes: Any, seen: Snapshot) -> None:
    """Draw the footprint."""
    corners = seen.T_world_base @ np.array(seen.model.config.footprint_m)
    axes.fill(*corners.T, facecolor="none", edgecolor=ROBOT, lw=1.0, zorder=4)


def write_world_picture(path: Path, world: World, seed: int = 0, max_stops: int = 12) -> int:
    """Write a picture of a world with laser points (left) and sonar arcs (right).

    Measured from standstill at the start and the route's waypoints.

    Returns:
        From how many places it was measured.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    views = _views(world, seed, max_stops)
    has_sonar = any(view.sonar for view in views)
    count = 1 + has_sonar
    solids = solids_of(world)
    spread = np.ptp(np.vstack([s.outline() for s in solids] or [np.zeros((1, 2))]), axis=0) + 0.5
    figure, panels = plt.subplots(
        1, count, figsize=(7.5 * count, 1.0 + 7.5 * min(1.4, spread[1] / spread[0])),
        layout="constrained", squeeze=False, sharex=True, sharey=True,
    )  # fmt: skip
    for axes, draw, title in zip(
        panels[0], (draw_laser, draw_sonar), ("laser", "sonar"), strict=False
    ):
        draw_solids(axes, solids, _laser_height(views))
        for view in views:
            draw_robot(axes, view)
            draw(axes, view)
        axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"{world.name}: {title}")
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return len(views)


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


def _laser_height(views: list[Snapshot]) -> float | None:
    config = views[0].model.config.laser if views else None
    return None if config is None else float(views[0].model.mounts[config.frame][2, 3])


def _mount(seen: Snapshot, frame: str) -> SE2:
    return seen.T_world_base @ Transform3(seen.model.mounts[frame]).to_se2()
