"""The camera model of an omnidirectional camera with a hyperboloidal mirror (floor paper, eq. 26).

A pixel at radius R from the image center sees the floor at the distance

    r = R / (A - B sqrt(C + R^2))        (eq. 26; r in mm, R in pixels)

in the direction Phi = atan2(v - v0, u - u0), v running down. The camera looks up into the mirror:
its image x axis is the robot's forward axis and its image y axis (down) the robot's left, so that
Phi is the bearing seen from the robot (eq. 3) and no axis is flipped anywhere else. A, B and C
come from the mirror (b, c), the focal length f and the height H of its single viewpoint, and obey
A^2 / C - B^2 = 1 / H^2: with the paper's figures H = 205 mm. Seen from there the ray of a pixel
falls by H (A - B sqrt(C + R^2)) over R, also where that is negative and the ray climbs.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np
import yaml

KIND = "hyperboloidal_mirror"
_MM = 1000.0


@dataclass(frozen=True, kw_only=True)
class MirrorCamera:
    """One camera of this kind at one image size.

    Attributes:
        width_px: Columns of the image.
        height_px: Rows of the image.
        a_px_per_mm: A of eq. 26.
        b_per_mm: B of eq. 26.
        c_px2: C of eq. 26.
        center_u_px: Column of the mirror's axis; pixel centers have whole numbers.
        center_v_px: Row of the mirror's axis.
        max_radius_px: Edge of the mirror in the image; nothing is seen beyond.
        rotation_rad: Bearing of the image's x axis, seen from the robot.
    """

    width_px: int
    height_px: int
    a_px_per_mm: float
    b_per_mm: float
    c_px2: float
    center_u_px: float
    center_v_px: float
    max_radius_px: float
    rotation_rad: float = 0.0

    def __post_init__(self) -> None:
        for name in ("width_px", "height_px", "a_px_per_mm", "b_per_mm", "c_px2", "max_radius_px"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")
        if self.a_px_per_mm**2 / self.c_px2 <= self.b_per_mm**2:
            raise ValueError("a_px_per_mm^2 / c_px2 must be > b_per_mm^2: no viewpoint height else")

    @property
    def viewpoint_height(self) -> float:
        """Height of the single viewpoint over the floor, m: 1 / H^2 = A^2 / C - B^2."""
        H_mm = (self.a_px_per_mm**2 / self.c_px2 - self.b_per_mm**2) ** -0.5
        return float(H_mm / _MM)

    @property
    def horizon_radius(self) -> float:
        """Pixel radius of the horizon, where the denominator of eq. 26 vanishes."""
        return math.sqrt((self.a_px_per_mm / self.b_per_mm) ** 2 - self.c_px2)

    def floor_distance(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return the distance on the floor that a pixel radius sees, m (eq. 26); inf above it."""
        R = np.asarray(radius_px, dtype=float)
        falling = self._denominator(R)
        safe = np.where(falling > 0.0, falling, 1.0)
        return np.where(falling > 0.0, R / safe / _MM, np.inf)

    def elevation(self, radius_px: np.ndarray | float) -> np.ndarray:
        """Return the angle over the horizon of the rays at a pixel radius, rad."""
        R = np.asarray(radius_px, dtype=float)
        return -np.arctan2(self.viewpoint_height * _MM * self._denominator(R), R)

    def image_radius(self, elevation: np.ndarray | float) -> np.ndarray:
        """Return the pixel radius at which a direction is seen; the inverse of `elevation`.

        With the ray's fall t = -tan(elevation), (H A - t R)^2 = (H B)^2 (C + R^2) and
        (H A)^2 - (H B)^2 C = C leave R = C / (H A t + H B sqrt(C (1 + t^2))).
        """
        angle = np.asarray(elevation, dtype=float)
        c, s = np.cos(angle), -np.sin(angle)  # t = s / c; stays finite straight down
        H, f = self.viewpoint_height * _MM, math.sqrt(self.c_px2)
        return np.asarray(self.c_px2 * c / (H * self.a_px_per_mm * s + H * self.b_per_mm * f))

    def floor_radius(self, distance: np.ndarray | float) -> np.ndarray:
        """Return the pixel radius at which the floor is seen at a distance, m."""
        return self.image_radius(-np.arctan2(self.viewpoint_height, np.asarray(distance)))

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit vectors of pixels in the frame of the robot's axes at the viewpoint.

        Args:
            pixels: (u, v), shape (..., 2).

        Returns:
            Shape (..., 3): x forward, y left, z up.
        """
        X, Y = pixels[..., 0] - self.center_u_px, pixels[..., 1] - self.center_v_px
        elevation = self.elevation(np.hypot(X, Y))
        bearing = np.arctan2(Y, X) + self.rotation_rad
        flat = np.cos(elevation)
        return np.stack((flat * np.cos(bearing), flat * np.sin(bearing), np.sin(elevation)), -1)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) at which points (..., 3) in the viewpoint's frame are seen."""
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        R = self.image_radius(np.arctan2(z, np.hypot(x, y)))
        bearing = np.arctan2(y, x) - self.rotation_rad
        u, v = self.center_u_px + R * np.cos(bearing), self.center_v_px + R * np.sin(bearing)
        return np.stack((u, v), -1)

    def resized(self, width_px: int, height_px: int) -> MirrorCamera:
        """Return the camera at another image size: the same picture, as large as fits inside.

        R scales by s, so A by s and C by s^2; B stays.
        """
        s = min(width_px / self.width_px, height_px / self.height_px)
        middle_u, middle_v = (self.width_px - 1) / 2.0, (self.height_px - 1) / 2.0
        return replace(
            self,
            width_px=width_px,
            height_px=height_px,
            a_px_per_mm=self.a_px_per_mm * s,
            c_px2=self.c_px2 * s**2,
            center_u_px=(width_px - 1) / 2.0 + s * (self.center_u_px - middle_u),
            center_v_px=(height_px - 1) / 2.0 + s * (self.center_v_px - middle_v),
            max_radius_px=self.max_radius_px * s,
        )

    def _denominator(self, R: np.ndarray) -> np.ndarray:
        return np.asarray(self.a_px_per_mm - self.b_per_mm * np.sqrt(self.c_px2 + R**2))


