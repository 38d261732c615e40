"""Parts of a picture of a world from above: what is there, what sensors gave (matplotlib)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from sim_bridge.simulation import Simulation
from sim_bridge.snapshot import Snapshot
from sim_bridge.solids import Solid
from sim_bridge.world import World

GLASS, SOLID, EDGE = "#31b5d6", "#c9cdd3", "#6b7480"
LASER, SONAR, ROBOT, PERSON = "#d7301f", "#6a3fb5", "#1a7f4b", "#c46200"
_PALE_FLOOR = (0.93, 0.93, 0.92)
_FAR_FOV_RAD = math.radians(2.0)  # from so far above that upright walls have no sides
_BACKDROP_PX = 1000
_MARGIN = 0.3


def draw_solids(axes: Any, solids: list[Solid], height: float | None = None) -> None:
    """Draw the outlines of a world; with a height (m) only what a plane there cuts, the rest pale.

    Args:
        axes: Of matplotlib.
        solids: The world.
        height: For instance that of the laser.
    """
    draw_panes(axes, solids)
    for solid in solids:
        if solid.glass is not None:
            continue
        is_cut = height is None or solid.is_at_height(height)
        color, edge = (SOLID, EDGE) if is_cut else ("#f3f4f6", "#d5d9de")
        axes.fill(
            *solid.outline().T, facecolor=color, edgecolor=edge, lw=0.6, zorder=2 if is_cut else 1
        )


def draw_panes(axes: Any, solids: Sequence[Solid]) -> None:
    """Draw the middle line of every pane of glass."""
    panes = [solid.outline() for solid in solids if solid.glass is not None]
    for k, outline in enumerate(panes):
        ends = (outline[[0, 1]] + outline[[3, 2]]) / 2.0
        name = None if k else "glass"
        axes.plot(*ends.T, color=GLASS, lw=2.4, solid_capstyle="butt", zorder=3, label=name)


def plain(world: World) -> World:
    """Return a world without shadows, its floor pale where it has no picture: a sheet to draw on.

    Light and floor are nothing to lasers and sonars.
    """
    if world.floor.from_m != world.floor.to_m:
        return world
    floor, light = replace(world.floor, color=_PALE_FLOOR), replace(world.light, shadow=0.0)
    return replace(world, floor=floor, light=light)


def extent_of(
    simulation: Simulation, places: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (m) of what is worth drawing: the floor's picture, else everything.

    Args:
        simulation: The world.
        places: Further points to be in the picture, (N, 2), m, where the floor has no picture.
    """
    world = simulation.world
    if world.floor.from_m != world.floor.to_m:
        return np.array(world.floor.from_m), np.array(world.floor.to_m)
    parts = [solid.outline() for solid in simulation.solids]
    parts += [np.array([(pose.x, pose.y)]) for pose in simulation.starts.values()]
    if world.recorded_people is not None:
        parts.append(np.array([world.recorded_people.low_m, world.recorded_people.high_m]))
    corners = np.vstack(parts if places is None else [*parts, places])
    return corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN


def draw_from_above(
    axes: Any, simulation: Simulation, corners: tuple[np.ndarray, np.ndarray] | None = None
) -> None:
    """Draw what a camera far above sees now, robots and people too, and mark every pane.

    Args:
        axes: Of matplotlib; gets its limits and labels, in metres.
        simulation: The world.
        corners: Lower left and upper right corner, m; None = everything.
    """
    low, high = extent_of(simulation) if corners is None else corners
    middle, extent = (low + high) / 2.0, high - low
    columns, rows = np.maximum(np.rint(extent * _BACKDROP_PX / extent.max()).astype(int), 1)
    x, y, up = float(middle[0]), float(middle[1]), float(extent[1]) / 2.0
    image = simulation.views.picture(
        (x, y, up / math.tan(_FAR_FOV_RAD / 2.0)), (x, y, 0.0), (int(columns), int(rows)),
        fov_rad=_FAR_FOV_RAD,
    )  # fmt: skip
    axes.imshow(image, extent=(low[0], high[0], low[1], high[1]), zorder=0)
    draw_panes(axes, simulation.solids)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def draw_laser(
    axes: Any, seen: Snapshot, *, color: str = LASER, size: float = 1.6, label: str | None = None
) -> None:
    """Draw where the beams of a scan ended, from the true pose."""
    if seen.scan is None or seen.model.config.laser is None:
        return
    points = _mount(seen, seen.model.config.laser.frame) @ seen.scan.points()
    axes.plot(*points.T, ".", color=color, ms=size, mew=0.0, zorder=5, label=label)


