"""A floor's color as YAML: what the parameter `color.file` names.

The keys are `kind: floor_color`, `chroma` (r, g), `cov` (2 x 2), and `low`, `middle`, `high`: the
brightness R + G + B of its darkest parts, its median, its brightest parts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from floor_perception.color_model import FloorColor
from floornav_common.reporting import write_atomic

_KEYS = ("chroma", "cov", "low", "middle", "high")


def save_color(color: FloorColor, path: Path) -> None:
    """Write a floor's color."""
    values = {"kind": "floor_color", **{k: np.asarray(getattr(color, k)).tolist() for k in _KEYS}}
    write_atomic(path, yaml.safe_dump(values, sort_keys=False, default_flow_style=None))


def load_color(path: Path) -> FloorColor:
    """Read a floor's color.

    Raises:
        ValueError: Not such a file, or values that are no color.
        OSError: The file cannot be read.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict) or data.get("kind") != "floor_color":
        raise ValueError(f"{path}: expected a mapping with kind: floor_color")
    if set(data) != {"kind", *_KEYS}:
        raise ValueError(f"{path}: keys must be kind, {', '.join(_KEYS)}, got {', '.join(data)}")
    try:
        chroma, cov = (np.asarray(data[k], dtype=float) for k in ("chroma", "cov"))
        low, middle, high = (float(data[k]) for k in ("low", "middle", "high"))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: values must be numbers: {error}") from error
    if chroma.shape != (2,) or cov.shape != (2, 2) or not np.allclose(cov, cov.T):
        raise ValueError(f"{path}: chroma must be 2 numbers and cov 2 x 2, symmetric")
    if not (np.linalg.eigvalsh(cov) > 0.0).all() or not 0.0 < low <= middle <= high:
        raise ValueError(f"{path}: cov must be positive, and 0 < low <= middle <= high")
    return FloorColor(chroma, cov, low, middle, high)
