"""Pictures of simulated worlds for docs/: from above, and what each robot's cameras see."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from _tour_ride import Ride, ride
from sim_bridge.camera_config import optical_frame
from sim_bridge.drawing import (
    PERSON,
    ROBOT,
    draw_beams,
    draw_from_above,
    draw_laser,
    draw_legend,
    draw_robot,
    extent_of,
    plain,
)
from sim_bridge.snapshot import Snapshot
from sim_bridge.world import World
from sim_bridge.world_picture import without_cameras

ROBOTS = ("#1a7f4b", "#2b7de0", "#8a5cc2", "#b5651d", "#0f8a8a", "#c2185b", "#5d7a00", "#455a64")
MIDDLE = {"ha": "center", "va": "center"}
_DPI = 100
_WIDTH_IN, _MIRROR_IN = 9.0, 5.6
_STILL_S = 0.3
_CIRCLE = np.column_stack([f(np.linspace(0.0, 2.0 * np.pi, 25)) for f in (np.cos, np.sin)])


def write_drive(path: Path, world: World, duration_s: float, seed: int) -> None:
    """Draw robots with laser, and people, in the midst of a drive."""
    import matplotlib.pyplot as plt

    ridden = ride(plain(without_cameras(world)), duration_s, seed)
    low, high = extent_of(ridden.simulation)
    share = float((high - low)[1] / (high - low)[0])
    width = min(9.0, 8.0 / share)
    figure, axes = plt.subplots(figsize=(width, width * share + 0.7), layout="constrained")
    draw_from_above(axes, ridden.simulation)
    if len(ridden.last) == 1:
        _draw_robot_alone(axes, ridden)
    else:
        _draw_fleet(axes, ridden)
    _draw_people(axes, ridden)
    ridden.simulation.close()
    draw_legend(figure, [axes])
    save(path, figure)


def write_mirrors(path: Path, world: World, seed: int) -> None:
    """Draw a field from above, and below it the image of every robot's mirror."""
    import matplotlib.pyplot as plt

    ridden = ride(world, _STILL_S, seed, is_driven=False)
    low, high = extent_of(ridden.simulation)
    images = list(ridden.omni.items())
    columns = min(len(images), 2)
    rows = -(-len(images) // columns)
    height, width = images[0][1].shape[:2]
    tall = _WIDTH_IN * float((high - low)[1] / (high - low)[0])
    mirror = _MIRROR_IN * height / width if columns == 1 else _WIDTH_IN / 2.0 * height / width
    figure = plt.figure(figsize=(_WIDTH_IN, tall + rows * (mirror + 0.25)), layout="constrained")
    cells = figure.add_gridspec(1 + rows, columns, height_ratios=[tall, *[mirror] * rows])
    plan = figure.add_subplot(cells[0, :])
    draw_from_above(plan, ridden.simulation)
    for k, (name, image) in enumerate(images):
        _write_name(plan, ridden, name)
        axes = figure.add_subplot(cells[1 + k // columns, k % columns])
        draw_image(axes, image)
        who = f"mirror of {name}" if name else "in the robot's mirror"
        axes.set_title(f"{who}, {width} x {height} pixels", fontsize=10)
        mark_sides(axes, image)
    ridden.simulation.close()
    save(path, figure)


def write_stereo(path: Path, world: World, seed: int) -> None:
    """Draw a room from above, and the images of every pair of cameras."""
    import matplotlib.pyplot as plt

    ridden = ride(world, _STILL_S, seed, is_driven=False)
    name, pairs = next(iter(ridden.stereo.items()))
    seen = ridden.last[name]
    figure = plt.figure(figsize=(12.6, 5.4), layout="constrained")
    cells = figure.add_gridspec(len(pairs), 3, width_ratios=[1.25, 1.0, 1.0])
    plan = figure.add_subplot(cells[:, 0])
    draw_from_above(plan, ridden.simulation)
    draw_laser(plan, seen, size=4.0, color="#ff5040")
    for row, (pair, images) in enumerate(pairs.items()):
        _draw_view_angle(plan, seen, pair)
        for column, side in enumerate(("left", "right")):
            axes = figure.add_subplot(cells[row, 1 + column])
            draw_image(axes, getattr(images, side))
            axes.set_title(f"stereo/{pair}/{side}", fontsize=10)
    plan.set_title("view angles of both pairs; red: ends of the laser's beams", fontsize=10)
    ridden.simulation.close()
    save(path, figure)


def save(path: Path, figure: Any) -> None:
    """Write a figure without empty edges."""
    import matplotlib.pyplot as plt

    figure.savefig(path, dpi=_DPI, bbox_inches="tight", pad_inches=0.06)
    plt.close(figure)


def draw_image(axes: Any, image: np.ndarray) -> None:
    """Draw a camera's image without axes."""
    axes.imshow(image, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])


def mark_sides(axes: Any, image: np.ndarray) -> None:
    """Say where the robot's front and left are in a mirror's image."""
    box = {"facecolor": "black", "alpha": 0.6, "lw": 0.0, "pad": 2.0}
    style = {"color": "white", "fontsize": 8, "bbox": box, **MIDDLE}
    height, width = image.shape[:2]
    axes.text(0.95 * width, height / 2, "front", rotation=90, **style)
    axes.text(width / 2, 0.965 * height, "left", **style)


def _write_name(axes: Any, ridden: Ride, name: str) -> None:
    if name:
        ends = ridden.last[name].T_world_base @ np.array([[0.0, 0.0], [0.6, 0.0]])
        axes.annotate("", ends[1], ends[0], arrowprops={"arrowstyle": "->", "color": "white"})
        axes.text(*(ends[0] + (0.0, 0.34)), name, color="white", ha="center", fontsize=11)


def _draw_view_angle(axes: Any, seen: Snapshot, pair: str) -> None:
    config, mounts = seen.model.config.stereo, seen.model.mounts
    assert config is not None
    left, right = (mounts[optical_frame(pair, side)] for side in ("left", "right"))
    place, ahead = (left + right)[:2, 3] / 2.0, np.arctan2(left[1, 2], left[0, 2])
    angles = ahead + config.fov_rad / 2.0 * np.array([-1.0, 1.0])
    ends = place + 1.3 * np.column_stack((np.cos(angles), np.sin(angles)))
    points = seen.T_world_base @ np.vstack((ends[:1], place, ends[1:]))
    axes.plot(*points.T, color="white", lw=1.6, zorder=6)
    middle = seen.T_world_base @ (place + 1.0 * np.array([[np.cos(ahead), np.sin(ahead)]]))
    axes.text(*middle[0], pair, color="white", fontsize=11, zorder=6, **MIDDLE)


def _draw_robot_alone(axes: Any, ridden: Ride) -> None:
    ((name, seen),) = ridden.last.items()
    draw_beams(axes, seen, alpha=0.13)
    draw_laser(axes, seen, size=3.0, label="laser: end of a beam")
    axes.plot(*np.array(ridden.ways[name]).T, color=ROBOT, lw=1.6, zorder=4, label="robot's way")
    draw_robot(axes, seen, width=1.4)


def _draw_fleet(axes: Any, ridden: Ride) -> None:
    box = {"facecolor": "white", "lw": 0.0, "pad": 1.5}
    for number, (name, seen) in enumerate(ridden.last.items()):
        color = ROBOTS[number % len(ROBOTS)]
        draw_laser(axes, seen, color=color, size=4.0)
        axes.plot(*np.array(ridden.ways[name]).T, color=color, lw=1.6, zorder=4)
        draw_robot(axes, seen, color=color, width=1.8)
        x, y = ridden.ways[name][0]
        axes.text(x, y, name, color=color, fontsize=11, bbox=box, **MIDDLE)
    axes.set_title("one color a robot: its way, its outline, the ends of its beams", fontsize=10)


def _draw_people(axes: Any, ridden: Ride) -> None:
    radius = ridden.simulation.world.people_model.torso_radius_m
    for way in ridden.people.values():
        axes.plot(*np.array(way).T, color=PERSON, lw=0.9, ls=":", zorder=3)
    for person in ridden.people_now:
        color = PERSON if person.has_noticed else "white"
        text = "person who has noticed the robot" if person.has_noticed else "person, way dotted"
        axes.fill(
            *(person.pose @ (radius * _CIRCLE)).T, facecolor=color, edgecolor=PERSON, lw=1.5,
            zorder=6, label=text,
        )  # fmt: skip
        ends = person.pose @ np.array([[0.0, 0.0], [2.2 * radius, 0.0]])
        axes.plot(*ends.T, color=PERSON, lw=1.5, zorder=6)
