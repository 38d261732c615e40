"""Pictures of `glass-map`: the paper's Fig. 4 to 7 and 9 from our maps, all rows of a world."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.glass_logs import GlassLog
from experiments.glass_methods import Mapped, Published, Track, mapped, placed, row_of
from experiments.glass_truth import Truth
from floornav_common.grid import OCCUPIED, OccupancyMap
from grid_mapper.overlay import EVEN, on_cells_of
from grid_mapper.recordings.events import ScanEvent
from sim_bridge.drawing import draw_solids

_FREE, _UNKNOWN, _WALL, _GLASS = (
    (1.0, 1.0, 1.0), (0.80, 0.82, 0.84), (0.10, 0.12, 0.15), (0.85, 0.15, 0.15)
)  # fmt: skip
_MARGIN_M = 0.7
_DPI = 110


def write_figures(path: Path, log: GlassLog, truth: Truth, track: Track, rule: Published) -> None:
    """Draw points, sampled maps, judged maps and their overlay, as the paper's Fig. 4 to 7."""
    config, takes = rule.config, rule.takes(log)
    raw = mapped(log, replace(config, label=replace(config.label, noise_points=0)), track, takes)
    done = mapped(log, config, track, takes)
    layers = done.layers()
    hits = _only_hits(layers.sonar)
    figure, grid = _sheet(truth, 7, columns=2)
    panels = iter(grid)
    lasers, echoes = _points(log, track, takes)
    for points, name in ((lasers, "4a: laser points"), (echoes, "4b: sonar echoes")):
        axes = _panel(next(panels), truth, name)
        axes.plot(*points.T, ".", color="black", ms=0.8, zorder=5)
    _draw_map(_panel(next(panels), truth, "5a: laser, sampled"), raw.laser_map(), None)
    _draw_points(_panel(next(panels), truth, "5b: sonar, points"), done)
    _draw_map(_panel(next(panels), truth, "6a: laser, noise removed"), layers.laser, None)
    _draw_map(_panel(next(panels), truth, "6b: sonar, P_S and more"), hits, None)
    row = row_of(done)
    _draw_map(_panel(next(panels), truth, "7, 9: overlay, red: sonar"), row.occupancy, row.glass)
    _save(path, figure)


def write_rows(path: Path, truth: Truth, rows: dict[str, Mapped | None]) -> None:
    """Draw the world and the map of every row, what it says is glass in red."""
    figure, grid = _sheet(truth, len(rows) + 1, columns=2)
    axes = _panel(grid[0], truth, "truth: glass blue, way of the robot green")
    draw_solids(axes, truth.solids)
    axes.plot(*truth.path.T, color="#1a7f4b", lw=1.0, zorder=6)
    faced = truth.glass[truth.is_faced]
    axes.plot(*faced.T, ".", color="#0b4f8a", ms=1.6, zorder=7, label="faced 3 times or more")
    for axes, (name, row) in zip(grid[1:], rows.items(), strict=False):
        _panel(axes, truth, name if row else f"{name}: not available")
        if row is not None:
            _draw_map(axes, row.occupancy, row.glass)
    _save(path, figure)


def _points(
    log: GlassLog, track: Track, takes: Callable[[Any], bool]
) -> tuple[np.ndarray, np.ndarray]:
    """Return points of the key scans, and echoes on the axis of their sonar, in the map."""
    lasers, echoes = [], []
    for event, pose in placed(log, track):
        if not isinstance(event, ScanEvent):
            if event.reading.is_hit:
                T = pose @ event.T_base_sonar
                echoes.append(T @ np.array([[event.range, 0.0]]))
        elif takes(event):
            lasers.append((pose @ event.T_base_laser) @ event.scan.points())
    return np.vstack(lasers), np.vstack(echoes)


def _only_hits(sonar: OccupancyMap) -> OccupancyMap:
    cells = np.where(sonar.cells >= EVEN, np.int8(OCCUPIED), np.int8(0))
    return OccupancyMap(cells, sonar.resolution, sonar.origin)


def _draw_map(axes: Any, occupancy: OccupancyMap, glass: OccupancyMap | None) -> None:
    cells = occupancy.cells
    image = np.empty((*cells.shape, 3))
    image[:] = _UNKNOWN
    image[(cells >= 0) & (cells < EVEN)] = _FREE
    image[cells >= EVEN] = _WALL
    if glass is not None:
        image[(on_cells_of(glass, occupancy) >= EVEN) & (cells >= EVEN)] = _GLASS
    _show(axes, image, occupancy)


def _draw_points(axes: Any, mapper: Any) -> None:
    points, origin = mapper.sonar_points()
    most = mapper.config.sonar.min_points
    gray = 1.0 - np.minimum(points / most, 1.0)
    like = OccupancyMap(np.zeros(points.shape, np.int8), mapper.config.resolution_m, origin)
    _show(axes, np.repeat(gray[..., None], 3, axis=2), like)


def _show(axes: Any, image: np.ndarray, like: OccupancyMap) -> None:
    low = (like.origin.x, like.origin.y)
    high = np.array(low) + like.resolution * np.array(image.shape[1::-1])
    limits = axes.get_xlim(), axes.get_ylim()
    extent = (low[0], high[0], low[1], high[1])
    axes.imshow(image, origin="lower", extent=extent, interpolation="nearest", zorder=0)
    axes.set(xlim=limits[0], ylim=limits[1])


def _sheet(truth: Truth, num: int, columns: int) -> tuple[Any, list[Any]]:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    low, high = _corners(truth)
    rows = -(-num // columns)
    width = 6.0
    height = width * float((high - low)[1] / (high - low)[0]) + 0.3
    figure, grid = plt.subplots(
        rows, columns, figsize=(columns * width, rows * height), layout="constrained"
    )
    for axes in grid.flat[num:]:
        axes.set_axis_off()
    return figure, list(grid.flat[:num])


def _panel(axes: Any, truth: Truth, title: str) -> Any:
    low, high = _corners(truth)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, fontsize=10)
    for x1, y1, x2, y2 in truth.panes:
        axes.plot((x1, x2), (y1, y2), color="#31b5d6", lw=0.7, zorder=4)
    return axes


def _corners(truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    points = truth.opaque.reshape(-1, 2)
    return points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M


def _save(path: Path, figure: Any) -> None:
    import matplotlib.pyplot as plt

    figure.savefig(path, dpi=_DPI)
    plt.close(figure)
