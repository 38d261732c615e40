"""The picture of a mapping run: map, way and scale, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import Any

import numpy as np

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2

MARGIN_M = 1.0
WIDTH_INCH, TITLE_INCH, LEGEND_INCH = 10.0, 0.4, 0.4
MIN_ASPECT, MAX_ASPECT = 0.3, 1.6
"""Of height to width; a longer or thinner map gets more of what is unknown around it."""
DPI = 150
GLASS_COLOR = "#d95f02"
SHADE_UNKNOWN, SHADE_FREE, SHADE_OCCUPIED = 0.82, 1.0, 0.05
ROUND_LENGTHS_M = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)


def draw_map(
    occupancy: OccupancyMap,
    trajectory: Sequence[tuple[int, SE2]],
    title: str,
    glass: OccupancyMap | None = None,
) -> bytes:
    """Return a PNG of a map with the robot's way, its ends marked, and a scale bar.

    Args:
        occupancy: The map.
        trajectory: Stamps and poses.
        title: Line above.
        glass: Layer whose obstacles are drawn in color.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    left, bottom, right, top = _bounds(occupancy, trajectory)
    map_inch = WIDTH_INCH * (top - bottom) / (right - left)
    height_inch = TITLE_INCH + map_inch + LEGEND_INCH
    figure = Figure(figsize=(WIDTH_INCH, height_inch), dpi=DPI)
    axes = figure.add_axes((0.01, LEGEND_INCH / height_inch, 0.98, map_inch / height_inch))
    _draw_cells(axes, occupancy)
    has_glass = glass is not None and _draw_glass(axes, glass)
    _draw_way(axes, trajectory)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")
    axes.set_facecolor(str(SHADE_UNKNOWN))
    axes.set_xticks([])
    axes.set_yticks([])
    _draw_scale(axes, left, bottom, right - left, top - bottom)
    _draw_legend(figure, axes, has_glass)
    figure.text(
        0.5, 1.0 - 0.5 * TITLE_INCH / height_inch, title, fontsize=11, ha="center", va="center"
    )
    out = BytesIO()
    FigureCanvasAgg(figure).print_png(out, metadata={"Software": None})
    return out.getvalue()


def _draw_cells(axes: Any, occupancy: OccupancyMap) -> None:
    """Draw the cells in shades, turned as the map is."""
    from matplotlib.transforms import Affine2D

    rows, columns = occupancy.cells.shape
    size = (0.0, columns * occupancy.resolution, 0.0, rows * occupancy.resolution)
    origin = occupancy.origin
    place = Affine2D().rotate(origin.yaw).translate(origin.x, origin.y) + axes.transData
    axes.imshow(
        _shades(occupancy), cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=size,
        transform=place, interpolation="antialiased",
    )  # fmt: skip


def _shades(occupancy: OccupancyMap) -> np.ndarray:
    cells = occupancy.cells.astype(np.float64)
    share = (cells - FREE) / 100.0
    shades = SHADE_FREE + share * (SHADE_OCCUPIED - SHADE_FREE)
    shades[occupancy.cells == UNKNOWN] = SHADE_UNKNOWN
    return shades


def _bounds(
    occupancy: OccupancyMap, trajectory: Sequence[tuple[int, SE2]]
) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of the picture: what is known, with a margin, m."""
    known = np.argwhere(occupancy.cells != UNKNOWN)
    points = [occupancy.to_points(known)] if len(known) else []
    if trajectory:
        points.append(np.array([[pose.x, pose.y] for _, pose in trajectory]))
    if not points:
        return (-MARGIN_M, -MARGIN_M, MARGIN_M, MARGIN_M)
    low = np.min([p.min(axis=0) for p in points], axis=0) - MARGIN_M
    high = np.max([p.max(axis=0) for p in points], axis=0) + MARGIN_M
    middle, size = (low + high) / 2.0, high - low
    width = max(size[0], size[1] / MAX_ASPECT)
    half = np.array([width, max(size[1], width * MIN_ASPECT)]) / 2.0
    (left, bottom), (right, top) = middle - half, middle + half
    return float(left), float(bottom), float(right), float(top)


def _draw_way(axes: Any, trajectory: Sequence[tuple[int, SE2]]) -> None:
    if not trajectory:
        return
    way = np.array([[pose.x, pose.y] for _, pose in trajectory])
    axes.plot(way[:, 0], way[:, 1], color="#1f6fd1", linewidth=1.0, alpha=0.9, label="robot's path")
    for point, color, label in ((way[0], "#1a7f4b", "start"), (way[-1], "#b3261e", "end")):
        axes.plot(*point, "o", color=color, markersize=5, label=label)


def _draw_glass(axes: Any, glass: OccupancyMap) -> bool:
    """Color the cells of glass; False if there are none."""
    from matplotlib.collections import PolyCollection

    cells = np.argwhere(glass.cells == OCCUPIED)
    if not len(cells):
        return False
    corners = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])
    points = glass.origin @ ((cells[:, None, ::-1] + corners).reshape(-1, 2) * glass.resolution)
    squares = points.reshape(-1, 4, 2)
    axes.add_collection(PolyCollection(squares, facecolors=GLASS_COLOR, edgecolors="none"))
    return True


def _draw_legend(figure: Any, axes: Any, has_glass: bool) -> None:
    """Say below the map what its lines and shades are."""
    from matplotlib.patches import Patch

    shades = [
        ("obstacle", str(SHADE_OCCUPIED)), ("free", str(SHADE_FREE)),
        ("unknown", str(SHADE_UNKNOWN)),
    ]  # fmt: skip
    shades += [("glass, by sonar", GLASS_COLOR)] if has_glass else []
    lines, names = axes.get_legend_handles_labels()
    patches = [Patch(facecolor=shade, edgecolor="black", label=n) for n, shade in shades]
    figure.legend(
        [*lines, *patches], [*names, *(name for name, _ in shades)], loc="lower center",
        ncols=7, fontsize=9, frameon=False,
    )  # fmt: skip


def _draw_scale(axes: Any, left: float, bottom: float, width: float, height: float) -> None:
    """Draw a bar of a round length, at most a quarter of the picture, and write the length."""
    fitting = [length for length in ROUND_LENGTHS_M if length <= width / 4.0]
    length = fitting[-1] if fitting else ROUND_LENGTHS_M[0]
    x, y = left + 0.03 * width, bottom + 0.03 * height
    axes.plot([x, x + length], [y, y], color="black", linewidth=3)
    backing = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axes.text(x, y + 0.015 * height, f"{length:g} m", fontsize=9, bbox=backing)
