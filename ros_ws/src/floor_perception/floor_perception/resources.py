"""Files that parameters name: by path, or by the name of one in the package."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import cv2
import numpy as np

from floornav_common.camera_files import load_floor_camera
from floornav_common.floor_camera import FloorCamera


def find_file(name_or_path: str, folder: str) -> Path:
    """Return the path of a YAML file.

    Args:
        name_or_path: A path that ends in `.yaml` or `.yml`, or a name in the package's folder.
        folder: That folder: `camera_models` or `colors`.

    Raises:
        ValueError: There is no such name.
    """
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    place = resources.files("floor_perception") / folder
    known = sorted(f.name[: -len(".yaml")] for f in place.iterdir() if f.name.endswith(".yaml"))
    if name_or_path not in known:
        raise ValueError(
            f"no file named {name_or_path!r} in {folder}: a path ending in .yaml or one of "
            f"{', '.join(known)}"
        )
    return Path(str(place / f"{name_or_path}.yaml"))


def load_camera_model(name_or_path: str) -> FloorCamera:
    """Return the camera that the parameter `camera_model` names.

    Raises:
        ValueError: There is none, or the file does not hold to the schema.
        OSError: The file cannot be read.
    """
    return load_floor_camera(find_file(name_or_path, "camera_models"))


def load_hidden_mask(path: str) -> np.ndarray | None:
    """Return the picture that the parameter `hidden_mask` names, (H, W), uint8; None for "".

    Raises:
        ValueError: The file is no picture.
    """
    if not path:
        return None
    picture = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise ValueError(f"hidden_mask: {path} is not a picture that can be read")
    return picture
