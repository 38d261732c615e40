"""A map of layers: a colored voxel grid (stereo paper, section 3.1), and its file.

The file is numpy's npz with the arrays `color` (layers, rows, columns, 3) uint8, `occupied`
(layers, rows, columns) bool, `cell_m`, `layer_m`, `origin_m` (x, y, z), `frame`, and `format`,
`version`, by which it is known. Floor and ceiling are layers like all others: a floor at z = 0 is
a layer that ends there.
"""

from __future__ import annotations

import os
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FORMAT, VERSION = "floornav voxel map", 1
_PARTS = ("version", "frame", "color", "occupied", "cell_m", "layer_m", "origin_m")
_UNREADABLE = (
    ValueError, OSError, EOFError, KeyError, NotImplementedError, RuntimeError, MemoryError,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What numpy and zipfile raise on a file that is none of theirs, or is damaged."""
_NUMBERS = ("cell_m", "layer_m", "origin_x_m", "origin_y_m", "origin_z_m")


@dataclass(frozen=True, eq=False)
class VoxelMap:
    """Boxes of one color each, in layers; rows along +y, columns along +x, not turned.

    Attributes:
        color: RGB, (layers, rows, columns, 3), uint8; 0 where nothing is.
        occupied: Where something is, (layers, rows, columns), bool.
        cell_m: Edge of a voxel along x and y.
        layer_m: Its height.
        origin_x_m: Least x of the first column, in the map's frame.
        origin_y_m: Least y of the first row.
        origin_z_m: Foot of the first layer.
        frame: Name of the map's frame.
    """

    color: np.ndarray
    occupied: np.ndarray
    cell_m: float
    layer_m: float
    origin_x_m: float = 0.0
    origin_y_m: float = 0.0
    origin_z_m: float = 0.0
    frame: str = "map"

    def __post_init__(self) -> None:
        if self.occupied.ndim != 3 or 0 in self.occupied.shape:
            raise ValueError(f"occupied must be (layers, rows, cols), got {self.occupied.shape}")
        if self.color.shape != (*self.occupied.shape, 3):
            raise ValueError(
                f"color must be {(*self.occupied.shape, 3)} as occupied is, got {self.color.shape}"
            )
        if self.color.dtype != np.uint8 or self.occupied.dtype != np.bool_:
            raise ValueError(
                "color must be uint8 and occupied bool, got "
                f"{self.color.dtype} and {self.occupied.dtype}"
            )
        for name in _NUMBERS:
            value = float(getattr(self, name))
            if not np.isfinite(value):
                raise ValueError(f"{name} must be finite, got {value}")
            object.__setattr__(self, name, value)
        for name in ("cell_m", "layer_m"):
            if getattr(self, name) <= 0.0:
                raise ValueError(f"{name} must be above 0, got {getattr(self, name)}")

    @property
    def shape(self) -> tuple[int, int, int]:
        """Layers, rows, columns."""
        layers, rows, columns = self.occupied.shape
        return layers, rows, columns

    @property
    def size_m(self) -> tuple[float, float, float]:
        """Extent along x, y and z."""
        layers, rows, columns = self.shape
        return columns * self.cell_m, rows * self.cell_m, layers * self.layer_m

    @property
    def farthest_m(self) -> float:
        """The map's diagonal in the plane: nothing in it is farther."""
        return float(np.hypot(*self.size_m[:2]))


def save_voxel_map(path: Path | str, voxels: VoxelMap, overwrite: bool = False) -> Path:
    """Write a map, whole or not at all.

    Args:
        path: Of the file; its folder must exist.
        voxels: The map.
        overwrite: True to replace a file of that name.

    Returns:
        The path.

    Raises:
        FileExistsError: If a file is there and `overwrite` is False.
        OSError: If it cannot be written; then nothing is left behind.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"no folder {path.parent}: make it, or name another file")
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists; choose another name")
    descriptor, unfinished = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            np.savez_compressed(
                file, format=FORMAT, version=VERSION, frame=voxels.frame,
                color=np.where(voxels.occupied[..., None], voxels.color, np.uint8(0)),
                occupied=voxels.occupied, cell_m=voxels.cell_m, layer_m=voxels.layer_m,
                origin_m=[voxels.origin_x_m, voxels.origin_y_m, voxels.origin_z_m],
            )  # fmt: skip
        os.chmod(unfinished, 0o666 & ~_umask())
        os.replace(unfinished, path)
    except BaseException:
        Path(unfinished).unlink(missing_ok=True)
        raise
    return path


def load_voxel_map(path: Path | str) -> VoxelMap:
    """Read a map; `~` stands for the user's folder.

    Raises:
        FileNotFoundError: If there is no file.
        ValueError: If it is no such map, is cut off, or its parts do not fit together.
    """
    path = Path(path).expanduser()
    if not path.is_file():
        raise FileNotFoundError(f"no voxel map {path}")
    try:
        with path.open("rb") as file:
            parts = np.load(file, allow_pickle=False)
            values = dict(parts) if isinstance(parts, Mapping) else {}
    except _UNREADABLE as error:
        # numpy's advice to load pickles must not reach the user.
        why = "" if isinstance(error, ValueError) else f": {error}"
        raise ValueError(f"{path} is no voxel map, or is damaged{why}") from error
    if str(values.get("format")) != FORMAT:
        raise ValueError(f"{path} is no voxel map: it lacks the format {FORMAT!r}")
    missing = [name for name in _PARTS if name not in values]
    if missing:
        raise ValueError(f"{path} is a damaged voxel map: it lacks {', '.join(missing)}")
    try:
        if int(values["version"]) != VERSION:
            raise ValueError(f"it is of version {values['version']}, this reads {VERSION}")
        x, y, z = (float(v) for v in values["origin_m"])
        return VoxelMap(
            values["color"], values["occupied"], float(values["cell_m"]),
            float(values["layer_m"]), x, y, z, str(values["frame"]),
        )  # fmt: skip
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{path} is a damaged voxel map: {error}") from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