def draw_beams(
    axes: Any, seen: Snapshot, *, color: str = LASER, alpha: float = 0.16, with_open: bool = True
) -> None:
    """Draw what the beams of a scan passed through.

    Args:
        axes: Of matplotlib.
        seen: With a scan.
        color: Of the area.
        alpha: Of the area.
        with_open: True draws beams without an echo to the longest range: right where nothing is
            there, wrong where glass took the echo.
    """
    if seen.scan is None or seen.model.config.laser is None:
        return
    scan = seen.scan
    farthest = scan.range_max if with_open else 0.0
    ranges = np.nan_to_num(scan.ranges, nan=0.0, neginf=0.0, posinf=farthest)
    rays = ranges[:, None] * np.column_stack((np.cos(scan.angles), np.sin(scan.angles)))
    T = _mount(seen, seen.model.config.laser.frame)
    axes.fill(*(T @ np.vstack((np.zeros(2), rays))).T, color=color, alpha=alpha, lw=0.0, zorder=4)


def draw_sonar(axes: Any, seen: Snapshot, *, width: float = 1.3, label: str | None = None) -> None:
    """Draw each echo as the arc it may have come from, from the true pose."""
    for k, (T, arc) in enumerate(_echoes(seen)):
        name = None if k else label
        axes.plot(*(T @ arc).T, color=SONAR, lw=width, zorder=5, label=name)


def draw_cones(axes: Any, seen: Snapshot, *, alpha: float = 0.16) -> None:
    """Draw the cone of every sonar as far as its echo came; one without echo has none."""
    for T, arc in _echoes(seen):
        axes.fill(*(T @ np.vstack((np.zeros(2), arc))).T, color=SONAR, alpha=alpha, lw=0, zorder=4)


def draw_robot(
    axes: Any, seen: Snapshot, *, color: str = ROBOT, width: float = 1.0, label: str | None = None
) -> None:
    """Draw the footprint."""
    corners = seen.T_world_base @ np.array(seen.model.config.footprint_m)
    axes.fill(*corners.T, facecolor="none", edgecolor=color, lw=width, zorder=6, label=label)


def draw_legend(figure: Any, panels: Sequence[Any]) -> None:
    """Write each label of the panels once, over them all."""
    named: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            named.setdefault(label, handle)
    columns = max(1, int(figure.get_figwidth() / 2.0))
    figure.legend(
        list(named.values()), list(named), loc="outside upper center", ncols=columns,
        frameon=False, markerscale=3.0, columnspacing=1.2, handlelength=1.4,
    )  # fmt: skip


def _echoes(seen: Snapshot) -> list[tuple[SE2, np.ndarray]]:
    """Return pose and arc in the sonar's frame (N, 2), of every echo."""
    echoes = []
    for frame, reading in zip(seen.model.config.sonar_frames, seen.sonar, strict=True):
        if reading.is_hit:
            angles = np.linspace(-0.5, 0.5, 13) * reading.field_of_view
            arc = reading.range * np.column_stack((np.cos(angles), np.sin(angles)))
            echoes.append((_mount(seen, frame), arc))
    return echoes


def _mount(seen: Snapshot, frame: str) -> SE2:
    return seen.T_world_base @ Transform3(seen.model.mounts[frame]).to_se2()
