"""A voxel map from posed views with distances: truncated signed distances, averaged (Curless 1996).

Each layer is cut into thinner slices. Every point of a slice is looked up in every view: how far it
is in front of what the view shows there, along the camera's axis, at most `band`. The mean of that
over the views is positive in free space and negative behind surfaces, and errors of single views
average out. A voxel is occupied where points of it are behind a surface and not less of them than
in front of one; where no view looks, nothing is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numba
import numpy as np

from multi_localizer.voxel_map import VoxelMap

_SLICE_M = 0.04
MOST_VOXELS = 5 * 10**8
"""2 GB."""


@dataclass(frozen=True, eq=False)
class PosedView:
    """Colors and distances that one camera saw.

    Attributes:
        T_map_camera: Pose of the optical frame (x right, y down, z along the view), (4, 4).
        color: RGB, (H, W, 3), uint8.
        depth: Distance along z, (H, W), m; NaN where unknown.
        focal_px: Along u and v.
        center_px: Principal point (u, v).
    """

    T_map_camera: np.ndarray
    color: np.ndarray
    depth: np.ndarray
    focal_px: tuple[float, float]
    center_px: tuple[float, float]

    def __post_init__(self) -> None:
        if self.color.shape != (*self.depth.shape, 3) or self.color.dtype != np.uint8:
            raise ValueError(
                f"color must be {(*self.depth.shape, 3)} uint8, got {self.color.shape} "
                f"{self.color.dtype}"
            )
        if self.T_map_camera.shape != (4, 4):
            raise ValueError(f"T_map_camera must be (4, 4), got {self.T_map_camera.shape}")


@dataclass(frozen=True, kw_only=True)
class FusionSettings:
    """How views become a map.

    Attributes:
        cell_m: Edge of a voxel along x and y.
        layer_m: Its height; z = 0 is between two layers.
        band_m: Distances count up to so much in front of and behind a surface.
        max_depth_m: What a view says of farther things is not used.
        error_grows: True where errors grow with the square of the distance, as those of stereo do:
            a view then weighs with the inverse of its fourth power.
        frame: Name of the map's frame.
    """

    cell_m: float = 0.01
    layer_m: float = 0.16
    band_m: float = 0.08
    max_depth_m: float = 4.0
    error_grows: bool = False
    frame: str = "map"

    def __post_init__(self) -> None:
        for name in ("cell_m", "layer_m", "band_m", "max_depth_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")


def extent_of(views: Sequence[PosedView], max_depth_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest corner (x, y, z) of what the views show.

    One point in a thousand on each side is left out.

    Raises:
        ValueError: If no view shows anything.
    """
    parts = []
    for view in views:
        v, u = np.mgrid[: view.depth.shape[0] : 4, : view.depth.shape[1] : 4]
        depth = view.depth[::4, ::4]
        known = np.isfinite(depth) & (depth > 0.0) & (depth <= max_depth_m)
        z = depth[known]
        x = (u[known] - view.center_px[0]) / view.focal_px[0] * z
        y = (v[known] - view.center_px[1]) / view.focal_px[1] * z
        T = view.T_map_camera
        parts.append(np.column_stack((x, y, z)) @ T[:3, :3].T + T[:3, 3])
    points = np.vstack(parts) if parts else np.empty((0, 3))
    if not len(points):
        raise ValueError("views show nothing: no distance is known")
    low, high = np.percentile(points, (0.1, 99.9), axis=0)
    return low, high


