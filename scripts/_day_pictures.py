"""Pictures of a demo with goals: both maps with ways and people, zones, errors, cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from _day_heard import Shot, Track, error_rows
from _demo_report import OCCUPIED
from experiments.goal_record import GoalRecord
from experiments.planner_judge import gap_to
from floornav_common.grid import OccupancyMap
from floornav_common.reporting import Picture
from floornav_common.se2 import SE2
from sim_bridge.drawing import GLASS
from sim_bridge.solids import Solid
from sim_bridge.world import World

_ROBOT, _PEOPLE, _GOAL, _BAD = "#1a7f4b", "#e0861a", "#b3134b", "#d7301f"
_LOCALIZER_COLORS = {"grid_mapper": "#e0641a", "stereo_localizer": "#2b7de0", "odometry": "#8a5cc2"}
_STATE_COLORS = {
    "driving": "#7cc79a", "turning": "#f2c14e", "waiting": "#f08a4b", "backing": "#c77dd1",
    "braking": "#e4572e", "blocked": "#b3134b", "stopped": "#444444", "reached": "#3b8ee0",
}  # fmt: skip
_MARGIN_M = 0.35
_COLUMNS = 4


@dataclass(frozen=True)
class Panel:
    """One run on the picture of maps.

    Attributes:
        title: What drove.
        grid: Its map.
        glass: What that says is glass; None for a map that says nothing of it.
        record: Its drive.
        touches: Places where it touched something, (N, 2), m.
    """

    title: str
    grid: OccupancyMap | None
    glass: OccupancyMap | None
    record: GoalRecord
    touches: np.ndarray


def write_maps(path: Path, world: World, solids: Sequence[Solid], panels: Sequence[Panel]) -> None:
    """Draw one panel a run: its map, glass apart, the robot's way, people and what was touched.

    Args:
        path: Of the picture.
        world: For the goals and the start.
        solids: What truly stands there.
        panels: The runs.
    """
    plt = _pyplot()
    corners = np.vstack([solid.outline() for solid in solids])
    low, high = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    width = 7.0
    height = width * float((high - low)[1] / (high - low)[0])
    size = (width * len(panels), height + 0.9)
    figure, axes = plt.subplots(1, len(panels), figsize=size, layout="constrained", squeeze=False)
    for axis, panel in zip(axes[0], panels, strict=True):
        axis.set_facecolor("#d9dde2")
        start = world.robots[0].pose
        _draw_grid(axis, panel.grid, start, (0.07, 0.09, 0.12, 1.0), has_free=True)
        _draw_grid(axis, panel.glass, start, (0.10, 0.62, 0.80, 1.0), has_free=False)
        _draw_truth(axis, solids)
        _draw_drive(axis, world, panel.record, panel.touches)
        axis.set(aspect="equal", title=panel.title, xlabel="x [m]", ylabel="y [m]")
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6, frameon=False)
    figure.savefig(path, dpi=90)
    plt.close(figure)


def write_zones(
    path: Path, record: GoalRecord, outline: np.ndarray, torso: float, zones: Mapping[str, float]
) -> None:
    """Draw the nearest person's distance, the planner's zones, its state and the robot's speed."""
    plt = _pyplot()
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(12.0, 4.6), sharex=True, layout="constrained", height_ratios=(2, 1)
    )
    times, gaps = nearest_person(record, outline, torso)
    above.plot(times, gaps, color=_PEOPLE, lw=1.6, label="nearest person, outline to body")
    for (name, radius), style in zip(zones.items(), (":", "--"), strict=False):
        above.axhline(radius, color="#555555", ls=style, lw=1.0, label=f"{name} {radius:g} m")
    _draw_states(above, record)
    above.set(ylabel="distance [m]", ylim=(0.0, max(zones.values(), default=4.0) * 1.15))
    figure.legend(loc="outside upper center", ncols=11, frameon=False, fontsize=8)
    way = record.way
    if len(way) > 10:
        moved = np.hypot(*(way[10:, 1:3] - way[:-10, 1:3]).T) / (way[10:, 0] - way[:-10, 0])
        below.plot(way[10:, 0], moved, color=_ROBOT, lw=1.2)
    below.set(xlabel="simulated time [s]", ylabel="speed [m/s]")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def write_errors(path: Path, tracks: Mapping[str, Track], truth: Track) -> None:
    """Draw how far the poses of every localizer were off, over time."""
    plt = _pyplot()
    figure, axes = plt.subplots(figsize=(12.0, 3.4), layout="constrained")
    for name, track in tracks.items():
        rows = error_rows(track, truth)
        color = _LOCALIZER_COLORS.get(name, "#444444")
        off = np.maximum(rows[:, 1], 1e-4)
        style = "." if len(rows) < len(truth) / 20 else "-"
        axes.semilogy(rows[:, 0], off, style, color=color, label=name, lw=1.4, ms=4)
    axes.set(xlabel="simulated time [s]", ylabel="position error [m]")
    axes.grid(alpha=0.25, which="both")
    axes.legend(frameon=False, ncols=4)
    figure.savefig(path, dpi=90)
    plt.close(figure)


