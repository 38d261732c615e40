"""One YAML file for every kind of camera: what the parameter `camera_model` names.

    kind: equidistant
    width_px: 1280
    ...                       # the kind's own keys: docs/camera-models.md
    mount:
      height_m: 0.8           # of the viewpoint over the floor
      roll_rad: 0.0
      pitch_rad: 0.0
      yaw_rad: 0.0
      position_m: [0.0, 0.0]  # over base_link
    calibration:              # how well the keys above are known
      names: [fx_px, fy_px, height_m]
      cov: [[...], [...], [...]]

`mount` may be left out, whole or in part; the height only where the kind has one of its own.
Without `calibration` the camera is taken to be known exactly.
"""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from pathlib import Path
from typing import Any

import yaml

from floornav_common.calibration import Calibration
from floornav_common.cameras import equidistant, hyperboloidal_mirror, radius_table, unified
from floornav_common.cameras.central import CentralCamera
from floornav_common.config import param, validate
from floornav_common.config_files import coerce, refuse_unknown
from floornav_common.floor_camera import FloorCamera
from floornav_common.package_files import find_file
from floornav_common.reporting import write_atomic

KINDS: dict[str, type] = {
    hyperboloidal_mirror.KIND: hyperboloidal_mirror.MirrorCamera,
    unified.KIND: unified.UnifiedCamera,
    equidistant.KIND: equidistant.EquidistantCamera,
    radius_table.KIND: radius_table.RadiusTableCamera,
}
"""The class of each kind."""


class _FlatLists(yaml.SafeDumper):
    """Writes lists in one line."""


_FlatLists.add_representer(
    list,
    lambda dumper, data: dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=True),
)


@dataclass(frozen=True, kw_only=True)
class Mount:
    """How a camera stands on its robot: the group `mount` of a camera file."""

    height_m: float = param(0.0, "Height of the viewpoint; 0: the kind's own.", unit="m", ge=0.0)
    roll_rad: float = param(0.0, "Turn about x, first.", unit="rad")
    pitch_rad: float = param(0.0, "Turn about y, second; positive looks down.", unit="rad")
    yaw_rad: float = param(0.0, "Turn about z, last.", unit="rad")
    position_m: tuple[float, float] = param((0.0, 0.0), "Viewpoint over base_link.", unit="m")

    def __post_init__(self) -> None:
        validate(self)


def load_camera(path: str | Path) -> CentralCamera:
    """Read a camera's model, without its mount; errors as of `load_floor_camera`."""
    return _read(Path(path))[0]


def load_floor_camera(path: str | Path) -> FloorCamera:
    """Read a camera and its mount.

    Raises:
        ValueError: Not a mapping of a known kind, unknown or missing keys, values of a wrong type
            or out of range, or no height.
        OSError: The file cannot be read.
    """
    camera, mount, calibration = _read(Path(path))
    values = asdict(mount)
    if mount.height_m == 0.0:
        own = getattr(camera, "viewpoint_height", None)
        if own is None:
            raise ValueError(f"{path}: mount.height_m is missing: this kind has no height itself")
        values["height_m"] = own
    try:
        return FloorCamera(camera, **values, calibration=calibration)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def load_camera_model(name_or_path: str) -> FloorCamera:
    """Return the camera that the parameter `camera_model` names: a path, or one brought along.

    Raises:
        ValueError: There is none, or the file does not hold to the schema.
        OSError: The file cannot be read.
    """
    return load_floor_camera(find_file(name_or_path, "floornav_common", "camera_models"))


def save_floor_camera(floor_camera: FloorCamera, path: str | Path, comment: str = "") -> None:
    """Write a camera and its mount; `comment` stands above, each line behind a `#`."""
    mount = {f.name: getattr(floor_camera, f.name) for f in fields(Mount)}
    content = {**camera_values(floor_camera.camera), "mount": _plain(mount)}
    known = floor_camera.calibration
    if known is not None:
        cov = [list(row) for row in known.cov]
        content["calibration"] = {"names": list(known.names), "cov": cov}
    _write(content, path, comment)


def save_camera(camera: CentralCamera, path: str | Path, comment: str = "") -> None:
    """Write a camera's model without a mount."""
    _write(camera_values(camera), path, comment)


def camera_values(camera: CentralCamera) -> dict[str, Any]:
    """Return a camera's `kind` and keys as its file holds them."""
    kind = next(name for name, known in KINDS.items() if isinstance(camera, known))
    return {"kind": kind, **_plain(asdict(camera))}  # type: ignore[call-overload]


def _write(content: dict[str, Any], path: str | Path, comment: str) -> None:
    text = "".join(f"# {line}".rstrip() + "\n" for line in comment.splitlines())
    text += yaml.dump(content, Dumper=_FlatLists, sort_keys=False, width=100)
    write_atomic(Path(path), text)


def _read(path: Path) -> tuple[CentralCamera, Mount, Calibration | None]:
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    kind = data.pop("kind", None) if isinstance(data, dict) else None
    if not isinstance(kind, str) or kind not in KINDS:
        raise ValueError(f"{path}: expected a mapping with kind: {' or '.join(KINDS)}")
    mount = data.pop("mount", None)
    if mount is not None and not isinstance(mount, dict):
        raise ValueError(f"{path}: mount must be a mapping, got {mount!r}")
    known = _calibration(data.pop("calibration", None), path)
    camera = _filled(KINDS[kind], data, str(path))
    return camera, _filled(Mount, mount if mount is not None else {}, f"{path}: mount"), known


def _calibration(data: Any, path: Path) -> Calibration | None:
    if data is None:
        return None
    where = f"{path}: calibration"
    if not isinstance(data, dict) or not all(isinstance(v, list) for v in data.values()):
        raise ValueError(f"{where}: expected a mapping with the lists names and cov")
    refuse_unknown([str(name) for name in data], ["names", "cov"], where)
    try:
        names = tuple(str(name) for name in data["names"])
        return Calibration(names, tuple(tuple(float(v) for v in row) for row in data["cov"]))
    except KeyError as error:
        raise ValueError(f"{where}: missing: {error.args[0]}") from error
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: {error}") from error


def _filled(kind: type, data: Mapping[str, Any], where: str) -> Any:
    """Return a dataclass from the keys of a file, every one checked."""
    names = [str(name) for name in data]
    refuse_unknown(names, [f.name for f in fields(kind)], where)
    missing = [f.name for f in fields(kind) if f.default is MISSING and f.name not in data]
    if missing:
        raise ValueError(f"{where}: missing: {', '.join(missing)}")
    hints = typing.get_type_hints(kind)
    try:
        return kind(**{name: coerce(name, hints[name], value) for name, value in data.items()})
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values as YAML holds them: plain numbers and lists."""
    return {
        name: [float(v) for v in value] if isinstance(value, tuple) else value
        for name, value in values.items()
    }
