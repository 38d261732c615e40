"""The color of the floor looked up for every pixel of an image.

Where the paper is silent (step 1 says only "extract the floor's color") this is what robots in the
field do: a table over the color cube that is filled once and read for each pixel.
"""

from __future__ import annotations

import numba
import numpy as np

from floor_perception.color_model import FloorColor, bounds
from floor_perception.config import ColorConfig

TABLE_EDGE = 64  # colors of 6 bits a channel
_STEP = 256 // TABLE_EDGE


def color_table(color: FloorColor, config: ColorConfig, order: str = "rgb") -> np.ndarray:
    """Return 255 for each color of the cube that is the floor's, else 0, (64^3,), uint8.

    Args:
        color: The floor's.
        config: How near a color must be.
        order: Of the channels in the images: `rgb` or `bgr`.

    In the dark the sensor's noise widens chromaticities: the gate grows as 1 / brightness.
    """
    table = np.empty(TABLE_EDGE**3, dtype=np.uint8)
    info = np.linalg.inv(color.cov)
    low, high = bounds(color, config)
    totals = _STEP * (np.arange(3 * TABLE_EDGE - 2) + 1.5)
    gates = config.gate_sd**2 * np.maximum(1.0, color.middle / totals)
    gates[(totals < low) | (totals > high)] = -1.0
    _fill(
        table, order == "bgr", *color.chroma, info[0, 0], info[0, 1], info[1, 1], 1.0 / totals,
        gates,
    )  # fmt: skip
    return table


def classify(
    image: np.ndarray, table: np.ndarray, spans: np.ndarray, always: np.ndarray, mask: np.ndarray
) -> None:
    """Look up the pixels of an image within the spans of its rows.

    Args:
        image: (H, W, 3), uint8.
        table: From `color_table`.
        spans: First and past-last column of each row, (H, 2).
        always: 255 where a pixel counts as floor whatever its color, else 0, (H, W), uint8.
        mask: Filled within the spans, (H, W), uint8.
    """
    _look_up(image, table, spans, always, mask)


@numba.njit(cache=True, error_model="numpy")
def _fill(table, is_bgr, r0, g0, irr, irg, igg, inverses, gates):  # type: ignore[no-untyped-def]
    """Fill the table; what depends on the brightness alone is given for each sum of indices."""
    for a in range(TABLE_EDGE):
        for b in range(TABLE_EDGE):
            row = table[(a * TABLE_EDGE + b) * TABLE_EDGE :][:TABLE_EDGE]
            inverse, gate = inverses[a + b :], gates[a + b :]
            green, first = (b + 0.5) * _STEP, (a + 0.5) * _STEP
            for c in range(TABLE_EDGE):
                red = (c + 0.5) * _STEP if is_bgr else first
                dr, dg = red * inverse[c] - r0, green * inverse[c] - g0
                d2 = irr * dr * dr + 2.0 * irg * dr * dg + igg * dg * dg
                row[c] = 255 if d2 < gate[c] else 0


@numba.njit(cache=True, error_model="numpy")
def _look_up(image, table, spans, always, mask):  # type: ignore[no-untyped-def]
    two, six, twelve = np.uint32(2), np.uint32(6), np.uint32(12)
    for v in range(mask.shape[0]):
        row, out, over = image[v], mask[v], always[v]
        for u in range(spans[v, 0], spans[v, 1]):
            a, b, c = np.uint32(row[u, 0]), np.uint32(row[u, 1]), np.uint32(row[u, 2])
            out[u] = table[(a >> two) << twelve | (b >> two) << six | c >> two] | over[u]
