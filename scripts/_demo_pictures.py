"""Pictures of a demo run: its map with trajectories and truth, errors, and what cameras see."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from _demo_report import OCCUPIED, errors, in_world
from _demo_watch import Heard
from floornav_common.reporting import Picture
from floornav_common.se2 import SE2
from sim_bridge.drawing import draw_panes
from sim_bridge.simulation import Simulation
from sim_bridge.solids import Solid

_FIRST_STEPS, _MARGIN_M = 30, 0.35
_TRUE, _EST, _ODO = "#1a7f4b", "#e0641a", "#8a5cc2"


def write_pictures(out: Path, heard: Heard, start: SE2, solids: list[Solid], height: float) -> None:
    """Draw `map.png` (map, trajectories, true outline) and `errors.png` (error over time)."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=_size_of(solids), layout="constrained")
    _draw_map(axes, heard, start)
    _draw_outline(axes, solids, height)
    _draw_tracks(axes, heard, start)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    low, high = _extent(solids)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    for side in axes.spines.values():
        side.set_visible(False)
    figure.legend(loc="outside upper center", ncols=7, frameon=False, fontsize=12)
    figure.savefig(out / "map.png", dpi=110)
    plt.close(figure)

    figure, axes = plt.subplots(figsize=(12.0, 3.6), layout="constrained")
    for track, color, name in (
        (heard.odometry, _ODO, "odometry alone"),
        (heard.estimate, _EST, "grid_mapper"),
    ):
        rows = errors(in_world(track, start), heard.truth)
        axes.semilogy(rows[:, 0], np.maximum(rows[:, 1], 1e-4), color=color, label=name, lw=1.6)
    axes.set(xlabel="simulated time [s]", ylabel="position error [m]")
    axes.grid(alpha=0.25, which="both")
    axes.legend(frameon=False, ncols=2, loc="lower right")
    figure.savefig(out / "errors.png", dpi=110)
    plt.close(figure)


def write_overview(path: Path, image: np.ndarray) -> None:
    """Write a picture, shape (H, W, 3), RGB uint8."""
    from matplotlib.image import imsave

    imsave(path, image)


def write_first_images(out: Path, simulation: Simulation) -> list[Picture]:
    """Write the first image of every camera of a simulation's robots; [] without cameras."""
    images: dict[str, np.ndarray] = {}
    for _ in range(_FIRST_STEPS):
        seen = next(iter(simulation.step({}).robots.values()))
        if seen.omni is not None:
            images.setdefault("omni/image_raw", seen.omni)
        for pair, both in (seen.stereo or {}).items():
            images.setdefault(f"stereo/{pair}/left/image_rect", both.left)
            images.setdefault(f"stereo/{pair}/right/image_rect", both.right)
    pictures = []
    for topic, image in images.items():
        path = out / f"{topic.replace('/', '_')}.png"
        write_overview(path, image)
        pictures.append(
            Picture(path, f"{topic}, {image.shape[1]} x {image.shape[0]}, at the start")
        )
    return pictures


def _draw_map(axes: Any, heard: Heard, start: SE2) -> None:
    from matplotlib.transforms import Affine2D

    axes.set_facecolor("#d9dde2")
    if heard.grid is None:
        return
    grid = heard.grid
    shades = np.full((*grid.cells.shape, 4), 0.0)
    shades[(grid.cells >= 0) & (grid.cells < OCCUPIED)] = (1.0, 1.0, 1.0, 1.0)
    shades[grid.cells >= OCCUPIED] = (0.07, 0.09, 0.12, 1.0)
    rows, columns = grid.cells.shape
    T = start @ grid.origin
    image = axes.imshow(
        shades, origin="lower", interpolation="nearest",
        extent=(0.0, columns * grid.resolution, 0.0, rows * grid.resolution),
    )  # fmt: skip
    image.set_transform(Affine2D().rotate(T.yaw).translate(T.x, T.y) + axes.transData)


def _draw_outline(axes: Any, solids: list[Solid], height: float) -> None:
    draw_panes(axes, solids)
    has_label = {True: False, False: False}
    for solid in (solid for solid in solids if solid.glass is None):
        corners = solid.outline()
        closed = np.vstack((corners, corners[:1]))
        is_seen = solid.is_at_height(height)
        label = None if has_label[is_seen] else "true outline" if is_seen else "above or below"
        has_label[is_seen] = True
        width, alpha, style = (1.0, 0.85, "-") if is_seen else (0.8, 0.5, ":")
        axes.plot(*closed.T, style, color="#2b7de0", lw=width, alpha=alpha, label=label)


def _draw_tracks(axes: Any, heard: Heard, start: SE2) -> None:
    for track, color, style, width, name in (
        (in_world(heard.odometry, start), _ODO, "--", 1.4, "odometry alone"),
        (heard.truth, _TRUE, "-", 4.0, "true path"),
        (in_world(heard.estimate, start), _EST, "-", 1.5, "grid_mapper"),
    ):
        if track:
            points = np.array([(pose.x, pose.y) for _, pose in track])
            axes.plot(*points.T, color=color, ls=style, lw=width, label=name)
    axes.plot(start.x, start.y, "o", ms=9, color=_TRUE, mec="white", label="start")


def _extent(solids: list[Solid]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner of the map's picture, m."""
    corners = np.vstack([solid.outline() for solid in solids])
    return corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M


def _size_of(solids: list[Solid]) -> tuple[float, float]:
    """Return the size of a figure that a map in equal scales fills, inches."""
    low, high = _extent(solids)
    width, height = high - low
    share = float(height / width)
    wide = min(12.0, 10.0 / share)
    return max(wide, 7.0), max(wide * share, 3.0) + 0.9  # axis labels and legend
