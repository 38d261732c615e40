"""What a robot file may set of its cameras, each with unit and range."""

from __future__ import annotations

import math
from dataclasses import dataclass

from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera
from floornav_common.config import param, validate
from sim_bridge.config import STEP_S

REFINE_DOC = (
    "Light between neighboring pixels (1 = a white floor) above which both take all their rays, "
    "and not one; below 0 all pixels do."
)


@dataclass(frozen=True, kw_only=True)
class ImageConfig:
    """What lens and sensor make of the light. The sensor is linear; 255 is as bright as it goes."""

    exposure: float = param(0.9, "Brightness of a white floor, 1 = 255.", gt=0.0, le=16.0)
    color: tuple[float, ...] = param((1.0, 1.0, 1.0), "White balance, RGB factors.", ge=0.0, le=4.0)
    blur_sd_px: float = param(0.5, "Deviation of the lens's blur.", unit="px", ge=0.0, le=20.0)
    vignetting: float = param(0.15, "Light lost at the image's edge.", ge=0.0, le=1.0)
    noise_sd: float = param(2.0, "Noise in the dark, of 255.", ge=0.0, le=100.0)
    shot_noise: float = param(0.15, "Noise variance per gray level (photons).", ge=0.0, le=10.0)

    def __post_init__(self) -> None:
        validate(self)
        if len(self.color) != 3:
            raise ValueError(f"color must hold red, green, blue, got {self.color}")


@dataclass(frozen=True, kw_only=True)
class OmniCameraConfig:
    """A camera that looks up into a hyperboloidal mirror (floor paper, eq. 26).

    The figures of eq. 26 hold at the calibrated size and are scaled to the image's. The defaults
    are the floor paper's camera, whose viewpoint is 205 mm above the floor.
    """

    frame: str = param("omni_camera_optical_frame", "Link of the URDF at the mirror's viewpoint.")
    width_px: int = param(256, "Columns.", unit="px", ge=16, le=4096)
    height_px: int = param(220, "Rows.", unit="px", ge=16, le=4096)
    period_s: float = param(0.1, "Time between images.", unit="s", ge=STEP_S)
    samples: int = param(2, "Rays a pixel along each axis.", ge=1, le=8)
    refine_above: float = param(0.03, REFINE_DOC, ge=-1.0, le=1.0)
    calibrated_width_px: int = param(256, "Columns that the figures hold for.", unit="px", ge=1)
    calibrated_height_px: int = param(220, "Rows that the figures hold for.", unit="px", ge=1)
    a_px_per_mm: float = param(10.12, "A of eq. 26.", unit="px/mm", gt=0.0)
    b_per_mm: float = param(0.02054, "B of eq. 26.", unit="1/mm", gt=0.0)
    c_px2: float = param(229800.0, "C of eq. 26.", unit="px^2", gt=0.0)
    max_radius_px: float = param(110.0, "Edge of the mirror at that size.", unit="px", gt=0.0)
    rotation_rad: float = param(0.0, "Bearing of the image's x axis.", unit="rad")
    image: ImageConfig = ImageConfig()

    def __post_init__(self) -> None:
        self.camera()

    def camera(self) -> MirrorCamera:
        """Return the camera model at the image's size."""
        calibrated = MirrorCamera(
            width_px=self.calibrated_width_px,
            height_px=self.calibrated_height_px,
            a_px_per_mm=self.a_px_per_mm,
            b_per_mm=self.b_per_mm,
            c_px2=self.c_px2,
            center_u_px=(self.calibrated_width_px - 1) / 2.0,
            center_v_px=(self.calibrated_height_px - 1) / 2.0,
            max_radius_px=self.max_radius_px,
            rotation_rad=self.rotation_rad,
        )
        return calibrated.resized(self.width_px, self.height_px)


@dataclass(frozen=True, kw_only=True)
class StereoConfig:
    """Pairs of pinhole cameras, rectified.

    The URDF has a link `stereo_<pair>_<side>_optical_frame` for each camera; the right one lies on
    the left one's x axis.
    """

    pairs: tuple[str, ...] = param(("front", "rear"), "Names of the pairs.")
    width_px: int = param(320, "Columns.", unit="px", ge=16, le=4096)
    height_px: int = param(240, "Rows.", unit="px", ge=16, le=4096)
    fov_rad: float = param(1.2, "Angle between the first and last column.", gt=0.0, lt=3.0)
    period_s: float = param(0.1, "Time between images.", unit="s", ge=STEP_S)
    samples: int = param(1, "Rays a pixel along each axis.", ge=1, le=8)
    refine_above: float = param(0.03, REFINE_DOC, ge=-1.0, le=1.0)
    image: ImageConfig = ImageConfig()

    @property
    def focal_px(self) -> float:
        """Focal length, pixels."""
        return (self.width_px - 1) / 2.0 / math.tan(self.fov_rad / 2.0)

    @property
    def frames(self) -> tuple[str, ...]:
        """The links of all cameras, left before right."""
        return tuple(optical_frame(p, side) for p in self.pairs for side in ("left", "right"))


def optical_frame(pair: str, side: str) -> str:
    """Return the link of a camera of a pair."""
    return f"stereo_{pair}_{side}_optical_frame"
