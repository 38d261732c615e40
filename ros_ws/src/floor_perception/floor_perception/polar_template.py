"""The template of I x J cells that a floor image is divided into (floor paper, 3.1, step 2).

Cells are sectors of rings on the floor around the point below the camera. For an upright mirror
they are sectors of rings in the image too; for a tilted camera only on the floor. Direction j has
its middle at the bearing -pi + 2 pi j / J, so that J even has one straight ahead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floor_perception.config import TemplateConfig
from floornav_common.floor_camera import FloorCamera

_NUM_SAMPLES = 4000
_NUM_BEARINGS = 36


@dataclass(frozen=True)
class PolarTemplate:
    """Which cell each pixel belongs to.

    Cells are numbered direction by direction, from the inside: k = j I + i.

    Attributes:
        edges: Borders of the rings on the floor, (I + 1,), m.
        num_directions: J.
        cells: Number of the cell of each pixel, -1 for none, (H, W), int16 or int32.
        areas: A_ij, pixels of each cell, (J I,), int32.
        stand_ins: The cell that decides for each cell: itself, or, for one too small to hold a
            pixel, the one that its middle lies in; -1 where the camera does not see it, (J I,).
        spans: First and past-last column of each row that has a cell, (H, 2), int32.
    """

    edges: np.ndarray
    num_directions: int
    cells: np.ndarray
    areas: np.ndarray
    stand_ins: np.ndarray
    spans: np.ndarray

    @property
    def num_rings(self) -> int:
        """Return I."""
        return len(self.edges) - 1

    @property
    def angle_increment(self) -> float:
        """Bearing between neighboring directions, rad."""
        return 2.0 * math.pi / self.num_directions

    @property
    def bearings(self) -> np.ndarray:
        """Bearing of the middle of each direction, (J,), rad, from -pi on."""
        return -math.pi + self.angle_increment * np.arange(self.num_directions)


def make_template(
    camera: FloorCamera, config: TemplateConfig, is_hidden: np.ndarray | None = None
) -> PolarTemplate:
    """Return the template for a camera.

    Args:
        camera: The camera at the images' size.
        config: Rings and directions.
        is_hidden: Pixels that see the robot or nothing of use, (H, W), bool.

    Raises:
        ValueError: The camera does not see the floor between the first and the last ring, or
            `is_hidden` has another size than the images.
    """
    edges = ring_edges(camera, config)
    pixels = np.stack(np.meshgrid(*map(np.arange, (camera.width_px, camera.height_px))), -1)
    is_seen = camera.seen_mask()
    if is_hidden is not None:
        if is_hidden.shape != is_seen.shape:
            raise ValueError(f"hidden mask must be {is_seen.shape}, got {is_hidden.shape}")
        is_seen = is_seen & ~is_hidden
    cells = cells_of(camera.floor_points(pixels.astype(float)), edges, config.num_directions)
    cells[~is_seen] = -1
    owner = cells.copy()
    if config.has_borders:
        cells[is_border(cells)] = -1
    num_cells = config.num_directions * config.num_rings
    areas = np.bincount(cells[cells >= 0], minlength=num_cells).astype(np.int32)
    small = cells.astype(np.int16) if num_cells < 2**15 else cells
    stand_ins = _stand_ins(camera, edges, config.num_directions, areas, owner)
    return PolarTemplate(
        edges, config.num_directions, small, areas, stand_ins, row_spans(cells >= 0)
    )


def cells_of(points: np.ndarray, edges: np.ndarray, num_directions: int) -> np.ndarray:
    """Return the cell of points on the floor (..., 2), -1 outside, int32."""
    x, y = points[..., 0], points[..., 1]
    distance = np.hypot(x, y)
    is_on_floor = np.isfinite(distance)
    bearing = np.arctan2(np.where(is_on_floor, y, 0.0), np.where(is_on_floor, x, 1.0))
    turn = num_directions / (2.0 * np.pi)
    j = np.floor((bearing + np.pi) * turn + 0.5).astype(np.int32) % num_directions
    i = np.searchsorted(edges, np.where(is_on_floor, distance, np.inf), side="right") - 1
    num_rings = len(edges) - 1
    return np.where((i >= 0) & (i < num_rings), j * num_rings + i, -1).astype(np.int32)


def ring_edges(camera: FloorCamera, config: TemplateConfig) -> np.ndarray:
    """Return the borders of the rings on the floor, (I + 1,), m.

    Rings of equal image radius are taken at the radius that a distance has on average over all
    bearings at which the camera sees it.

    Raises:
        ValueError: The camera sees the first or last ring nowhere.
    """
    low, high = config.range_min_m, config.horizon_m
    if config.spacing == "floor":
        return np.linspace(low, high, config.num_rings + 1)
    distances = np.geomspace(low, high, _NUM_SAMPLES)
    radii = image_radius(camera, distances)
    if not np.isfinite(radii[[0, -1]]).all():
        raise ValueError(
            f"the camera must see the floor from range_min_m = {low:g} to horizon_m = {high:g} m"
            + _seen_instead(distances[np.isfinite(radii)])
        )
    is_known = np.isfinite(radii)
    wanted = np.linspace(radii[0], radii[-1], config.num_rings + 1)
    rising = np.maximum.accumulate(radii[is_known])
    edges = np.interp(wanted, rising, distances[is_known])
    edges[[0, -1]] = low, high
    return np.asarray(edges)


def image_radius(camera: FloorCamera, distances: np.ndarray) -> np.ndarray:
    """Return the mean distance from the image's center at which the floor is seen, (N,), px."""
    angles = np.linspace(-np.pi, np.pi, _NUM_BEARINGS, endpoint=False)
    ways = np.stack((np.cos(angles), np.sin(angles)), -1)
    pixels = camera.floor_pixels(distances[:, None, None] * ways)
    radii = np.hypot(*np.moveaxis(pixels - np.asarray(camera.center_px), -1, 0))
    num = np.isfinite(radii).sum(axis=1)
    total = np.nansum(radii, axis=1)
    return np.where(num > 0, total / np.maximum(num, 1), np.nan)


