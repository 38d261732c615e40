"""Free space around the robot from a floor mask (floor paper, 3.1, steps 2 to 4, eq. 7 to 9).

The published route cuts the mask with the template, labels what is left and adds the areas of
the regions whose middle p_k lies in a cell. `labelled_areas` does that but for one thing: a region
counts for the cell that its pixels lie in. Its middle lies there too unless the region is bent
round something, and then eq. 7 as printed would add its area to a cell that it does not touch.
`floor_areas` counts pixels cell by cell instead: the same numbers several times faster.
"""

from __future__ import annotations

import cv2
import numba
import numpy as np

from floor_perception.polar_template import PolarTemplate, is_border

FREE, NOT_SEEN, TOO_NEAR = np.inf, np.nan, -np.inf


def floor_areas(mask: np.ndarray, template: PolarTemplate) -> np.ndarray:
    """Return the pixels of floor in each cell, (J I,), int32.

    Args:
        mask: 255 where the floor is, else 0, (H, W), uint8.
        template: The cells.
    """
    areas = np.zeros(len(template.areas), dtype=np.int32)
    _count(mask, template.cells, template.spans, areas)
    return areas


def labelled_areas(mask: np.ndarray, template: PolarTemplate) -> np.ndarray:
    """Return the same by labelling (steps 2 and 3, p_k as said above), (J I,), int32.

    With border lines between the cells (`has_borders`) one labelling does. Without them regions of
    neighboring cells would grow together, so each cell is cut out and labelled alone.
    """
    areas = np.zeros(len(template.areas), dtype=np.int32)
    if not is_border(template.cells.astype(np.int32)).any():
        _add_regions(mask, template.cells, template.cells >= 0, areas)
        return areas
    for cell, box in enumerate(_boxes(template)):
        if box is not None:
            own = template.cells[box]
            _add_regions(mask[box], own, own == cell, areas)
    return areas


def _boxes(template: PolarTemplate) -> list[tuple[slice, slice] | None]:
    """Return rows and columns that each cell lies in; None for one without pixels."""
    rows, columns = np.nonzero(template.cells >= 0)
    cells = template.cells[rows, columns]
    ends = np.full((len(template.areas), 4), (1 << 30, -1, 1 << 30, -1))
    for k, (reduce, where) in enumerate(
        ((np.minimum, rows), (np.maximum, rows), (np.minimum, columns), (np.maximum, columns))
    ):
        reduce.at(ends[:, k], cells, where)
    return [
        (slice(top, bottom + 1), slice(left, right + 1)) if bottom >= 0 else None
        for top, bottom, left, right in ends.tolist()
    ]


def _add_regions(mask: np.ndarray, cells: np.ndarray, cut: np.ndarray, areas: np.ndarray) -> None:
    """Add the areas a_k of the regions of floor under a template to their cells' (eq. 7)."""
    num, labels = cv2.connectedComponents(np.where(cut, mask, 0).astype(np.uint8), connectivity=8)
    a_k = np.bincount(labels.ravel(), minlength=num)
    # A region lies in one cell as a whole: any pixel says which; a bent one's middle may not.
    a_pixel = np.zeros(num, dtype=np.int64)
    a_pixel[labels.ravel()] = np.arange(labels.size)
    np.add.at(areas, cells.ravel()[a_pixel[1:]], a_k[1:].astype(np.int32))


def free_ratios(floor: np.ndarray, template: PolarTemplate) -> np.ndarray:
    """Return r_ij, the share of floor in each cell, (J, I); NaN where it is not seen (eq. 7)."""
    ratios = np.where(template.areas > 0, floor / np.maximum(template.areas, 1), np.nan)
    ratios = np.where(template.stand_ins >= 0, ratios[template.stand_ins], np.nan)
    return ratios.reshape(template.num_directions, template.num_rings)


def nearest_blocked(ratios: np.ndarray, free_share: float) -> np.ndarray:
    """Return a_j, the number of free cells before the first that is not (eq. 8 and 9), (J,).

    A cell that is not seen (NaN) is not free.
    """
    q = np.column_stack((ratios >= free_share, np.zeros(len(ratios), dtype=bool)))
    return np.asarray((~q).argmax(axis=1))


def free_ranges(ratios: np.ndarray, free_share: float, edges: np.ndarray) -> np.ndarray:
    """Return how far the floor is free in each direction, (J,), m.

    Said is the inner border of the first cell that is not free: `inf` up to the horizon, NaN where
    a cell is not seen before that. `-inf`, in REP 117 too near to measure, where not even the first
    cell is free: what stands there may begin under the robot or anywhere in that cell, and its
    border, `range_min`, would promise floor that nobody has seen.
    """
    a = nearest_blocked(ratios, free_share)
    num_rings = ratios.shape[1]
    ranges = edges[a].astype(float)
    ranges[a == 0] = TOO_NEAR
    ranges[a == num_rings] = FREE
    stop = np.minimum(a, num_rings - 1)
    is_unseen = (a < num_rings) & np.isnan(ratios[np.arange(len(a)), stop])
    ranges[is_unseen] = NOT_SEEN
    return ranges


def ratios_and_ranges(
    floor: np.ndarray, template: PolarTemplate, free_share: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return what `free_ratios` and `free_ranges` do, (J, I) and (J,), m, in one pass."""
    ratios = np.empty((template.num_directions, template.num_rings))
    ranges = np.empty(template.num_directions)
    _walk(
        floor, template.areas, template.stand_ins, free_share, template.edges, ratios, ranges
    )  # fmt: skip
    return ratios, ranges


@numba.njit(cache=True, error_model="numpy")
def _walk(floor, areas, stand_ins, free_share, edges, ratios, ranges):  # type: ignore[no-untyped-def]
    num_directions, num_rings = ratios.shape
    for j in range(num_directions):
        first = num_rings
        for i in range(num_rings):
            own = stand_ins[j * num_rings + i]
            ratio = np.nan
            if own >= 0 and areas[own] > 0:
                ratio = floor[own] / areas[own]
            ratios[j, i] = ratio
            if first == num_rings and not ratio >= free_share:
                first = i
        if first == num_rings:
            ranges[j] = np.inf
        elif np.isnan(ratios[j, first]):
            ranges[j] = np.nan
        else:
            ranges[j] = edges[first] if first > 0 else -np.inf


@numba.njit(cache=True, error_model="numpy")
def _count(mask, cells, spans, areas):  # type: ignore[no-untyped-def]
    for v in range(mask.shape[0]):
        for u in range(spans[v, 0], spans[v, 1]):
            cell = cells[v, u]
            if cell >= 0:
                areas[cell] += mask[v, u] & 1
