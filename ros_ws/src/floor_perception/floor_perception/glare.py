"""Directions that end in glare: a light mirrored in the floor hides what is there.

A pixel saturated in all channels has no color: it may be a lamp's reflection on free floor or a
white thing overexposed. Such a direction is not seen, neither free nor blocked at a distance.
"""

from __future__ import annotations

import numba
import numpy as np

from floor_perception.polar_template import PolarTemplate

SATURATED = 252


class GlareFinder:
    """Says which directions end in a saturated cell.

    Args:
        template: The cells.
    """

    def __init__(self, template: PolarTemplate) -> None:
        flat = template.cells.ravel()
        order = np.argsort(flat, kind="stable")
        self._pixels = order[np.searchsorted(flat[order], 0) :].astype(np.int32)
        self._ends = np.concatenate(([0], np.cumsum(template.areas))).astype(np.int32)
        self._stand_ins = template.stand_ins

    def unseen(
        self, image: np.ndarray, ratios: np.ndarray, free_share: float, glare_share: float
    ) -> np.ndarray:
        """Return the directions whose first cell that is not free is glare, (J,), bool.

        Args:
            image: (H, W, 3), uint8.
            ratios: r_ij, (J, I).
            free_share: r_th.
            glare_share: More than this share of what is not floor in that cell must be saturated
                in all channels; 1 finds no glare.
        """
        is_glare = np.zeros(len(ratios), dtype=np.bool_)
        if glare_share == 1.0:
            return is_glare
        _find(
            image, ratios, free_share, glare_share, self._stand_ins, self._pixels, self._ends,
            is_glare,
        )  # fmt: skip
        return is_glare


@numba.njit(cache=True, error_model="numpy")
def _find(image, ratios, free_share, glare_share, stand_ins, pixels, ends, is_glare):  # type: ignore[no-untyped-def]
    width, num_rings = image.shape[1], ratios.shape[1]
    for j in range(len(ratios)):
        i = 0
        while i < num_rings and ratios[j, i] >= free_share:
            i += 1
        own = stand_ins[j * num_rings + i] if i < num_rings else -1
        if own < 0:
            continue
        num = 0
        for k in range(ends[own], ends[own + 1]):
            color = image[pixels[k] // width, pixels[k] % width]
            num += min(color[0], color[1], color[2]) >= SATURATED
        not_floor = (1.0 - ratios[j, i]) * (ends[own + 1] - ends[own])
        is_glare[j] = num > glare_share * not_floor