def write_shots(folder: Path, shots: Sequence[Shot]) -> list[Picture]:
    """Write one sheet a topic with pictures of several moments; returns them for the page."""
    plt = _pyplot()
    pictures = []
    for topic in dict.fromkeys(shot.name for shot in shots):
        taken = [shot for shot in shots if shot.name == topic]
        picked = [taken[k] for k in np.unique(np.linspace(0, len(taken) - 1, _COLUMNS).astype(int))]
        shape = picked[0].image.shape
        size = (3.0 * len(picked), 3.0 * shape[0] / shape[1] + 0.3)
        figure, axes = plt.subplots(
            1, len(picked), figsize=size, layout="constrained", squeeze=False
        )
        for panel, shot in zip(axes[0], picked, strict=True):
            panel.imshow(shot.image)
            panel.set_title(f"{shot.time_s:.1f} s", fontsize=9)
            panel.set_axis_off()
        path = folder / f"{topic.replace('/', '_')}.jpg"
        figure.savefig(path, dpi=80)
        plt.close(figure)
        pictures.append(Picture(path, topic))
    return pictures


def nearest_person(
    record: GoalRecord, outline: np.ndarray, torso: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return times, s, and the distance of the robot's outline to the nearest body then, m."""
    if not record.truth or not record.people:
        return np.zeros(0), np.zeros(0)
    stamps = np.array([stamp for stamp, _ in record.truth])
    rows = []
    for stamp, places in record.people:
        k = min(int(np.searchsorted(stamps, stamp)), len(stamps) - 1)
        gaps = gap_to(record.truth[k][1] @ outline, places) - torso
        rows.append((stamp * 1e-9, float(gaps.min(initial=np.inf))))
    return np.array(rows)[:, 0], np.array(rows)[:, 1]


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _draw_grid(
    axes: Any, grid: OccupancyMap | None, start: SE2, color: tuple[float, ...], *, has_free: bool
) -> None:
    from matplotlib.transforms import Affine2D

    if grid is None:
        return
    shades = np.zeros((*grid.cells.shape, 4))
    if has_free:
        shades[(grid.cells >= 0) & (grid.cells < OCCUPIED)] = 1.0
    shades[grid.cells >= OCCUPIED] = color
    rows, columns = grid.cells.shape
    T = start @ grid.origin
    extent = (0.0, columns * grid.resolution, 0.0, rows * grid.resolution)
    image = axes.imshow(shades, origin="lower", interpolation="nearest", extent=extent)
    image.set_transform(Affine2D().rotate(T.yaw).translate(T.x, T.y) + axes.transData)


def _draw_truth(axes: Any, solids: Sequence[Solid]) -> None:
    for solid in solids:
        corners = solid.outline()
        is_glass = solid.glass is not None
        closed = np.vstack((corners, corners[:1]))
        color, width = (GLASS, 1.6) if is_glass else ("#2b7de0", 0.5)
        axes.plot(*closed.T, color=color, lw=width, alpha=0.6)


def _draw_drive(axes: Any, world: World, record: GoalRecord, touches: np.ndarray) -> None:
    places = np.vstack([places for _, places in record.people] or [np.zeros((0, 2))])
    axes.plot(*places.T, ".", color=_PEOPLE, ms=1.6, alpha=0.5, label="people")
    way = record.way
    axes.plot(way[:, 1], way[:, 2], color=_ROBOT, lw=1.8, label="robot")
    assert world.goals is not None
    for number, (x, y) in enumerate(world.goals.points_m, 1):
        label = "goals" if number == 1 else None
        axes.plot(x, y, "o", ms=11, color="white", mec=_GOAL, label=label)
        axes.annotate(str(number), (x, y), ha="center", va="center", color=_GOAL, fontsize=8)
    label = "touched" if len(touches) else None
    axes.plot(*touches.T, "X", ms=10, color=_BAD, mec="white", label=label)


def _draw_states(axes: Any, record: GoalRecord) -> None:
    """Draw what state the planner was in as bands behind."""
    changes = [*((ns * 1e-9, state) for ns, state, _ in record.states), (record.sim_s, "")]
    named = set()
    for (begin, state), (end, _) in pairwise(changes):
        color = _STATE_COLORS.get(state)
        if color is not None and end > begin:
            label = None if state in named else state
            named.add(state)
            axes.axvspan(begin, end, color=color, alpha=0.35, lw=0, label=label)
