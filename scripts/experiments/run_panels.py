"""Pictures of runs beside each other, seen from above."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

_WORDS_IN = 0.4
"""Height that a title takes, inches."""


def draw_panels(
    path: Path, low: np.ndarray, high: np.ndarray, panels: Mapping[str, Callable[[Any], None]],
    columns: int, width_in: float,
) -> None:  # fmt: skip
    """Write a picture with a panel a run.

    Args:
        path: To write to.
        low: Least x and y shown, m.
        high: Greatest x and y shown, m.
        panels: What draws on the axes of each, by its title.
        columns: Panels beside each other.
        width_in: Of a panel, inches.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    rows = -(-len(panels) // columns)
    height = width_in * (high[1] - low[1]) / (high[0] - low[0]) + _WORDS_IN
    size = (width_in * columns, height * rows)
    figure, all_axes = plt.subplots(
        rows, columns, figsize=size, squeeze=False, layout="constrained"
    )
    for axes in all_axes.flat:
        axes.set_axis_off()
    for axes, (title, draw) in zip(all_axes.flat, panels.items(), strict=False):
        draw(axes)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_aspect("equal")
        axes.set_title(title, fontsize=9)
    figure.savefig(path, dpi=80)
    plt.close(figure)
