"""How well a camera's parameters are known: what a calibration leaves open.

Kept as the covariance of the keys of the camera's file that were fitted. Single keys may trade off
against others by far more than what the camera sees changes, so nobody takes them one by one:
`moved_cameras` gives cameras that are off along the covariance's axes, a small step each, and what
follows from a camera is followed through those.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from floornav_common.floor_camera import FloorCamera

MOUNT_KEYS = ("height_m", "roll_rad", "pitch_rad", "yaw_rad")
STEP = 0.01
"""Of a deviation: so far the moved cameras lie from the camera."""
_NOTHING = 1e-14  # of the largest axis of the correlations


@dataclass(frozen=True)
class Calibration:
    """The covariance of some of a camera's parameters.

    Attributes:
        names: Keys of the camera's kind, or of its mount.
        cov: Their covariance, (P, P).
    """

    names: tuple[str, ...]
    cov: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        num = len(self.names)
        if num == 0 or len(set(self.names)) != num:
            raise ValueError(f"names must be different, at least one, got {list(self.names)}")
        if len(self.cov) != num or any(len(row) != num for row in self.cov):
            raise ValueError(f"cov must be {num} x {num}, as there are names")
        S = np.array(self.cov)
        if not np.isfinite(S).all() or (np.diag(S) < 0.0).any():
            raise ValueError("cov must be finite, its diagonal >= 0")
        if not np.allclose(S, S.T, rtol=1e-6, atol=0.0):
            raise ValueError("cov must be symmetric")
        sizes = np.sqrt(np.diag(S))
        if (np.abs(S) > np.outer(sizes, sizes) * (1.0 + 1e-6)).any():
            raise ValueError("cov must be that of something: a correlation is above 1")

    def axes(self) -> np.ndarray:
        """Return deviations of the parameters, independent of each other, in columns, (P, K)."""
        S = np.array(self.cov)
        size = np.sqrt(np.diag(S))
        safe = np.where(size > 0.0, size, 1.0)
        values, vectors = np.linalg.eigh(S / np.outer(safe, safe))
        keep = values > _NOTHING * values.max()
        return np.asarray(size[:, None] * vectors[:, keep] * np.sqrt(values[keep]))


def calibration_of(values: Mapping[str, np.ndarray], cov: np.ndarray) -> Calibration:
    """Return the calibration of keys that follow from fitted parameters.

    Args:
        values: Derivative of each key by the parameters, (P,).
        cov: Covariance of the parameters, (P, P).
    """
    J = np.array(list(values.values()), dtype=float)
    S = J @ cov @ J.T
    S = (S + S.T) / 2.0
    return Calibration(tuple(values), tuple(tuple(float(v) for v in row) for row in S))


def check_names(floor_camera: FloorCamera) -> None:
    """Refuse a calibration of what the camera does not have, ValueError."""
    assert floor_camera.calibration is not None
    for name in floor_camera.calibration.names:
        where = floor_camera if name in MOUNT_KEYS else floor_camera.camera
        if not isinstance(getattr(where, name, None), float):
            raise ValueError(f"calibration: {name} is no number of this camera")


def moved_cameras(floor_camera: FloorCamera) -> list[tuple[FloorCamera, FloorCamera]]:
    """Return cameras that are off by STEP deviations to both sides of each independent axis."""
    calibration = floor_camera.calibration
    if calibration is None:
        return []
    return [
        (_moved(floor_camera, STEP * axis), _moved(floor_camera, -STEP * axis))
        for axis in calibration.axes().T
    ]


def resized_calibration(floor_camera: FloorCamera, width: int, height: int) -> Calibration | None:
    """Return the calibration of a camera's image at another size."""
    calibration = floor_camera.calibration
    if calibration is None:
        return None
    columns = [
        [(_value(up, n) - _value(down, n)) / (2.0 * STEP) for n in calibration.names]
        for up, down in (
            (a.resized(width, height), b.resized(width, height))
            for a, b in moved_cameras(floor_camera)
        )
    ]
    J = np.array(columns).T.reshape(len(calibration.names), -1)
    return calibration_of(dict(zip(calibration.names, J, strict=True)), np.eye(J.shape[1]))


def _value(floor_camera: FloorCamera, name: str) -> float:
    where = floor_camera if name in MOUNT_KEYS else floor_camera.camera
    return float(getattr(where, name))


def _moved(floor_camera: FloorCamera, off: np.ndarray) -> FloorCamera:
    assert floor_camera.calibration is not None
    names = floor_camera.calibration.names
    values = {n: _value(floor_camera, n) + float(d) for n, d in zip(names, off, strict=True)}
    mount = {n: values.pop(n) for n in MOUNT_KEYS if n in values}
    camera = replace(floor_camera.camera, **values)  # type: ignore[type-var]
    return replace(floor_camera, camera=camera, calibration=None, **mount)  # type: ignore[arg-type]
