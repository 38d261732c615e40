"""A camera and its mount from points on the floor whose pixels are known.

Marks on the floor, corners of a field's lines or of tiles: any points whose place in base_link is
measured and that were clicked in one picture. Where the camera is known (from a checkerboard) only
its mount is fitted; else a round unified camera with it. What is not freed keeps its start: tilt
and offset of the camera act nearly as a shift of the image's center does, and few points on one
plane do not tell them apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from floor_perception.fit_statistics import FitStatistics, fit_statistics, numeric_jacobian
from floor_perception.mirror_fit import MIN_RADII, nearest_mirror
from floornav_common.calibration import Calibration, calibration_of
from floornav_common.cameras.central import CentralCamera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera

CAMERA = ("gamma_px", "xi", "center_u_px", "center_v_px")
MOUNT = ("height_m", "yaw_rad", "roll_rad", "pitch_rad", "x_m", "y_m")
NAMES = (*CAMERA, *MOUNT)
GROUPS = {
    "camera": CAMERA, "height": ("height_m",), "yaw": ("yaw_rad",),
    "tilt": ("roll_rad", "pitch_rad"), "position": ("x_m", "y_m"),
}  # fmt: skip
"""What can be freed, by the name a user gives."""
MAX_RMS_SHARE = 0.05
_MISSED_PX = 1e3
_XI_START = np.array([np.nan, 0.9, np.nan])


@dataclass(frozen=True)
class PointsFit:
    """A camera over the floor, fitted.

    Attributes:
        floor_camera: The camera on its mount.
        statistics: Of what was free.
        residuals_px: Measured less fitted pixels, shape (N, 2).
    """

    floor_camera: FloorCamera
    statistics: FitStatistics
    residuals_px: np.ndarray

    @property
    def rms_px(self) -> float:
        """Root mean square of the points' distances from where the camera says."""
        return float(np.sqrt((self.residuals_px**2).sum(axis=1).mean()))


def fit_points(
    pixels: np.ndarray,
    points_base: np.ndarray,
    camera: CentralCamera,
    free: Iterable[str] = ("height", "yaw"),
    position_m: tuple[float, float] = (0.0, 0.0),
) -> PointsFit:
    """Fit a camera's mount, and the camera where it is free, to points on the floor.

    Args:
        pixels: (u, v), shape (N, 2).
        points_base: (x, y) of the points on the floor in base_link, m, shape (N, 2).
        camera: The camera; with `camera` free, its size, center and `looks` are the start.
        free: Keys of `GROUPS`.
        position_m: Where the viewpoint is over base_link; the start where `position` is free.

    Raises:
        ValueError: Values that are not finite, fewer points than the parameters need, or points
            that do not fit or do not determine what is free.
    """
    wanted = tuple(free)
    unknown = sorted(set(wanted) - set(GROUPS))
    if unknown:
        raise ValueError(f"free must be of {', '.join(GROUPS)}, got {unknown[0]!r}")
    pixels, points = np.asarray(pixels, dtype=float), np.asarray(points_base, dtype=float)
    _require_points(pixels, points)
    start = _start(pixels, points - position_m, camera, "camera" in wanted)
    start[8:] = position_m
    names = [name for group in GROUPS if group in wanted for name in GROUPS[group]]
    index = [NAMES.index(name) for name in names]

    def filled(values: np.ndarray) -> np.ndarray:
        vector = start.copy()
        vector[index] = values
        return vector

    def residuals(values: np.ndarray) -> np.ndarray:
        floor = _floor_camera(filled(values), camera, "camera" in wanted)
        off = floor.floor_pixels(points - floor.position_m) - pixels
        return np.nan_to_num(off, nan=_MISSED_PX).ravel()

    low = np.where(np.isin(names, ("gamma_px", "xi", "height_m")), 1e-6, -np.inf)
    found = least_squares(
        residuals, start[index], bounds=(low, np.inf), x_scale="jac", xtol=1e-13, ftol=1e-13,
        gtol=1e-13, max_nfev=300,
    )  # fmt: skip
    floor = _floor_camera(filled(found.x), camera, "camera" in wanted)
    statistics = fit_statistics(names, found.x, found.fun, numeric_jacobian(residuals, found.x))
    known = replace(floor, calibration=_known(names, statistics.cov))
    fit = PointsFit(known, statistics, -found.fun.reshape(-1, 2))
    if fit.rms_px > MAX_RMS_SHARE * max(camera.width_px, camera.height_px):
        raise ValueError(
            f"the points do not fit: {fit.rms_px:.0f} px off (RMS); are x, y in m, and is `looks` "
            "right?"
        )
    return fit


