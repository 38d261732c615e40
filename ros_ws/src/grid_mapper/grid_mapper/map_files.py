"""Map files in the format of map_server: a YAML file beside an image.

The image's first row is the map's last. Modes and thresholds are those of nav2_map_server:
`trinary` keeps occupied / free / unknown, `scale` keeps 0..100 as grey with unknown transparent
(PNG, since PGM has no transparency), `raw` keeps every value. `free_thresh` is 0.196, so that the
grey value 205 of an unknown cell is read as unknown by every version of map_server.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2

MODES = ("trinary", "scale", "raw")
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
PIXEL_UNKNOWN, PIXEL_FREE, PIXEL_OCCUPIED = 205, 254, 0
A_MAP_FILE = "which is the .yaml that map_bag or save_map wrote"


def save_map(
    prefix: Path | str, grid: OccupancyMap, mode: str = "trinary", overwrite: bool = False
) -> Path:
    """Write `PREFIX.yaml` and its image, whole or not at all.

    Args:
        prefix: Path without ending; its folder must exist.
        grid: The map.
        mode: `trinary`, `scale` or `raw`.
        overwrite: True to replace files of that name.

    Returns:
        Path of the YAML file.

    Raises:
        ValueError: If the mode is unknown or the map has no cells.
        FileExistsError: If a file is there and `overwrite` is False.
        OSError: If the files cannot be written; then neither is left behind.
    """
    if mode not in MODES:
        raise ValueError(f"mode must be one of {', '.join(MODES)}, got {mode!r}")
    if grid.cells.size == 0:
        raise ValueError("the map has no cells yet, so there is nothing to save")
    ending = ".png" if mode == "scale" else ".pgm"
    yaml_path, image_path = Path(f"{prefix}.yaml"), Path(f"{prefix}{ending}")
    if not yaml_path.parent.is_dir():
        raise FileNotFoundError(f"no folder {yaml_path.parent}: make it, or name another map_file")
    for path in (yaml_path, image_path):
        if path.exists() and not overwrite:
            raise FileExistsError(f"{path} exists; choose another name")
    ok, image = cv2.imencode(ending, _to_image(grid.cells, mode)[::-1])
    if not ok:
        raise OSError(f"cannot encode {image_path}")
    occupied, free = (1.0, 0.0) if mode == "scale" else (OCCUPIED_THRESH, FREE_THRESH)
    header = {
        "image": image_path.name,
        "mode": mode,
        "resolution": float(grid.resolution),
        "origin": [float(v) for v in grid.origin.as_array()],
        "negate": 0,
        "occupied_thresh": occupied,
        "free_thresh": free,
    }
    text = yaml.safe_dump(header, sort_keys=False, default_flow_style=None)
    _write_both(image_path, image.tobytes(), yaml_path, text.encode())
    return yaml_path


def free_prefix(prefix: Path | str, suffixes: Iterable[str] = ("",)) -> str:
    """Return `prefix`, or `prefix-2`, `prefix-3` ... if a map of that name is there.

    Args:
        prefix: Path without ending.
        suffixes: Behind each name, of maps that are saved together.
    """
    for number in itertools.count(1):
        name = str(prefix) if number == 1 else f"{prefix}-{number}"
        if not any(file.exists() for suffix in suffixes for file in map_paths(name + suffix)):
            return name
    raise AssertionError("unreachable")


def map_paths(prefix: Path | str) -> list[Path]:
    """Return the files that a map of this name may consist of."""
    return [Path(f"{prefix}{ending}") for ending in (".yaml", ".pgm", ".png")]


def load_map(path: Path | str) -> OccupancyMap:
    """Read a map_server YAML file and its image.

    Raises:
        FileNotFoundError: If one of the two is not there.
        ValueError: If a key is missing or no finite number, or one of the two cannot be read.
    """
    path = Path(path)
    try:
        header = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError):
        raise ValueError(f"{path} is not a map file, {A_MAP_FILE}: it is not YAML") from None
    if not isinstance(header, dict):
        raise ValueError(f"{path} is not a map file, {A_MAP_FILE}: it holds no keys with values")
    missing = [k for k in ("image", "resolution", "origin") if k not in header]
    if missing:
        raise ValueError(f"{path} lacks {', '.join(missing)}")
    image_path = path.parent / str(header["image"])
    if not image_path.exists():
        raise FileNotFoundError(f"{image_path}, the image of {path.name}, is not there")
    image = cv2.imread(str(image_path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ValueError(f"{image_path} cannot be read as an image")
    x, y, yaw = _numbers(path, "origin", header["origin"], 3)
    (resolution,) = _numbers(path, "resolution", [header["resolution"]], 1)
    for name in ("occupied_thresh", "free_thresh"):
        _numbers(path, name, [header.get(name, 0.5)], 1)
    return OccupancyMap(_from_image(image[::-1], header), resolution, SE2(x, y, yaw))


def _numbers(path: Path, name: str, value: Any, num: int) -> list[float]:
    """Return the numbers of a key.

    Raises:
        ValueError: If they are not so many finite numbers.
    """
    try:
        numbers = [float(v) for v in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != num or not np.isfinite(numbers).all():
        wanted, got = ("a number", value[0]) if num == 1 else (f"{num} numbers", value)
        raise ValueError(f"{path}: {name} must be {wanted}, got {got!r}")
    return numbers


def _to_image(cells: np.ndarray, mode: str) -> np.ndarray:
    """Return the image of a map, rows in the map's order."""
    unknown = (cells < 0) | (cells > OCCUPIED)
    if mode == "raw":
        return np.where(unknown, np.uint8(255), cells.astype(np.uint8))
    if mode == "scale":
        grey = (255 - np.rint(2.55 * np.clip(cells, 0, 100))).astype(np.uint8)
        return np.dstack([grey] * 3 + [np.where(unknown, 0, 255).astype(np.uint8)])
    image = np.full(cells.shape, PIXEL_UNKNOWN, np.uint8)
    image[~unknown & (cells < 100 * FREE_THRESH)] = PIXEL_FREE
    image[~unknown & (cells > 100 * OCCUPIED_THRESH)] = PIXEL_OCCUPIED
    return image