def is_border(cells: np.ndarray) -> np.ndarray:
    """Return the pixels that must go so that no two cells touch, not even by corners, (H, W)."""
    padded = np.pad(cells, 1, mode="edge")
    own = padded[1:-1, 1:-1]
    later = (padded[1:-1, 2:], padded[2:, 1:-1], padded[2:, 2:], padded[2:, :-2])
    differs = np.zeros(cells.shape, dtype=bool)
    for other in later:
        differs |= (own >= 0) & (other >= 0) & (own != other)
    return differs


def row_spans(is_used: np.ndarray) -> np.ndarray:
    """Return the first and past-last column in use of each row, (H, 2), int32; 0, 0 for none."""
    has = is_used.any(axis=1)
    first = np.where(has, is_used.argmax(axis=1), 0)
    past = np.where(has, is_used.shape[1] - is_used[:, ::-1].argmax(axis=1), 0)
    return np.stack((first, past), -1).astype(np.int32)


def _stand_ins(
    camera: FloorCamera, edges: np.ndarray, J: int, areas: np.ndarray, owner: np.ndarray
) -> np.ndarray:
    stand_ins = np.arange(len(areas), dtype=np.int32)
    (empty,) = np.nonzero(areas == 0)
    num_rings = len(edges) - 1
    r = 0.5 * (edges[empty % num_rings] + edges[empty % num_rings + 1])
    bearing = -np.pi + 2.0 * np.pi / J * (empty // num_rings)
    pixels = camera.floor_pixels(np.stack((r * np.cos(bearing), r * np.sin(bearing)), -1))
    u, v = (np.rint(np.nan_to_num(pixels[:, k], nan=-1.0)).astype(int) for k in (0, 1))
    is_inside = (u >= 0) & (u < owner.shape[1]) & (v >= 0) & (v < owner.shape[0])
    found = np.full(len(empty), -1, dtype=np.int32)
    found[is_inside] = owner[v[is_inside], u[is_inside]]
    found[found >= 0] = np.where(areas[found[found >= 0]] > 0, found[found >= 0], -1)
    stand_ins[empty] = found
    return stand_ins


def _seen_instead(distances: np.ndarray) -> str:
    if not len(distances):
        return "; it sees none of that"
    return f"; it sees {distances[0]:.2f} to {distances[-1]:.2f} m: set template.* to that or less"
