"""A world cut into colored boxes in layers: what a map of it holds if nothing is measured wrong.

A box is occupied where a solid stands on its middle and takes at least half of its height: what is
thinner than half a layer, as a table's top, is not there. Floor and ceiling are a layer each. Panes
of glass and balls are left out; people and robots are not part of a world.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sim_bridge.scene import CEILING_COLOR
from sim_bridge.solids import Solid, solids_of
from sim_bridge.surface_samples import Samples, floor_samples, solid_samples
from sim_bridge.world import World

_EPS = 1e-6
_DEPTH_SHARE = 0.1  # of a cell: how far below the surface colors are taken


@dataclass(frozen=True, eq=False)
class WorldVoxels:
    """Boxes of one color each.

    Attributes:
        color: RGB, (layers, rows, columns, 3), uint8; rows along +y, columns along +x.
        occupied: (layers, rows, columns), bool.
        origin: Least x, y, z, m.
        left_out: Names of solids that are not in it.
    """

    color: np.ndarray
    occupied: np.ndarray
    origin: tuple[float, float, float]
    left_out: tuple[str, ...]


def world_voxels(world: World, cell: float, layer: float) -> WorldVoxels:
    """Return a world in boxes of `cell` x `cell` x `layer`, m, with one cell around its floor.

    The map reaches over the floor's picture or, without one, over all solids; from a layer below
    the floor to one above the ceiling or, without one, above the highest solid.

    Raises:
        ValueError: If there is nothing in the world.
    """
    solids = [s for s in solids_of(world) if s.glass is None and not s.is_ball]
    left_out = [s.name for s in solids_of(world) if s.glass is not None or s.is_ball]
    grid = _Grid(world, solids, cell, layer)
    for solid in solids:
        grid.fill(solid)
        grid.paint(solid_samples(solid, cell / 2.0, _DEPTH_SHARE * cell))
    floor = floor_samples(world, grid.low[:2], grid.high[:2], cell / 2.0)
    grid.paint(Samples(floor.points - (0.0, 0.0, layer / 2.0), floor.colors))
    origin = float(grid.low[0]), float(grid.low[1]), float(grid.low[2])
    return WorldVoxels(grid.colors(), grid.occupied, origin, tuple(dict.fromkeys(left_out)))


class _Grid:
    """Boxes that are filled, and the sums of the colors painted on them."""

    def __init__(self, world: World, solids: list[Solid], cell: float, layer: float) -> None:
        low, high = _extent(world, solids)
        top = world.ceiling_m
        if top is None:
            top = max((s.bottom + s.size[2] for s in solids), default=layer)
        counts = [math.ceil((b - a) / cell - _EPS) + 2 for a, b in zip(low, high, strict=True)]
        layers = math.ceil(top / layer - _EPS) + 1 + (world.ceiling_m is not None)
        self._edge = np.array([cell, cell, layer])
        self.low = np.array([low[0] - cell, low[1] - cell, -layer])
        self.high = self.low + self._edge * (counts[0], counts[1], layers)
        self._size = layers, counts[1], counts[0]
        self.occupied = np.zeros(self._size, dtype=bool)
        self._base = np.zeros((*self._size, 3), dtype=np.uint8)
        self._sums = np.zeros((*self._size, 4), dtype=np.float32)
        self.occupied[0] = True
        self._base[0] = _bytes(world.floor.color)
        if world.ceiling_m is not None:
            above = self._layers_of(top, math.inf)
            self.occupied[above], self._base[above] = True, _bytes(CEILING_COLOR)

    def fill(self, solid: Solid) -> None:
        """Mark what a solid takes."""
        layers = self._layers_of(solid.bottom, solid.bottom + solid.size[2])
        _, rows, columns = self._size
        corners = solid.outline()
        first, last = (
            np.clip(((c - self.low[:2]) / self._edge[:2]).astype(int) + k, 0, (columns, rows))
            for k, c in ((-1, corners.min(axis=0)), (2, corners.max(axis=0)))
        )
        x, y = (
            self.low[k] + (np.arange(first[k], last[k]) + 0.5) * self._edge[k] for k in range(2)
        )
        middles = np.stack(np.meshgrid(x, y), axis=-1)
        inside = (solid.signed_distance(middles.reshape(-1, 2)) <= 0.0).reshape(middles.shape[:2])
        window = layers, slice(first[1], last[1]), slice(first[0], last[0])
        self.occupied[window] |= inside
        self._base[window][:, inside] = _bytes(solid.color)

    def paint(self, samples: Samples) -> None:
        """Add the colors of points to the boxes they lie in."""
        _add(samples.points, samples.colors, self.low, self._edge, self._sums)

    def colors(self) -> np.ndarray:
        """Return the mean of what was painted, and each solid's own color where nothing was."""
        num = self._sums[..., 3]
        color, painted = self._base.copy(), num > 0.0
        color[painted] = _bytes(self._sums[painted][:, :3] / num[painted][:, None])
        color[~self.occupied] = 0
        return color

    def _layers_of(self, bottom: float, top: float) -> slice:
        """Return the layers that a thing between two heights takes half of or more."""
        layer = self._edge[2]
        feet = self.low[2] + layer * np.arange(self._size[0])
        taken = np.minimum(feet + layer, top) - np.maximum(feet, bottom)
        on = np.flatnonzero(taken >= layer / 2.0 - _EPS)
        return slice(int(on[0]), int(on[-1]) + 1) if len(on) else slice(0, 0)


def _extent(world: World, solids: list[Solid]) -> tuple[np.ndarray, np.ndarray]:
    floor = np.array([world.floor.from_m, world.floor.to_m])
    if (floor[1] > floor[0]).all():
        return floor[0], floor[1]
    if not solids:
        raise ValueError(f"the world {world.name!r} has neither a floor's picture nor solids")
    corners = np.vstack([solid.outline() for solid in solids])
    return corners.min(axis=0), corners.max(axis=0)


@numba.njit(cache=True, error_model="numpy")
def _add(points, colors, low, edge, sums):  # type: ignore[no-untyped-def]
    layers, rows, columns = sums.shape[:3]
    for n in range(len(points)):
        column = int(math.floor((points[n, 0] - low[0]) / edge[0]))
        row = int(math.floor((points[n, 1] - low[1]) / edge[1]))
        layer = int(math.floor((points[n, 2] - low[2]) / edge[2]))
        if 0 <= layer < layers and 0 <= row < rows and 0 <= column < columns:
            for k in range(3):
                sums[layer, row, column, k] += colors[n, k]
            sums[layer, row, column, 3] += 1.0


def _bytes(color: object) -> np.ndarray:
    return np.clip(np.rint(255.0 * np.asarray(color)), 0, 255).astype(np.uint8)
