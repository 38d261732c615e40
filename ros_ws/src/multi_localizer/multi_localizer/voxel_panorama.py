"""Views all around from a grid of places in a voxel map, so that a heading is a shift of columns.

Columns are even in azimuth, rows even in slope (height over distance on the floor), so a camera's
view from a place at any heading is a window of the same picture. Cells hold the shares of red and
green and one over the distance on the floor: what is compared, see `stereo_search_all`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_rays import cast_ray
from multi_localizer.voxel_view import ViewCamera, VoxelScene

BLANK = 1e3
"""What a cell holds that no ray from finds anything: unlike whatever is seen."""
CHANNELS = 3
_RAYS_PER_CELL = 2  # along each axis


@dataclass(frozen=True)
class PanoramaShape:
    """How panoramas are cut into cells.

    Attributes:
        columns: All around.
        rows: From `-max_slope` to `max_slope`.
        max_slope: Upper edge of the highest row.
    """

    columns: int
    rows: int
    max_slope: float

    @property
    def step(self) -> float:
        """Width of a column, rad."""
        return 2.0 * math.pi / self.columns


@dataclass(frozen=True, eq=False)
class Panoramas:
    """Panoramas of a grid of places at one height.

    Attributes:
        cells: (rows of places, columns of places, rows, CHANNELS, columns + overlap), float32;
            column a begins at azimuth a * step.
        is_free: Whether a camera can be there, (rows of places, columns of places).
        xs: Of the columns of places, m, in the map's frame.
        ys: Of the rows of places.
        shape: Of each panorama.
    """

    cells: np.ndarray
    is_free: np.ndarray
    xs: np.ndarray
    ys: np.ndarray
    shape: PanoramaShape

    @property
    def spacing(self) -> tuple[float, float]:
        """Between places along x and y, m."""
        voxel = self.xs[1] - self.xs[0] if len(self.xs) > 1 else 1.0
        return float(voxel), float(self.ys[1] - self.ys[0] if len(self.ys) > 1 else 1.0)


def make_panoramas(
    scene: VoxelScene, height_m: float, spacing_m: float, shape: PanoramaShape, overlap: int
) -> Panoramas:
    """Return the panoramas of a whole map.

    Args:
        scene: The map.
        height_m: Of the camera above z = 0 of the map's frame.
        spacing_m: Between places at most.
        shape: Of each panorama.
        overlap: How many columns are repeated behind the last one.
    """
    m = scene.voxels
    xs, ys = (
        start + size * (np.arange(num) + 0.5) / num
        for start, size, num in (
            (m.origin_x_m, m.size_m[0], math.ceil(m.size_m[0] / spacing_m - 1e-6)),
            (m.origin_y_m, m.size_m[1], math.ceil(m.size_m[1] / spacing_m - 1e-6)),
        )
    )
    x, y = (grid.ravel() for grid in np.meshgrid(xs, ys))
    poses = np.stack((x, y, np.zeros(len(x))), axis=1)
    camera = ViewCamera(1, 1, 1.0, 1.0, height_m)
    is_free = scene.is_free(poses, camera)
    cells = np.full(
        (len(x), shape.rows, CHANNELS, shape.columns + overlap), BLANK, dtype=np.float32
    )
    fine = _RAYS_PER_CELL
    azimuths = (np.arange(shape.columns * fine) + 0.5) * shape.step / fine
    slopes = ((np.arange(shape.rows * fine) + 0.5) / (shape.rows * fine) * 2 - 1) * shape.max_slope
    rays = np.stack((np.cos(azimuths), np.sin(azimuths)), axis=1)
    chosen = np.flatnonzero(is_free)
    scene.share(
        len(chosen), _cast_panoramas, chosen, scene.leaps, scene.rgb, scene.scale,
        scene.eyes(poses, camera), rays, slopes, shape.columns, cells,
    )  # fmt: skip
    grid = (len(ys), len(xs))
    return Panoramas(cells.reshape(*grid, *cells.shape[1:]), is_free.reshape(grid), xs, ys, shape)


def window_columns(camera: ViewCamera, shape: PanoramaShape) -> int:
    """Return how many columns of a panorama a camera sees, an even number."""
    u, _ = camera.center_px
    widest = max(u + 0.5, camera.width_px - 0.5 - u) / camera.focal_px
    return 2 * math.ceil(math.atan(widest) / shape.step - 1e-9)


def highest_slope(camera: ViewCamera) -> float:
    """Return the steepest slope in a camera's image, up or down."""
    _, v = camera.center_px
    return max(v + 0.5, camera.height_px - 0.5 - v) / camera.focal_px


