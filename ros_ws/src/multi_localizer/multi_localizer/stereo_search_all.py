"""All poses of a fine mesh scored at once: what stands beside the paper's search.

The views are compared with panoramas of a grid of places (see `voxel_panorama`), at every heading
that a column of them is wide. Distances are compared as one over them, whose error in stereo does
not depend on the distance, and a cell counts no more than `1` however wrong it is, so wrong matches
and what is not in the map do not decide. No candidate is dropped by a coarser look.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np
from scipy.ndimage import minimum_filter

from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_view import StereoView
from multi_localizer.voxel_panorama import (
    PanoramaShape,
    highest_slope,
    make_panoramas,
    window_columns,
    window_of,
)
from multi_localizer.voxel_view import ViewCamera, VoxelScene


class SearchAll:
    """Scores every pose of a mesh in one map.

    Args:
        scene: The map.
        cameras: One for each pair.
        config: Mesh and scales.
    """

    def __init__(
        self, scene: VoxelScene, cameras: Sequence[ViewCamera], config: StereoLocalizerConfig
    ) -> None:
        self._scene, self._cameras, self._config = scene, tuple(cameras), config
        steepest = max(highest_slope(c) for c in cameras)
        shape = PanoramaShape(config.panorama_columns, config.panorama_rows, steepest)
        width, depth, _ = scene.voxels.size_m
        spacing = max(config.panorama_spacing_m, math.sqrt(width * depth / config.max_places))
        overlap = max(window_columns(c, shape) for c in cameras)
        by_height = {
            h: make_panoramas(scene, h, spacing, shape, overlap)
            for h in sorted({c.height_m for c in cameras})
        }
        self._panoramas = tuple(by_height[c.height_m] for c in cameras)

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other scales; the mesh stays."""
        self._config = config

    def search(
        self, views: Sequence[StereoView | None], num: int, near: PoseEstimate | None = None
    ) -> np.ndarray:
        """Return the `num` best poses that are better than all around them, (N, 3), best first.

        Args:
            views: One of each pair, None where one is missing.
            num: How many.
            near: Only poses within `near_sd` of its deviations; None for all.
        """
        used = [k for k, view in enumerate(views) if view is not None]
        first = self._panoramas[used[0]]
        total = np.zeros((*first.is_free.shape, first.shape.columns), dtype=np.float32)
        for k in used:
            view = views[k]
            assert view is not None
            total += self._moved(self._costs(k, view, k == used[0]), k, used[0])
        low = minimum_filter(total, size=3, mode=("nearest", "nearest", "wrap"))
        found = np.flatnonzero((total == low) & np.isfinite(total))
        order = found[np.argsort(total.ravel()[found], kind="stable")]
        poses = self._poses(np.stack(np.unravel_index(order, total.shape), axis=1), used[0])
        if near is not None:
            poses = poses[_are_near(poses, near, self._config.near_sd)]
        return poses[:num]

    def _costs(self, k: int, view: StereoView, is_first: bool) -> np.ndarray:
        """Return the sum of what the cells of pair k cost, (rows, columns, headings).

        Where no camera can be that of the first pair is refused; that of another, which is only
        near such a place, is as wrong as can be.
        """
        panoramas = self._panoramas[k]
        cells, weights = window_of(view, self._cameras[k], panoramas.shape)
        c = self._config
        outside = np.inf if is_first else weights.sum()
        shape = (*panoramas.is_free.shape, panoramas.shape.columns)
        sums = np.full(shape, outside, dtype=np.float32)
        places = np.flatnonzero(panoramas.is_free)
        flat_cells = panoramas.cells.reshape(-1, *panoramas.cells.shape[2:])
        flat_sums = sums.reshape(-1, sums.shape[2])
        scales = np.float32(1.0 / c.search_color), np.float32(1.0 / c.search_inverse_per_m)
        self._scene.share(
            len(places), _score_places, places, flat_cells, cells, weights, scales, flat_sums
        )
        return sums

    def _moved(self, sums: np.ndarray, k: int, first: int) -> np.ndarray:
        """Return costs of pair k where the first pair's camera, and base_link, are headed."""
        one, other = self._cameras[first], self._cameras[k]
        shape, (dx, dy) = self._panoramas[k].shape, self._panoramas[k].spacing
        headings = np.arange(shape.columns)
        yaws = headings * shape.step - one.yaw
        ahead, aside = other.x_m - one.x_m, other.y_m - one.y_m
        columns = np.rint((np.cos(yaws) * ahead - np.sin(yaws) * aside) / dx).astype(int)
        rows = np.rint((np.sin(yaws) * ahead + np.cos(yaws) * aside) / dy).astype(int)
        turn = round((other.yaw - one.yaw) / shape.step)
        out = np.full(sums.shape, sums.max(), dtype=np.float32)
        for h, row, column in zip(headings.tolist(), rows.tolist(), columns.tolist(), strict=True):
            seen = sums[:, :, (h + turn) % shape.columns]
            to_rows, from_rows = _overlap(row, seen.shape[0])
            to_columns, from_columns = _overlap(column, seen.shape[1])
            out[to_rows, to_columns, h] = seen[from_rows, from_columns]
        return out

    def _poses(self, nodes: np.ndarray, first: int) -> np.ndarray:
        """Return poses of base_link whose first camera is at (row, column, heading), (N, 3)."""
        panoramas, camera = self._panoramas[first], self._cameras[first]
        yaw = nodes[:, 2] * panoramas.shape.step - camera.yaw
        c, s = np.cos(yaw), np.sin(yaw)
        x = panoramas.xs[nodes[:, 1]] - (c * camera.x_m - s * camera.y_m)
        y = panoramas.ys[nodes[:, 0]] - (s * camera.x_m + c * camera.y_m)
        return np.stack((x, y, np.pi - (np.pi - yaw) % (2.0 * np.pi)), axis=1)


