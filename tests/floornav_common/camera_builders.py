"""Cameras of every kind for tests."""

import math
from dataclasses import replace

from floornav_common.cameras.central import CentralCamera
from floornav_common.cameras.equidistant import EquidistantCamera
from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.cameras.radius_table import RadiusTableCamera
from floornav_common.cameras.unified import UnifiedCamera

RADII = (20.0, 40.0, 60.0, 80.0, 100.0, 108.0)


def table_camera() -> RadiusTableCamera:
    mirror = paper_camera()
    return RadiusTableCamera(
        width_px=256,
        height_px=220,
        center_u_px=127.5,
        center_v_px=109.5,
        radii_px=RADII,
        distances_m=tuple(float(mirror.floor_distance(R)) for R in RADII),
        measured_height_m=mirror.viewpoint_height,
    )


def parabolic_camera() -> UnifiedCamera:
    return UnifiedCamera(
        width_px=1280, height_px=1024, xi=1.0, fx_px=360.0, fy_px=360.0, center_u_px=640.0,
        center_v_px=512.0, max_radius_px=400.0,
    )  # fmt: skip


def bent_camera() -> UnifiedCamera:
    return replace(
        parabolic_camera(), xi=0.9, fx_px=355.0, fy_px=362.0, skew_px=0.7, k1=-0.06, k2=0.004,
        p1=0.002, p2=-0.001,
    )  # fmt: skip


def fisheye_camera() -> EquidistantCamera:
    return EquidistantCamera(
        width_px=640, height_px=480, fx_px=140.0, fy_px=141.0, center_u_px=322.0, center_v_px=238.0,
        k1=-0.02, k2=0.004, k3=-0.0006, k4=0.00001, max_angle_rad=math.radians(100.0),
    )  # fmt: skip


CAMERAS: dict[str, CentralCamera] = {
    "mirror": paper_camera(),
    "mirror_turned": replace(paper_camera(), rotation_rad=0.7),
    "unified": parabolic_camera(),
    "unified_bent": bent_camera(),
    "unified_steep": replace(parabolic_camera(), xi=1.6, fx_px=500.0, fy_px=500.0),
    "pinhole": replace(parabolic_camera(), xi=0.0, looks="down"),
    "equidistant": fisheye_camera(),
    "equidistant_forward": replace(fisheye_camera(), looks="forward"),
    "table": table_camera(),
}
