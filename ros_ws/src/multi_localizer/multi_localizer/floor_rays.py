"""Border of the floor, seen outwards along bearings, with the noise of each piece.

Along every bearing the image is walked from far to near until there is floor. Between which two
pixels that happens is known beforehand, so all that a border between two pixels means on the floor
is looked up: its bearing phi, its inverse distance rho = 1/r, and how a pixel's noise of deviation
1 spreads over both. rho is used because a wall n . p = c is rho = n . e(phi) / c, and because it is
nearly linear in the pixels out to the horizon, where r runs away.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numba
import numpy as np

from floornav_common.calibration import STEP, moved_cameras
from floornav_common.floor_camera import FloorCamera

_STEP_PX = 0.5
_CHUNK = 128
_NEAREST = 0.05  # of the height: nearer than this is straight below


@dataclass(frozen=True, eq=False)
class BorderRays:
    """Pieces of border, each with its noise; rows are pieces, sorted by path.

    Attributes:
        index: Path of each piece, (N,), int.
        values: cos phi, sin phi, rho, and for 1 px of noise var(phi), cov(phi, rho), var(rho), and
            the share of a whole measurement that it counts, (N, 7).
        moves: By how much phi and rho move if the calibration is off by a deviation along each of
            its K independent axes, (N, K, 2).
        num_paths: Paths there are.
    """

    index: np.ndarray
    values: np.ndarray
    moves: np.ndarray
    num_paths: int


class BorderScanner:
    """Finds the border in masks of one camera.

    Args:
        camera: The camera.
        reach_m: No border is farther away.
    """

    def __init__(self, camera: FloorCamera, reach_m: float) -> None:
        self.shape = camera.height_px, camera.width_px
        self.num_paths = _num_paths(camera, reach_m)
        pixels, starts = _paths(camera, reach_m, self.num_paths)
        self._starts = starts
        self._flat = (pixels[:, 1] * camera.width_px + pixels[:, 0]).astype(np.int32)
        before = np.roll(pixels, 1, axis=0)
        is_step = np.abs(pixels - before).max(axis=1) <= 1
        is_step[starts[:-1][starts[:-1] < len(pixels)]] = False
        self._middles = np.where(is_step[:, None], (pixels + before) / 2.0, np.nan)
        self._camera = camera
        self._table: np.ndarray | None = self._values(self._middles).astype(np.float32)
        self._moves: np.ndarray | None = moves_of(camera, self._middles).astype(np.float32)

    def through(self, camera: FloorCamera) -> BorderScanner:
        """Return what walks the same paths and sees through another camera of the same size.

        It is made at once, but works out what a border means with every mask anew.
        """
        other = copy(self)
        other._camera, other._table, other._moves = camera, None, None
        return other

    def _values(self, middles: np.ndarray) -> np.ndarray:
        return measured(self._camera, middles, 2.0 * np.pi / self.num_paths)

    def scan(self, mask: np.ndarray, farther: np.ndarray | None = None) -> BorderRays:
        """Return the border in a mask.

        Args:
            mask: Not 0 where the floor is, (H, W), uint8.
            farther: Paths whose farthest floor is none of the plan's: the next one inwards counts.

        Raises:
            ValueError: The mask is not of the camera's size.
        """
        if mask.shape != self.shape:
            raise ValueError(f"mask must be {self.shape}, got {mask.shape}")
        is_farther = np.zeros(self.num_paths, dtype=bool)
        if farther is not None:
            is_farther[farther] = True
        flat = np.ascontiguousarray(mask).reshape(-1)
        found = _first_floor(flat, self._flat, self._starts, is_farther)
        if self._table is None or self._moves is None:
            middles = self._middles[found[found >= 0]]
            table, moves = self._values(middles), moves_of(self._camera, middles)
            found[found >= 0] = np.arange(len(middles))
        else:
            table, moves = self._table, self._moves
        index, values, moved = _looked_up(found, table, moves)
        return BorderRays(index, values, moved, self.num_paths)


def rays_of_pixels(camera: FloorCamera, pixels: np.ndarray) -> BorderRays:
    """Return pieces of border that are known to a part of a pixel.

    Args:
        camera: The camera.
        pixels: (u, v), sorted by bearing, (N, 2).
    """
    values = measured(camera, pixels, np.inf)
    keep = np.isfinite(values[:, 2])
    return BorderRays(
        np.flatnonzero(keep), values[keep], moves_of(camera, pixels[keep]), len(pixels)
    )


def moves_of(camera: FloorCamera, pixels: np.ndarray) -> np.ndarray:
    """Return `BorderRays.moves` for border at pixels (N, 2), (N, K, 2); 0 if no floor."""
    moved = moved_cameras(camera)
    moves = np.zeros((len(pixels), len(moved), 2))
    for k, pair in enumerate(moved):
        (x, y), (x2, y2) = (c.floor_points(pixels).T for c in pair)
        with np.errstate(invalid="ignore"):
            moves[:, k, 0] = np.arctan2(y * x2 - x * y2, x * x2 + y * y2)
            moves[:, k, 1] = 1.0 / np.hypot(x, y) - 1.0 / np.hypot(x2, y2)
    return np.nan_to_num(moves / (2.0 * STEP), posinf=0.0, neginf=0.0)


def measured(camera: FloorCamera, pixels: np.ndarray, spacing_rad: float) -> np.ndarray:
    """Return the rows of `BorderRays.values` for border at pixels (N, 2), (N, 7); NaN if no floor.

    Args:
        camera: The camera.
        pixels: (u, v), (N, 2).
        spacing_rad: Angle between paths: where they lie closer than a pixel they count for less.
    """
    points = camera.floor_points(pixels)
    points = np.where(np.isfinite(points), points, np.nan)
    J = camera.floor_jacobian(pixels)
    x, y = points.T
    r = np.hypot(x, y)
    by_point = np.stack(
        (np.stack((-y, x), -1) / r[:, None] ** 2, -points / r[:, None] ** 3), axis=1
    )
    K = by_point @ J
    cov = K @ np.swapaxes(K, 1, 2)
    det = cov[:, 0, 0] * cov[:, 1, 1] - cov[:, 0, 1] ** 2
    apart_px = spacing_rad * np.sqrt(cov[:, 1, 1] / det)  # of paths, across the bearing
    share = np.minimum(1.0, apart_px)
    return np.column_stack((x / r, y / r, 1.0 / r, cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1], share))


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _first_floor(mask, flat, starts, is_farther):  # type: ignore[no-untyped-def]
    """Return where each path comes upon floor, (K,); -1 if it never does or begins on it."""
    found = np.full(len(starts) - 1, -1, np.int64)
    for k in range(len(starts) - 1):
        first, end = starts[k], starts[k + 1]
        if is_farther[k]:
            while first < end and mask[flat[first]] == 0:
                first += 1
            while first < end and mask[flat[first]] != 0:
                first += 1
        for j in range(first, end):
            if mask[flat[j]] != 0:
                if j > starts[k]:
                    found[k] = j
                break
    return found


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _looked_up(found, table, moves):  # type: ignore[no-untyped-def]
    """Return path, values (N, 7) and moves (N, K, 2) of the border found, as far as it is floor's.

    Args:
        found: Row of the tables for each path, -1 for none.
        table: Values by row.
        moves: Moves by row.
    """
    index = np.empty(len(found), np.int64)
    values = np.empty((len(found), table.shape[1]))
    moved = np.empty((len(found), moves.shape[1], 2))
    num = 0
    for k in range(len(found)):
        if found[k] < 0 or not np.isfinite(table[found[k], 2]):
            continue
        index[num] = k
        for i in range(table.shape[1]):
            values[num, i] = table[found[k], i]
        for i in range(moves.shape[1]):
            moved[num, i, 0], moved[num, i, 1] = moves[found[k], i, 0], moves[found[k], i, 1]
        num += 1
    return index[:num], values[:num], moved[:num]


def _ring(camera: FloorCamera, reach_m: float, num: int) -> np.ndarray:
    angles = np.linspace(-np.pi, np.pi, num, endpoint=False)
    points = reach_m * np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    return camera.floor_pixels(points)


def _num_paths(camera: FloorCamera, reach_m: float) -> int:
    """Return how many paths lie a pixel apart where they lie farthest apart, at the rim."""
    ring = _ring(camera, reach_m, 720)
    for share in (0.8, 0.6, 0.4, 0.2):  # a rim outside of the view
        if np.isfinite(ring).any():
            break
        ring = _ring(camera, share * reach_m, 720)
    apart = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    if not np.isfinite(apart).any():
        raise ValueError(f"the camera must see floor within {reach_m:g} m")
    return int(np.ceil(720 * np.nanmedian(apart)))


def _paths(camera: FloorCamera, reach_m: float, num: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the pixels of all paths from far to near, (M, 2), and where each begins, (K + 1,)."""
    bearings = -np.pi + 2.0 * np.pi / num * np.arange(num)
    depressions = _depressions(camera, reach_m, bearings[:: max(1, num // 16)])
    ranges = camera.height_m * np.tan(depressions)
    pixels, counts = [], []
    for k in range(0, num, _CHUNK):
        for path in np.rint(_along(camera, bearings[k : k + _CHUNK], ranges)):
            seen = path[np.isfinite(path[:, 0])]
            is_new = np.ones(len(seen), dtype=bool)
            is_new[1:] = (seen[1:] != seen[:-1]).any(axis=1)
            pixels.append(seen[is_new].astype(np.int32))
            counts.append(int(is_new.sum()))
    return np.concatenate(pixels), np.concatenate(([0], np.cumsum(counts)))


def _along(camera: FloorCamera, bearings: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """Return the pixels of places on the floor along bearings, (K, R, 2)."""
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    return camera.floor_pixels(ways[:, None] * ranges[:, None])


def _depressions(camera: FloorCamera, reach_m: float, bearings: np.ndarray) -> np.ndarray:
    """Return angles from the plumb line, large to small, that lie within half a pixel."""
    far, near = np.arctan(reach_m / camera.height_m), np.arctan(_NEAREST)
    coarse = np.linspace(far, near, 200)
    path = _along(camera, bearings, camera.height_m * np.tan(coarse))
    steps = np.linalg.norm(np.diff(path, axis=1), axis=-1)
    most = np.where(np.isfinite(steps), steps, 0.0).max(axis=0)
    length = np.concatenate(([0.0], np.cumsum(np.maximum(most, 1e-3))))
    return np.interp(np.arange(0.0, length[-1], _STEP_PX), length, coarse)