def _start(
    pixels: np.ndarray, points: np.ndarray, camera: CentralCamera, is_free: bool
) -> np.ndarray:
    """Return all parameters to begin with."""
    vector = np.zeros(len(NAMES))
    vector[2:4] = camera.center_px
    if is_free:
        radii = np.hypot(*(pixels - camera.center_px).T)
        nearest = nearest_mirror(radii, np.hypot(*points.T), _XI_START)
        vector[:2], vector[4] = nearest[:2], nearest[2]
    flat = FloorCamera(_camera(vector, camera, is_free), max(vector[4], 1.0))
    seen = flat.floor_points(pixels)
    is_floor = np.isfinite(seen).all(axis=1)
    if is_floor.sum() < 2:
        raise ValueError("at least two of the pixels must see the floor; is `looks` right?")
    a = (seen[is_floor, 0] + 1j * seen[is_floor, 1]) / flat.height_m
    b = points[is_floor, 0] + 1j * points[is_floor, 1]
    if not is_free:
        vector[4] = float(np.median(np.abs(b) / np.maximum(np.abs(a), 1e-9)))
    vector[5] = float(np.angle((b * np.conj(a) / np.maximum(np.abs(a * b), 1e-12)).sum()))
    return vector


def _camera(vector: np.ndarray, camera: CentralCamera, is_free: bool) -> CentralCamera:
    if not is_free:
        return camera
    gamma, xi, u, v = (float(value) for value in vector[:4])
    return UnifiedCamera(
        width_px=camera.width_px, height_px=camera.height_px, xi=xi, fx_px=gamma, fy_px=gamma,
        center_u_px=u, center_v_px=v, looks=getattr(camera, "looks", "mirror_above"),
        max_radius_px=getattr(camera, "max_radius_px", 0.0),
    )  # fmt: skip


def _floor_camera(vector: np.ndarray, camera: CentralCamera, is_free: bool) -> FloorCamera:
    height, yaw, roll, pitch, x, y = (float(value) for value in vector[4:])
    return FloorCamera(_camera(vector, camera, is_free), height, roll, pitch, yaw, (x, y))


def _known(names: list[str], cov: np.ndarray) -> Calibration | None:
    """Return how well the camera file's keys are known, but for where it is on the robot."""
    keys = {"gamma_px": ("fx_px", "fy_px"), "x_m": (), "y_m": ()}
    by = {key: row for name, row in zip(names, np.eye(len(names)), strict=True)
          for key in keys.get(name, (name,))}  # fmt: skip
    return calibration_of(by, cov) if by else None


def _require_points(pixels: np.ndarray, points: np.ndarray) -> None:
    if pixels.shape != points.shape or pixels.ndim != 2 or pixels.shape[1] != 2:
        raise ValueError(
            f"pixels and points must be two lists of (N, 2), got {pixels.shape}, {points.shape}"
        )
    bad = np.flatnonzero(~(np.isfinite(pixels) & np.isfinite(points)).all(axis=1))
    if len(bad):
        raise ValueError(f"point {bad[0] + 1} must be finite")
    if len(points) < MIN_RADII:
        raise ValueError(f"at least {MIN_RADII} points are needed, got {len(points)}")
