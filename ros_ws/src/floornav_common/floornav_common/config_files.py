"""Configuration dataclasses from mappings and YAML files; a key nobody knows is an error.

ROS silently ignores parameters that no node declares, so a typing error changes nothing and says
nothing. Here it is refused by name, with the nearest name that exists.
"""

from __future__ import annotations

import difflib
import functools
import typing
from collections.abc import Iterable, Mapping
from dataclasses import Field, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml

from floornav_common.config import range_text

C = TypeVar("C")
ROS_OWN = ("use_sim_time", "start_type_description_service", "automatically_declare_parameters")
ROS_OWN_GROUPS = ("qos_overrides.",)


def load_config(
    path: str | Path,
    config_class: type[C],
    *,
    prefix: str = "",
    node: str = "",
    others: Iterable[type] = (),
) -> C:
    """Read a configuration from a YAML file: a ROS parameter file or a plain mapping.

    Args:
        path: The file.
        config_class: Frozen dataclass to fill; what the file leaves out keeps its default.
        prefix: Group the fields are in, without the dot; "" for the top level.
        node: Node whose block counts, if the file has blocks of several.
        others: Further configuration classes whose keys may stand in the same file.

    Raises:
        ValueError: If the file cannot be read or holds a key or a value that is not right.
    """
    values = read_parameters(path, node)
    known = parameter_names(config_class, prefix)
    refuse_unknown(values, [*known, *(n for c in others for n in parameter_names(c))], str(path))
    own = {field: values[name] for name, field in known.items() if name in values}
    return config_from_mapping(config_class, own, prefix)


def config_from_mapping(config_class: type[C], values: Mapping[str, Any], prefix: str = "") -> C:
    """Build a configuration from field values as YAML and ROS give them (lists, ints for floats).

    Args:
        config_class: Frozen dataclass; a field that is itself a configuration is a group.
        values: By field name; a value of a group by `group.field`.
        prefix: Group that the whole stands in, for the error's text.

    Raises:
        ValueError: If a value has the wrong type or is out of range; names it and its range.
    """
    hints = typing.get_type_hints(config_class)
    where = f"{prefix}." if prefix else ""
    arguments: dict[str, Any] = {}
    for f in fields(config_class):  # type: ignore[arg-type]
        if is_dataclass(hints[f.name]):
            own = [name for name in values if name.startswith(f"{f.name}.")]
            inner = {name.partition(".")[2]: values[name] for name in own}
            arguments[f.name] = config_from_mapping(hints[f.name], inner, where + f.name)
        elif f.name in values:
            arguments[f.name] = coerce(where + f.name, hints[f.name], values[f.name])
    try:
        return config_class(**arguments)
    except ValueError as error:
        raise ValueError(f"{where}{error}") from error


def parameter_fields(config_class: type, prefix: str = "") -> dict[str, tuple[Field[Any], Any]]:
    """Return the declaration and the type of each value by its name, those of groups included."""
    hints = typing.get_type_hints(config_class)
    where = f"{prefix}." if prefix else ""
    found: dict[str, tuple[Field[Any], Any]] = {}
    for f in fields(config_class):
        if is_dataclass(hints[f.name]):
            found |= parameter_fields(hints[f.name], where + f.name)
        else:
            found[where + f.name] = (f, hints[f.name])
    return found


def parameter_names(config_class: type, prefix: str = "") -> dict[str, str]:
    """Return the parameter name of each value, and its name within the configuration."""
    where = f"{prefix}." if prefix else ""
    return {where + name: name for name in parameter_fields(config_class)}


def flat_values(config: Any) -> dict[str, Any]:
    """Return the values of a configuration by name; those of a group by `group.field`."""
    names = parameter_fields(type(config))
    return {name: functools.reduce(getattr, name.split("."), config) for name in names}


def coerce(name: str, hint: Any, value: Any) -> Any:
    """Return a value as the type a field has; an int does for a float, a list for a tuple.

    Raises:
        ValueError: If it does not fit; names the parameter.
    """
    if typing.get_origin(hint) is tuple:
        return _coerce_tuple(name, typing.get_args(hint), value)
    is_bool = isinstance(value, bool)
    if hint is float and isinstance(value, int | float) and not is_bool:
        return float(value)
    if is_bool == (hint is bool) and isinstance(value, hint):
        return value
    names = {float: "a number", int: "an integer", bool: "true or false", str: "text"}
    raise ValueError(f"{name} must be {names.get(hint, str(hint))}, got {value!r}")


def describe(field: Any) -> str:
    """Return the text of a parameter: what it is, its unit and its range."""
    m = field.metadata
    details = [f"unit: {m['unit']}" if m.get("unit") else "", range_text(field)]
    extra = "; ".join(text for text in details if text)
    return str(m.get("doc", "")) + (f" ({extra})" if extra else "")


def refuse_unknown(names: Iterable[str], known: Iterable[str], where: str) -> None:
    """Raise for names that nobody knows, with the nearest known one.

    Raises:
        ValueError: If a name is neither known nor one of ROS's own.
    """
    known = list(known)
    unknown = [n for n in names if n not in known and not _is_ros_own(n)]
    if not unknown:
        return
    texts = []
    for name in sorted(unknown):
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
        texts.append(f"'{name}'" + (f" (did you mean '{near[0]}'?)" if near else ""))
    raise ValueError(f"{where}: unknown parameter {', '.join(texts)}")


def read_parameters(path: str | Path, node: str = "") -> dict[str, Any]:
    """Return the parameters in a YAML file, groups joined by dots.

    Raises:
        ValueError: If it cannot be read, is no mapping, or has blocks of several nodes.
    """
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        text = " ".join(str(error).split())
        raise ValueError(f"{path}: cannot be read: {text}") from error
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise ValueError(f"{path}: must hold a mapping, got {type(content).__name__}")
    blocks = dict(_blocks(content, ""))
    if not blocks:
        return dict(_flat(content, ""))
    wild = [n for n in blocks if n.endswith("*")]
    named = [n for n in blocks if n not in wild and (not node or n.split("/")[-1] == node)]
    if len(named) > 1:
        raise ValueError(f"{path}: has parameters of several nodes: {', '.join(sorted(named))}")
    return {k: v for n in [*wild, *named] for k, v in _flat(blocks[n], "")}


def _coerce_tuple(name: str, kinds: tuple[Any, ...], value: Any) -> tuple[Any, ...]:
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        raise ValueError(f"{name} must be a list, got {value!r}")
    values = list(value)
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(values)
    if len(kinds) != len(values):
        raise ValueError(f"{name} must have {len(kinds)} values, got {len(values)}")
    return tuple(coerce(name, kind, v) for kind, v in zip(kinds, values, strict=True))


def _is_ros_own(name: str) -> bool:
    return name in ROS_OWN or name.startswith(ROS_OWN_GROUPS)


def _blocks(content: Mapping[Any, Any], above: str) -> Iterable[tuple[str, Mapping[Any, Any]]]:
    for key, value in content.items():
        name = f"{above}/{key}".replace("//", "/") if above else str(key)
        if isinstance(value, Mapping) and "ros__parameters" in value:
            yield name, value["ros__parameters"] or {}
        elif isinstance(value, Mapping):
            yield from _blocks(value, name)


def _flat(content: Mapping[Any, Any], above: str) -> Iterable[tuple[str, Any]]:
    for key, value in content.items():
        name = f"{above}.{key}" if above else str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, name)
        else:
            yield name, value
