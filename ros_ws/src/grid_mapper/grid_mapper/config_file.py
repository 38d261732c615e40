"""The mapper's configuration, groups and all, from the YAML file that the node takes too."""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

from floornav_common.config_files import (
    config_from_mapping,
    parameter_names,
    read_parameters,
    refuse_unknown,
)
from floornav_common.frames import FrameConfig
from grid_mapper.config import GridMapperConfig

C = TypeVar("C")
NODE_NAME = "grid_mapper"


def load_mapper_config(path: str | Path) -> tuple[GridMapperConfig, FrameConfig]:
    """Read the mapper's values and its frames from a ROS parameter file or a plain mapping.

    Raises:
        ValueError: If the file cannot be read or holds a key or a value that is not right.
    """
    values = read_parameters(path, NODE_NAME)
    frame_names = parameter_names(FrameConfig)
    refuse_unknown(values, [*nested_names(GridMapperConfig), *frame_names], str(path))
    frames = {name: values[name] for name in frame_names if name in values}
    return nested_config(GridMapperConfig, values), config_from_mapping(FrameConfig, frames)


def nested_names(config_class: type, prefix: str = "") -> list[str]:
    """Return the names of all values of a configuration, those of its groups with a dot."""
    names: list[str] = []
    for name, hint in _typed_fields(config_class):
        is_group = isinstance(hint, type) and is_dataclass(hint)
        names.extend(nested_names(hint, f"{prefix}{name}.") if is_group else [prefix + name])
    return names


def nested_config(config_class: type[C], values: Mapping[str, Any], prefix: str = "") -> C:
    """Build a configuration from values by dotted name; what is not named keeps its default.

    Raises:
        ValueError: If a value has the wrong type or is out of range.
    """
    own: dict[str, Any] = {}
    for name, hint in _typed_fields(config_class):
        if isinstance(hint, type) and is_dataclass(hint):
            own[name] = nested_config(hint, values, f"{prefix}{name}.")
        elif prefix + name in values:
            own[name] = values[prefix + name]
    return config_from_mapping(config_class, own, prefix.rstrip("."))


def _typed_fields(config_class: type) -> list[tuple[str, Any]]:
    hints = typing.get_type_hints(config_class)
    return [(f.name, hints[f.name]) for f in fields(config_class)]
