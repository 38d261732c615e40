"""Pictures of the stereo localization: the map with places and a drive, views beside the map's."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from experiments.stereo_localization_judge import METHODS
from experiments.stereo_places import Observer, Place
from floornav_common.reporting import Picture
from multi_localizer.stereo_view import VIEW_COLUMNS, VIEW_ROWS
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import VoxelScene

if TYPE_CHECKING:
    from experiments.stereo_drive import Step

_GOOD, _BAD = "#1a7f4b", "#d7301f"
_SHOWN = ("interval_dp", "monotone_dp", "color_only", "ours")


def seen_from_above(voxels: VoxelMap, below_m: float = 2.2) -> np.ndarray:
    """Return the highest color below a height at each cell, (rows, columns, 3), RGB, 0..1."""
    image = np.ones((*voxels.shape[1:], 3))
    for k in range(voxels.shape[0]):
        if voxels.origin_z_m + k * voxels.layer_m < below_m:
            on = voxels.occupied[k]
            image[on] = voxels.color[k][on] / 255.0
    return image


def draw_places(path: Path, voxels: VoxelMap, places: list[dict[str, Any]]) -> Picture:
    """Draw the map with each place, and a line from it to where each method says it is."""
    import matplotlib.pyplot as plt

    names = [name for name in _SHOWN if name in METHODS]
    figure, panels = plt.subplots(1, len(names), figsize=(15.0, 4.2), layout="constrained")
    for axes, name in zip(panels, names, strict=True):
        _draw_map(axes, voxels)
        for place in places:
            x, y, _ = place["pose"]
            found = place["found"][name]["pose"]
            is_near = found is not None and np.hypot(found[0] - x, found[1] - y) <= 0.08
            axes.plot(
                x, y, "o", ms=4, color="#1a7f4b" if is_near else "#d7301f", mec="white", mew=0.4
            )
            if found is not None and not is_near:
                axes.plot([x, found[0]], [y, found[1]], color="#d7301f", lw=0.9)
        axes.set_title(name, fontsize=10)
    figure.savefig(path, dpi=90)
    plt.close(figure)
    return Picture(path, "places; green: within 8 cm; red: with a line to what was found")


def draw_drive(path: Path, voxels: VoxelMap, steps: list[Step]) -> Picture:
    """Draw a drive on the map, and its error over the way."""
    import matplotlib.pyplot as plt

    figure, (plan, curve) = plt.subplots(
        1, 2, figsize=(11.0, 4.4), layout="constrained", width_ratios=[1.0, 1.4]
    )
    _draw_map(plan, voxels)
    true = np.array([(s.pose.x, s.pose.y) for s in steps])
    found = np.array([(s.found.pose.x, s.found.pose.y) for s in steps if s.found.pose is not None])
    plan.plot(*true.T, color="white", lw=2.5)
    plan.plot(*found.reshape(-1, 2).T, color=_BAD, lw=1.0)
    plan.set_title("white: the drive, red: what was found", fontsize=10)
    way = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(true, axis=0).T))))
    curve.plot(way, [100.0 * s.error for s in steps], color="#2b6cb0", lw=0.9)
    curve.set(xlabel="way [m]", ylabel="error [cm]", ylim=(0.0, None))
    curve.grid(alpha=0.3)
    figure.savefig(path, dpi=90)
    plt.close(figure)
    return Picture(path, "the drive, and the error of the pose along it")


def draw_views(path: Path, place: Place, observer: Observer, scene: VoxelScene) -> Picture:
    """Draw each pair's left image with its distances, as seen and as the map shows them."""
    pose = np.array([[place.pose.x, place.pose.y, place.pose.yaw]])
    rows = []
    for k, (view, camera) in enumerate(zip(place.seen.values(), observer.cameras, strict=True)):
        seen = place.views["ours"][k]
        assert seen is not None
        color, distance = scene.render(pose, camera, (VIEW_COLUMNS, VIEW_ROWS))
        top = scene.voxels.farthest_m
        tiles = [
            view.left[..., ::-1], _large(seen.color[..., ::-1], view.left.shape),
            _large(color[0][..., ::-1], view.left.shape),
            _large(_colored(seen.distance, top), view.left.shape),
            _large(_colored(distance[0], top), view.left.shape),
        ]  # fmt: skip
        rows.append(np.hstack([cv2.resize(tile, None, fx=0.75, fy=0.75) for tile in tiles]))
    cv2.imwrite(str(path), np.vstack(rows))
    return Picture(
        path,
        "front and rear: left image; its 320 x 8 pixels; the map's view from the very place; "
        "distances by our matcher; the map's",
    )


def _draw_map(axes: Any, voxels: VoxelMap) -> None:
    x, y = voxels.origin_x_m, voxels.origin_y_m
    width, depth, _ = voxels.size_m
    axes.imshow(
        seen_from_above(voxels), origin="lower", extent=(x, x + width, y, y + depth), alpha=0.85
    )
    axes.set(xlabel="x [m]", xlim=(x, x + width), ylim=(y, y + depth))


def _large(image: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    whole = np.clip(np.nan_to_num(image), 0, 255).astype(np.uint8)
    return cv2.resize(whole, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST)


def _colored(distance: np.ndarray, top: float) -> np.ndarray:
    gray = np.clip(np.nan_to_num(distance) * 255.0 / top, 0, 255).astype(np.uint8)
    colors = cv2.applyColorMap(gray, cv2.COLORMAP_TURBO)
    colors[np.isnan(distance)] = 0
    return np.asarray(colors)