def paper_camera() -> MirrorCamera:
    """Return the floor paper's camera at its size: 256 x 220, the edge at 110 px."""
    return MirrorCamera(
        width_px=256,
        height_px=220,
        a_px_per_mm=10.12,
        b_per_mm=0.02054,
        c_px2=229800.0,
        center_u_px=127.5,
        center_v_px=109.5,
        max_radius_px=110.0,
    )


def save_camera(camera: MirrorCamera, path: Path) -> None:
    """Write a camera model as YAML: what the parameter `camera_model` names."""
    text = yaml.safe_dump({"kind": KIND, **asdict(camera)}, sort_keys=False)
    path.write_text(text, encoding="utf-8")


def load_camera(path: Path) -> MirrorCamera:
    """Read a camera model.

    Raises:
        ValueError: Not a mapping of this kind, unknown or missing keys, or values out of range.
        OSError: The file cannot be read.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict) or data.pop("kind", None) != KIND:
        raise ValueError(f"{path}: expected a mapping with kind: {KIND}")
    return camera_from(data, str(path))


def camera_from(data: dict[str, object], where: str) -> MirrorCamera:
    """Return a camera from the keys of its model; `where` is named in errors."""
    known = {f.name for f in fields(MirrorCamera)}
    wrong = sorted(set(data) - known) or sorted(known - {"rotation_rad"} - set(data))
    if wrong:
        raise ValueError(f"{where}: unknown or missing keys: {', '.join(wrong)}")
    for key, value in data.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value):  # type: ignore[arg-type]
            raise ValueError(f"{where}: {key} must be a finite number, got {value!r}")
    return MirrorCamera(**data)  # type: ignore[arg-type]