def _are_near(poses: np.ndarray, near: PoseEstimate, most_sd: float) -> np.ndarray:
    """Return which poses are within so many deviations of where the robot is said to be, (N,)."""
    off = poses - near.pose.as_array()
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray((off * np.linalg.solve(near.cov, off.T).T).sum(axis=1) <= most_sd**2)


def _overlap(shift: int, length: int) -> tuple[slice, slice]:
    """Return the slices for `to[n] = from[n + shift]`."""
    return (
        slice(max(0, -shift), max(0, min(length, length - shift))),
        slice(max(0, shift), max(0, min(length, length + shift))),
    )


@numba.njit(cache=True, error_model="numpy", nogil=True, fastmath={"contract", "reassoc"})
def _score_places(start, stop, places, panoramas, cells, weights, scales, sums):  # type: ignore[no-untyped-def]
    """Fill in the cost of every heading at `places` from `start` to `stop`.

    Args:
        start: First place.
        stop: Place after the last one.
        places: Their indices.
        panoramas: (places, rows, CHANNELS, columns + overlap), float32.
        cells: What was seen, (rows, CHANNELS, K).
        weights: Of color and distance, (rows, 2, K).
        scales: One over what counts as wrong, of color and of inverse distance.
        sums: (places, headings).
    """
    rows, _, num = cells.shape
    headings = sums.shape[1]
    total = np.empty(headings + num, dtype=np.float32)
    one = np.float32(1.0)
    for n in range(start, stop):
        p = places[n]
        total[:] = np.float32(0.0)
        for v in range(rows):
            for k in range(num):
                red, green, inverse = cells[v, 0, k], cells[v, 1, k], cells[v, 2, k]
                by_color, by_distance = weights[v, 0, k], weights[v, 1, k]
                reds = panoramas[p, v, 0, k : k + headings]
                greens = panoramas[p, v, 1, k : k + headings]
                inverses = panoramas[p, v, 2, k : k + headings]
                for h in range(headings):
                    more_red, more_green = reds[h] - red, greens[h] - green
                    off = abs(more_red) + abs(more_green) + abs(more_red + more_green)
                    far = abs(inverses[h] - inverse) * scales[1]
                    total[h] += by_color * min(off * scales[0], one) + by_distance * min(far, one)
        half = num // 2
        for h in range(headings):  # window h begins at azimuth h * step
            sums[p, (h + half) % headings] = total[h]
