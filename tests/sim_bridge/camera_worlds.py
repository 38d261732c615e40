"""Tiny worlds with cameras in them, and cameras without noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.appearance import Floor, Light, Ring
from sim_bridge.world import RobotPlacement, World

CLEAN: dict[str, Any] = {
    "exposure": 1.0, "blur_sd_px": 0.0, "vignetting": 0.0, "noise_sd": 0.0, "shot_noise": 0.0,
}  # fmt: skip
FLAT_LIGHT = Light(shadow=0.0, ambient=1.0)


def ring_world(radii: tuple[float, ...], omni: dict[str, Any], pose: SE2 | None = None) -> World:
    """Return a black floor with white disks and rings of alternating radii around a robot."""
    pose = SE2.identity() if pose is None else pose
    reach = 1.02 * max(radii)
    disks = sorted(radii, reverse=True)
    rings = tuple(
        Ring(
            center_m=(pose.x, pose.y),
            radius_m=radius / 2.0,
            width_m=radius,
            color=(0.9, 0.9, 0.9) if k % 2 == 0 else (0.05, 0.05, 0.05),
        )
        for k, radius in enumerate(disks)
    )
    floor = Floor(
        color=(0.05, 0.05, 0.05),
        from_m=(pose.x - reach, pose.y - reach),
        to_m=(pose.x + reach, pose.y + reach),
        texel_m=max(0.001, reach / 1500.0),
        carpet=0.0,
        rings=rings,
    )
    robot = RobotPlacement(
        model="soccer_small_size",
        position_m=(pose.x, pose.y),
        yaw_deg=math.degrees(pose.yaw),
        overrides={"omni": {"samples": 4, "image": CLEAN, **omni}},
    )
    return World(name="rings", floor=floor, light=FLAT_LIGHT, robots=(robot,))


def edge_radius(image: np.ndarray, center: tuple[float, float], near: float) -> float:
    """Return the mean pixel radius of the step in brightness nearest to a radius.

    Along each of 180 directions the step's place is where half of its height is crossed.
    """
    gray = image.astype(float).mean(axis=2)
    radii = near + np.linspace(-2.5, 2.5, 101)
    found = []
    for angle in np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False):
        u, v = center[0] + radii * math.cos(angle), center[1] + radii * math.sin(angle)
        values = bilinear(gray, u, v)
        low, high = values[0], values[-1]
        share = (values - low) / (high - low)
        k = int(np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5))[0])
        found.append(np.interp(0.5, share[k : k + 2], radii[k : k + 2]))
    return float(np.mean(found))


def bilinear(gray: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return an image's values between its pixels."""
    j, i = np.floor(u).astype(int), np.floor(v).astype(int)
    x, y = u - j, v - i
    low = (1 - x) * gray[i, j] + x * gray[i, j + 1]
    top = (1 - x) * gray[i + 1, j] + x * gray[i + 1, j + 1]
    return np.asarray((1 - y) * low + y * top)
