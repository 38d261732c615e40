"""The mapper's configuration, groups and all, from the YAML file that the node takes too."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from floornav_common.config_files import (
    config_from_mapping,
    parameter_names,
    read_parameters,
    refuse_unknown,
)
from floornav_common.frames import FrameConfig
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig

C = TypeVar("C")
NODE_NAME = "grid_mapper"


def load_mapper_config(path: str | Path) -> tuple[GridMapperConfig, FrameConfig]:
    """Read the mapper's values and its frames from a ROS parameter file or a plain mapping.

    What concerns the running node alone may stand in the file too; it is checked and has no effect.

    Raises:
        ValueError: If the file cannot be read or holds a key or a value that is not right.
    """
    values = read_parameters(path, NODE_NAME)
    classes = (GridMapperConfig, FrameConfig, GridMapperNodeConfig)
    refuse_unknown(values, [name for c in classes for name in parameter_names(c)], str(path))
    _part(GridMapperNodeConfig, values)
    return _part(GridMapperConfig, values), _part(FrameConfig, values)


def _part(config_class: type[C], values: dict[str, Any]) -> C:
    """Fill a configuration from those of the values that are its own."""
    own = {name: values[name] for name in parameter_names(config_class) if name in values}
    return config_from_mapping(config_class, own)