def fuse_views(
    views: Sequence[PosedView],
    low: np.ndarray,
    high: np.ndarray,
    settings: FusionSettings,
    on_layer: Callable[[int, int], None] = lambda done, total: None,
) -> VoxelMap:
    """Return the map that views of one size make.

    Args:
        views: At least one.
        low: Corner (x, y, z) from which the map reaches, m; `band_m` and a cell or layer more are
            added, as a wall that stands there is found somewhat before or behind.
        high: The opposite corner.
        settings: Sizes and trust.
        on_layer: Called after each layer with how many are done, and of how many.

    Raises:
        ValueError: If there are no views, their sizes differ, the corners are not in order, or the
            map would not fit into memory.
    """
    if not views or len({view.depth.shape for view in views}) > 1:
        raise ValueError(f"views must be at least one, all of one size, got {len(views)}")
    edge = np.array([settings.cell_m, settings.cell_m, settings.layer_m])
    if not (np.asarray(low) <= np.asarray(high)).all():
        raise ValueError(f"low must be below high, got {list(low)} and {list(high)}")
    first = np.floor((np.asarray(low) - settings.band_m) / edge - 0.5)
    last = np.ceil((np.asarray(high) + settings.band_m) / edge + 0.5)
    columns, rows, layers = (int(n) for n in last - first)
    if columns * rows * layers > MOST_VOXELS:
        raise ValueError(
            f"{columns} x {rows} x {layers} voxels are too many, at most {MOST_VOXELS:.0e}: cells "
            "and layers must be larger, or what the map reaches over smaller"
        )
    color = np.zeros((layers, rows, columns, 3), dtype=np.uint8)
    occupied = np.zeros((layers, rows, columns), dtype=np.bool_)
    stacks = _stacked(views)
    num_slices = max(2, math.ceil(settings.layer_m / _SLICE_M))
    for layer in range(layers):
        corner = (first + (0, 0, layer)) * edge
        _fuse_layer(
            *stacks, corner, edge, num_slices, settings.band_m, settings.max_depth_m,
            settings.error_grows, color[layer], occupied[layer],
        )  # fmt: skip
        on_layer(layer + 1, layers)
    x, y, z = (first * edge).tolist()
    return VoxelMap(color, occupied, settings.cell_m, settings.layer_m, x, y, z, settings.frame)


def _stacked(views: Sequence[PosedView]) -> tuple[np.ndarray, ...]:
    T_camera_map = np.stack([np.linalg.inv(view.T_map_camera) for view in views])
    pinholes = np.array([(*view.focal_px, *view.center_px) for view in views])
    depths = np.stack([view.depth.astype(np.float32) for view in views])
    return T_camera_map, pinholes, depths, np.stack([view.color for view in views])


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _fuse_layer(  # type: ignore[no-untyped-def]
    T_camera_map, pinholes, depths, images, corner, edge, num_slices, band, max_depth, error_grows,
    color, occupied,
):  # fmt: skip
    """Fill in a layer: `color` (rows, columns, 3) and `occupied` (rows, columns)."""
    rows, columns = occupied.shape
    sums = np.zeros(4)
    for i in range(rows):
        for j in range(columns):
            x, y = corner[0] + (j + 0.5) * edge[0], corner[1] + (i + 0.5) * edge[1]
            num_behind, num_before = 0, 0
            sums[:] = 0.0
            for k in range(num_slices):
                z = corner[2] + (k + 0.5) * edge[2] / num_slices
                mean = _signed_distance(
                    x, y, z, T_camera_map, pinholes, depths, images, band, max_depth, error_grows,
                    sums,
                )  # fmt: skip
                num_behind += mean < 0.0
                num_before += mean > 0.0
            if num_behind > 0 and num_behind >= num_before and sums[3] > 0.0:
                occupied[i, j] = True
                for c in range(3):
                    color[i, j, c] = np.uint8(sums[c] / sums[3] + 0.5)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _signed_distance(  # type: ignore[no-untyped-def]
    x, y, z, T_camera_map, pinholes, depths, images, band, max_depth, error_grows, sums
):
    """Return the mean distance before (+) or behind (-) surfaces; 0 where nothing is known.

    Adds the colors of views whose surface is nearer than `band` to `sums` (r, g, b, weight).
    """
    total, total_weight = 0.0, 0.0
    height, width = depths.shape[1:]
    for n in range(len(depths)):
        T = T_camera_map[n]
        far = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3]
        if far < 0.05 or far > max_depth + band:
            continue
        right = T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3]
        down = T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3]
        u = int(math.floor(pinholes[n, 0] * right / far + pinholes[n, 2] + 0.5))
        v = int(math.floor(pinholes[n, 1] * down / far + pinholes[n, 3] + 0.5))
        if u < 0 or v < 0 or u >= width or v >= height:
            continue
        depth = depths[n, v, u]
        if not 0.0 < depth <= max_depth or depth - far < -band:
            continue
        weight = 1.0 / far**4 if error_grows else 1.0
        total += weight * min(depth - far, band)
        total_weight += weight
        if depth - far < band:
            for c in range(3):
                sums[c] += weight * images[n, v, u, c]
            sums[3] += weight
    return total / total_weight if total_weight > 0.0 else 0.0
