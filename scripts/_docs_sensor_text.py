"""Fills scripts/_docs_sensors.md: every figure in it is a default of the code."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sim_bridge.camera_config import ImageConfig, OmniCameraConfig, optical_frame
from sim_bridge.config import LaserConfig
from sim_bridge.glass import Glass, optical_delay, specular_probability, transmittance
from sim_bridge.robot_model import load_robot
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.world import RobotPlacement

TEMPLATE = Path(__file__).resolve().parent / "_docs_sensors.md"
_RADII_PX = np.array([60.0, 80.0, 100.0, 110.0])


def sensor_text(pictures: str) -> str:
    """Return the sections of the page that are about sensors.

    Args:
        pictures: Folder of the pictures, from the page.
    """
    values = {**_laser(), **_sonar(), **_mirror(), **_stereo()}
    return TEMPLATE.read_text(encoding="utf-8").format(pictures=pictures, **values)


def _laser() -> dict[str, str]:
    glass, laser = Glass(), LaserConfig()
    back = specular_probability(glass, np.cos(np.radians([0.0, 10.0])))
    through = transmittance(glass, np.cos(np.radians([0.0, 60.0, 75.0])))
    return {
        "pane_mm": _mm(glass.thickness_m),
        "index": f"{glass.refractive_index:g}",
        "late_mm": _mm(float(optical_delay(glass, np.ones(1))[0])),
        "back_0": _percent(back[0]),
        "back_10": _percent(back[1]),
        "half_deg": f"{glass.specular_half_width_deg:g}",
        "dirt": _percent(glass.scatter_share),
        "dirt_cm": f"{100.0 * glass.scatter_depth_m:g}",
        "through_0": _percent(through[0]),
        "through_60": _percent(through[1]),
        "through_75": _percent(through[2]),
        "reach_m": f"{laser.reach_factor * laser.range_max_m:g}",
        "num_beams": str(laser.num_beams),
        "fov_deg": _degrees(laser.fov_rad),
        "scan_hz": f"{1.0 / laser.period_s:g}",
        "laser_min_m": f"{laser.range_min_m:g}",
        "laser_max_m": f"{laser.range_max_m:g}",
        "laser_sd_mm": _mm(laser.noise_sd_m),
        "laser_step_mm": _mm(laser.quantum_m),
        "lost": _percent(laser.dropout_share),
    }


def _sonar() -> dict[str, str]:
    sonar = SonarConfig()
    half = sonar.opening_rad / 2.0
    return {
        "opening_deg": _degrees(sonar.opening_rad),
        "opening_half_deg": _degrees(half),
        "critical_deg": _degrees(sonar.critical_rad),
        "critical_sd_deg": _degrees(sonar.critical_sd_rad),
        "heard_deg": _degrees(half + sonar.critical_rad),
        "listening_deg": _degrees(sonar.listening_rad),
        "sonar_min_m": f"{sonar.range_min_m:g}",
        "sonar_max_m": f"{sonar.range_max_m:g}",
        "sonar_sd_mm": _mm(sonar.noise_sd_m),
        "sonar_sd": _percent(sonar.noise_sd_share),
        "sonar_step_mm": _mm(sonar.quantum_m),
        "sonar_miss": _percent(sonar.miss_share),
    }


def _mirror() -> dict[str, str]:
    config, image = OmniCameraConfig(), ImageConfig()
    camera = config.camera()
    distances = camera.floor_distance(_RADII_PX)
    lengths = camera.floor_distance(_RADII_PX + 0.5) - camera.floor_distance(_RADII_PX - 0.5)
    rows = zip(_RADII_PX, distances, lengths, strict=True)
    return {
        "omni_px": f"{config.width_px} x {config.height_px}",
        "mirror_rows": "\n".join(f"| {R:.0f} | {r:.2f} | {dr:.3f} |" for R, r, dr in rows),
        "a": f"{config.a_px_per_mm:g}",
        "b": f"{config.b_per_mm:g}",
        "c": f"{config.c_px2:g}",
        "viewpoint_mm": f"{1000.0 * camera.viewpoint_height:.0f}",
        "edge_px": f"{config.max_radius_px:g}",
        "below_deg": f"{-math.degrees(float(camera.elevation(config.max_radius_px))):.1f}",
        "blur_px": f"{image.blur_sd_px:g}",
        "vignetting": _percent(image.vignetting),
        "noise": f"{image.noise_sd:g}",
        "shot": f"{image.shot_noise:g}",
    }


def _stereo() -> dict[str, str]:
    model = load_robot(RobotPlacement(model="segway_stereo", position_m=(0.0, 0.0)))
    config, mounts = model.config.stereo, model.mounts
    assert config is not None
    left, right = (mounts[optical_frame("front", side)][:3, 3] for side in ("left", "right"))
    baseline = float(np.linalg.norm(left - right))
    return {
        "stereo_px": f"{config.width_px} x {config.height_px}",
        "stereo_fov_deg": _degrees(config.fov_rad),
        "focal_px": f"{config.focal_px:.1f}",
        "stereo_hz": f"{1.0 / config.period_s:g}",
        "baseline_m": f"{baseline:.2f}",
        "near_px": f"{baseline * config.focal_px:.1f}",
        "far_px": f"{baseline * config.focal_px / 4.0:.1f}",
    }


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.0f}"


def _mm(length: float) -> str:
    return f"{round(1000.0 * length, 1):g}"


def _percent(share: float) -> str:
    return f"{round(100.0 * share, 1 if share < 0.01 else 0):g} %"