def _from_image(image: np.ndarray, header: dict[str, Any]) -> np.ndarray:
    """Return the cells of an image as nav2_map_server reads them."""
    mode = str(header.get("mode", "trinary"))
    if mode not in MODES:
        raise ValueError(f"mode must be one of {', '.join(MODES)}, got {mode!r}")
    is_clear = np.zeros(image.shape[:2], bool)
    if image.ndim == 3:
        if image.shape[2] in (2, 4):
            is_clear = image[..., -1] < 255
        image = image[..., :3].mean(axis=2) if image.shape[2] >= 3 else image[..., 0]
    if mode == "raw":
        return np.where(image > OCCUPIED, UNKNOWN, image).astype(np.int8)
    p_occ = image / 255.0 if header.get("negate", 0) else (255.0 - image) / 255.0
    occupied = float(header.get("occupied_thresh", OCCUPIED_THRESH))
    free = float(header.get("free_thresh", FREE_THRESH))
    between = np.full(p_occ.shape, UNKNOWN, np.int8)
    if mode == "scale":
        share = np.clip((p_occ - free) / max(occupied - free, 1e-9), 0.0, 1.0)
        between = np.rint(100.0 * share).astype(np.int8)
    cells = np.where(p_occ > occupied, OCCUPIED, np.where(p_occ < free, FREE, between))
    return np.where(is_clear, UNKNOWN, cells).astype(np.int8)


def _write_both(image_path: Path, image: bytes, yaml_path: Path, text: bytes) -> None:
    """Write both files beside their final names, then move them; the YAML comes last.

    An image that was not there before does not stay without its YAML.
    """
    had_image = image_path.exists()
    parts = [(image_path, image), (yaml_path, text)]
    temps = [path.with_name(f".{path.name}.{os.getpid()}.part") for path, _ in parts]
    try:
        for temp, (_, data) in zip(temps, parts, strict=True):
            with temp.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
        for temp, (path, _) in zip(temps, parts, strict=True):
            temp.replace(path)
    except BaseException:
        if not had_image:
            image_path.unlink(missing_ok=True)
        raise
    finally:
        for temp in temps:
            temp.unlink(missing_ok=True)
