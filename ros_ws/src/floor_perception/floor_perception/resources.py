"""Files that parameters name: by path, or by the name of one in the package."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from floornav_common import package_files
from floornav_common.camera_files import load_camera_model

__all__ = ["find_file", "load_camera_model", "load_hidden_mask"]


def find_file(name_or_path: str, folder: str) -> Path:
    """Return the path of a YAML file: by path, or by the name of one in a folder of the package.

    Raises:
        ValueError: There is no such name.
    """
    return package_files.find_file(name_or_path, "floor_perception", folder)


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
