"""A folder of posed views: RGB-D images or stereo pairs, and where the camera was.

    camera.yaml   fx, fy, cx, cy (px), and depth_per_m or baseline_m
    poses.txt     stamp x y z qx qy qz qw of the (left) optical frame in the map (TUM's format)
    color/<stamp>.png with depth/<stamp>.png (16 bit, depth_per_m a meter, 0 = unknown)
    left/<stamp>.png with right/<stamp>.png (rectified, baseline_m apart): distances are matched

Each camera has a folder of its own. A TUM RGB-D sequence becomes one by renaming `rgb` and
`groundtruth.txt`, with depth_per_m: 5000. An image takes the pose nearest to its stamp, at most
20 ms away; others are passed over, and so are those whose other half (depth, right) is not there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_matcher import StereoMatcher
from multi_localizer.voxel_fusion import PosedView

_NEAREST_S = 0.02
_LEAST_DOWN = -0.5
_KEYS = ("fx", "fy", "cx", "cy")


@dataclass(frozen=True, eq=False)
class PosedViews:
    """The views of a folder.

    Attributes:
        views: In the order of their stamps.
        is_stereo: Whether distances were matched; their errors grow with the distance.
        num_without_pose: How many images were passed over, as they have no pose.
        num_single: How many, as their depth or right image is not there.
    """

    views: list[PosedView]
    is_stereo: bool
    num_without_pose: int
    num_single: int

    @property
    def are_upright(self) -> bool:
        """Whether in most views down in the image is down in the map."""
        down = [view.T_map_camera[2, 1] for view in self.views]
        return float(np.median(down)) < _LEAST_DOWN


def load_all_views(
    folders: Sequence[Path], on_view: Callable[[int, int], None] = lambda done, total: None
) -> PosedViews:
    """Read folders of views, one a camera, all of one kind and image size.

    Raises:
        ValueError: If that is not so, or as `load_posed_views`.
    """
    loaded = [load_posed_views(folder, on_view) for folder in folders]
    if len({one.is_stereo for one in loaded}) > 1:
        raise ValueError("folders hold stereo pairs and RGB-D images: make a map of one kind")
    sizes = {one.views[0].depth.shape: folder for one, folder in zip(loaded, folders, strict=True)}
    if len(sizes) > 1:
        text = ", ".join(f"{w} x {h} in {folder}" for (h, w), folder in sizes.items())
        raise ValueError(f"the images must be of one size: {text}")
    return PosedViews(
        [view for one in loaded for view in one.views],
        loaded[0].is_stereo,
        sum(one.num_without_pose for one in loaded),
        sum(one.num_single for one in loaded),
    )


def load_posed_views(
    folder: Path, on_view: Callable[[int, int], None] = lambda done, total: None
) -> PosedViews:
    """Read a folder of views.

    Args:
        folder: See above.
        on_view: Called after each view with how many are read, and of how many.

    Raises:
        ValueError: If it is none, or a file in it is not as it should be; says which.
    """
    camera = _camera(folder / "camera.yaml")
    stamps, T_map_camera = _poses(folder / "poses.txt")
    is_stereo = (folder / "left").is_dir()
    first, second = ("left", "right") if is_stereo else ("color", "depth")
    needed = "baseline_m" if is_stereo else "depth_per_m"
    if not camera.get(needed, 0.0) > 0.0:
        raise ValueError(f"{folder / 'camera.yaml'}: {needed} must be above 0")
    names = sorted((p.name for p in (folder / first).glob("*.png")), key=_stamp)
    if not names:
        raise ValueError(f"{folder}: no images in color/ or left/")
    depth_of = _matched(camera) if is_stereo else _measured(camera)
    views, num_without, num_single = [], 0, 0
    for k, name in enumerate(names):
        gaps = np.abs(stamps - _stamp(name))
        if gaps.min() > _NEAREST_S:
            num_without += 1
            continue
        if not (folder / second / name).is_file():
            num_single += 1
            continue
        image = cv2.cvtColor(_read(folder / first / name, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        depth = depth_of(image, folder / second / name)
        focal, center = (camera["fx"], camera["fy"]), (camera["cx"], camera["cy"])
        try:
            view = PosedView(T_map_camera[int(gaps.argmin())], image, depth, focal, center)
        except ValueError as error:
            raise ValueError(f"{folder / second / name}: {error}") from error
        views.append(view)
        on_view(k + 1, len(names))
    if not views and num_single:
        raise ValueError(f"{folder}: no image in {first}/ has its other half in {second}/")
    if not views:
        raise ValueError(f"{folder}: no image has a pose within {_NEAREST_S:g} s of its stamp")
    return PosedViews(views, is_stereo, num_without, num_single)


def _matched(camera: dict[str, float]) -> Callable[[np.ndarray, Path], np.ndarray]:
    matcher = StereoMatcher(StereoMatcherConfig())
    scale = camera["fx"] * camera["baseline_m"]

    def depth_of(left: np.ndarray, path: Path) -> np.ndarray:
        right = cv2.cvtColor(_read(path, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        if right.shape != left.shape:
            raise ValueError(f"{path}: the pair's sizes differ, {left.shape} and {right.shape}")
        disparity = matcher.match(left, right)
        return np.asarray(scale / np.where(disparity > 0.0, disparity, np.nan))

    return depth_of


def _measured(camera: dict[str, float]) -> Callable[[np.ndarray, Path], np.ndarray]:
    def depth_of(_: np.ndarray, path: Path) -> np.ndarray:
        raw = _read(path, cv2.IMREAD_UNCHANGED)
        if raw.ndim != 2 or raw.dtype != np.uint16:
            raise ValueError(f"{path}: depth must be a gray image of 16 bit, got {raw.dtype}")
        return np.asarray(np.where(raw > 0, raw / camera["depth_per_m"], np.nan))

    return depth_of


def _camera(path: Path) -> dict[str, float]:
    if not path.is_file():
        raise ValueError(f"no file {path}: it says what the camera is")
    values = yaml.safe_load(path.read_text(encoding="utf-8"))
    values = values if isinstance(values, dict) else {}
    known = {*_KEYS, "baseline_m", "depth_per_m"}
    bad = [k for k in _KEYS if k not in values]
    if bad or set(values) - known:
        wrong = f"lacks {', '.join(bad)}" if bad else f"has {sorted(set(values) - known)}"
        raise ValueError(f"{path}: {wrong}; keys are {', '.join(sorted(known))}")
    if {"baseline_m", "depth_per_m"} <= set(values):
        raise ValueError(f"{path}: baseline_m is for stereo pairs, depth_per_m for RGB-D; not both")
    try:
        return {key: float(value) for key, value in values.items()}
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def _poses(path: Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        rows = np.atleast_2d(np.loadtxt(path, comments="#"))
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error
    if rows.shape[1] != 8 or not np.isfinite(rows).all():
        raise ValueError(f"{path}: rows must be stamp x y z qx qy qz qw")
    T = np.tile(np.eye(4), (len(rows), 1, 1))
    T[:, :3, :3] = Rotation.from_quat(rows[:, 4:]).as_matrix()
    T[:, :3, 3] = rows[:, 1:4]
    return rows[:, 0], T


def _stamp(name: str) -> float:
    try:
        return float(name.removesuffix(".png"))
    except ValueError as error:
        raise ValueError(f"{name}: an image's name must be its stamp in seconds") from error


def _read(path: Path, flags: int) -> np.ndarray:
    image = cv2.imread(str(path), flags) if path.is_file() else None
    if image is None:
        raise ValueError(f"{path}: no image that can be read")
    return image