def window_of(
    view: StereoView, camera: ViewCamera, shape: PanoramaShape
) -> tuple[np.ndarray, np.ndarray]:
    """Return a view as cells of a panorama.

    Args:
        view: What was seen.
        camera: By this camera.
        shape: Of the panoramas.

    Returns:
        Cells (rows, CHANNELS, K) as in `Panoramas`, the first column at the view's right edge, and
        weights (rows, 2, K) of color and distance: which part of the cell was seen, 0 to 1.
    """
    rows, columns = view.weight.shape
    left, up = np.moveaxis(camera.rays(columns, rows), -1, 0)
    lengthening = np.hypot(1.0, left)
    num = window_columns(camera, shape)
    k = np.floor(np.arctan(left) / shape.step + num / 2).astype(np.int64)
    row = np.floor((up / lengthening / shape.max_slope + 1.0) / 2.0 * shape.rows).astype(np.int64)
    index = (np.clip(row, 0, shape.rows - 1) * num + np.clip(k, 0, num - 1)).ravel()

    def total(values: np.ndarray) -> np.ndarray:
        sums = np.bincount(index, values.ravel(), minlength=shape.rows * num)
        return np.asarray(sums.reshape(shape.rows, num))

    pixels, known = total(np.ones(index.shape)), total(view.weight)
    light = [np.maximum(total(view.color[..., c]), 1e-6) for c in range(3)]
    inverse = np.where(view.weight > 0.0, view.inverse * view.weight, 0.0) / lengthening
    cells = np.stack(
        (light[0] / sum(light), light[1] / sum(light), total(inverse) / np.maximum(known, 1e-9)),
        axis=1,
    )
    whole = max(float(np.median(pixels[pixels > 0])), 1.0)
    weights = np.minimum(np.stack((pixels, known), axis=1) / whole, 1.0)
    return cells.astype(np.float32), weights.astype(np.float32)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _cast_panoramas(  # type: ignore[no-untyped-def]
    start, stop, chosen, leaps, rgb, scale, eyes, rays, slopes, columns, cells
):
    """Fill in the cells of `chosen` places from `start` to `stop`."""
    rows = cells.shape[1]
    fine = len(rays) // columns
    for n in range(start, stop):
        p = chosen[n]
        x, y, z = eyes[p, 0], eyes[p, 1], eyes[p, 2]
        for a in range(columns):
            for v in range(rows):
                num, inverse, red, green, blue = 0, 0.0, 0.0, 0.0, 0.0
                for k in range(fine * fine):
                    c, s = rays[a * fine + k % fine]
                    up = slopes[v * fine + k // fine] * scale[1]
                    t, layer, i, j = cast_ray(leaps, x, y, z, c * scale[0], s * scale[0], up)
                    if layer >= 0:
                        num += 1
                        inverse += 1.0 / max(t, 1e-3)
                        red += rgb[layer, i, j, 0]
                        green += rgb[layer, i, j, 1]
                        blue += rgb[layer, i, j, 2]
                if num > 0:
                    light = max(red + green + blue, 1e-6)
                    cells[p, v, 0, a] = red / light
                    cells[p, v, 1, a] = green / light
                    cells[p, v, 2, a] = inverse / num
        for a in range(columns, cells.shape[3]):
            cells[p, :, :, a] = cells[p, :, :, a - columns]
