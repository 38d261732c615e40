"""Pictures for docs/ of what the simulated cameras see, labeled: a field in the mirror, a pair."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from _docs_world_pictures import MIDDLE, draw_image, mark_sides, save
from _tour_ride import ride
from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera
from floornav_common.se2 import SE2
from sim_bridge.camera_config import OmniCameraConfig, optical_frame
from sim_bridge.snapshot import Snapshot
from sim_bridge.solids import solids_of
from sim_bridge.world import World, load_world
from sim_bridge.world_picture import placed

_INK, _DISTANCE, _LENGTH = "#6b7480", "#1a7f4b", "#d7301f"
_MARKS = ("#ffe14d", "#7df9ff", "#ff9ad5")
_RINGS_M = (0.3, 0.5, 1.0, 2.0)
_NAMED = (  # things of small_size_field: where they are, m, and how far out their names stand, px
    ("blue goal", (-1.47, -0.1), 175.0),
    ("cube", (-0.80, 0.25), 305.0),
    ("ball", (0.30, -0.15), 130.0),
    ("center circle", (-0.05, 0.24), 290.0),
    ("wall", (-0.3, -0.76), 165.0),
)
_STEREO_POSE = SE2(1.6, 2.05, math.radians(36.0))
_BOX = {"facecolor": "black", "alpha": 0.6, "lw": 0.0, "pad": 2.0}


def write_mirror(path: Path, seed: int) -> None:
    """Draw a labeled mirror image of the small-size field, and eq. 26 with its error a pixel."""
    import matplotlib.pyplot as plt

    world = load_world("small_size_field")
    large = {"omni": {"width_px": 640, "height_px": 550}}
    robot = replace(world.robots[0], overrides=large)
    ridden = ride(replace(world, robots=(robot,)), 0.3, seed, is_driven=False)
    config = ridden.simulation.models[""].config.omni
    assert config is not None
    ridden.simulation.close()
    figure, (field, curve) = plt.subplots(
        1, 2, figsize=(11.5, 5.2), layout="constrained", width_ratios=[1.25, 1.0]
    )
    draw_image(field, ridden.omni[""])
    mark_sides(field, ridden.omni[""])
    _draw_rings(field, config.camera())
    _draw_names(field, config.camera(), robot.pose)
    field.set_title("640 x 550 pixels; rings: distance on the floor (eq. 26)", fontsize=10)
    _draw_eq26(curve)
    save(path, figure)


def write_stereo_pair(path: Path, seed: int) -> None:
    """Draw the front pair with the disparity of a few corners of known place."""
    import matplotlib.pyplot as plt

    world = placed(load_world("stereo_room"), _STEREO_POSE)
    ridden = ride(world, 0.3, seed, is_driven=False)
    images, seen = ridden.stereo[""]["front"], ridden.last[""]
    ridden.simulation.close()
    corners = _corners_seen(world, seen)
    figure, panels = plt.subplots(1, 2, figsize=(11.5, 4.5), layout="constrained")
    for axes, side, image in zip(
        panels, ("left", "right"), (images.left, images.right), strict=True
    ):
        draw_image(axes, image)
        axes.set_title(f"front/{side}", fontsize=10)
        for number, (depth, left, right) in enumerate(corners):
            color = _MARKS[number]
            u, v = left if side == "left" else right
            axes.axhline(v, color=color, lw=0.7, alpha=0.7)
            axes.plot(u, v, "o", mfc="none", mec=color, ms=9, mew=1.8)
            if side == "right":
                axes.plot([u, left[0]], [v, v], color=color, lw=3.0)
                text = f"{left[0] - u:.1f} px: {depth:.2f} m"
                axes.text(left[0] + 8, v, text, color=color, fontsize=9, va="center", bbox=_BOX)
    save(path, figure)


def _draw_rings(axes: Any, camera: MirrorCamera) -> None:
    import matplotlib.pyplot as plt

    for distance in _RINGS_M:
        radius, angle = float(camera.floor_radius(distance)), math.radians(-115.0)
        ring = plt.Circle((camera.center_u_px, camera.center_v_px), radius, fill=False)
        ring.set(edgecolor="white", lw=0.8, ls=(0, (4, 4)), alpha=0.8)
        axes.add_patch(ring)
        u = camera.center_u_px + radius * math.cos(angle)
        v = camera.center_v_px + radius * math.sin(angle)
        axes.text(u, v, f"{distance:g} m", color="white", fontsize=8, bbox=_BOX, **MIDDLE)


def _draw_names(axes: Any, camera: MirrorCamera, pose: SE2) -> None:
    """Write the names of a few things beside them, in the direction away from the middle."""
    for name, point, radius in _NAMED:
        x, y = (pose.inverse() @ np.array([point]))[0]
        R, bearing = float(camera.floor_radius(math.hypot(x, y))), math.atan2(y, x)
        center = np.array([camera.center_u_px, camera.center_v_px])
        ahead = np.array([math.cos(bearing), math.sin(bearing)])
        axes.annotate(
            name, center + R * ahead, center + radius * ahead, color="white", fontsize=9,
            bbox=_BOX, arrowprops={"arrowstyle": "->", "color": "white"}, **MIDDLE,
        )  # fmt: skip


def _draw_eq26(axes: Any) -> None:
    config = OmniCameraConfig()
    camera = config.camera()
    radii = np.linspace(25.0, config.max_radius_px, 300)
    distances = camera.floor_distance(radii)
    axes.semilogy(radii, distances, color=_DISTANCE, lw=1.8, label="distance on the floor, m")
    axes.semilogy(
        radii,
        np.gradient(distances, radii),
        color=_LENGTH,
        lw=1.8,
        label="length of a pixel there, m",
    )
    axes.axvline(camera.horizon_radius, color=_INK, ls=":", lw=1.2)
    axes.text(camera.horizon_radius, 0.004, " horizon", color=_INK, rotation=90, ha="right")
    axes.set(xlabel="radius in the image of 256 x 220 [px]", xlim=(25.0, 116.0))
    axes.set_title("eq. 26: far away a pixel is long", fontsize=10)
    axes.grid(alpha=0.25, which="both")
    axes.legend(frameon=False)


def _corners_seen(world: World, seen: Snapshot) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return depth and place in both images of a carpet's corner, a crate's and the ceiling's."""
    config = seen.model.config.stereo
    assert config is not None
    crate = next(solid for solid in solids_of(world) if solid.name == "crate")
    carpet, room = world.floor.areas[0].to_m, world.floor.to_m
    corners = [
        (*carpet, 0.0),
        (*crate.outline()[0], crate.size[2]),
        (*room, world.ceiling_m or 0.0),
    ]
    middle = np.array([(config.width_px - 1) / 2.0, (config.height_px - 1) / 2.0])
    found = []
    for corner in corners:
        pixels, depth = [], 0.0
        here = seen.T_world_base.inverse() @ np.array([corner[:2]])
        for side in ("left", "right"):
            T = np.linalg.inv(seen.model.mounts[optical_frame("front", side)])
            x, y, depth = (T @ np.array([*here[0], corner[2], 1.0]))[:3]
            pixels.append(middle + config.focal_px * np.array([x, y]) / depth)
        found.append((float(depth), pixels[0], pixels[1]))
    return found
