"""Reading a YAML mapping into a dataclass, with errors that say where and what is known."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import yaml

T = TypeVar("T")


class WorldError(ValueError):
    """A world or robot file that cannot be used; the text is one line for the user."""


class _StrictLoader(yaml.SafeLoader):
    """A safe loader that refuses a mapping with the same key twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping.

        Raises:
            yaml.YAMLError: A key is there twice.
        """
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.tag != "tag:yaml.org,2002:merge":
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key {key.value!r} is there twice", key.start_mark
                    )
                seen.add(key.value)
        return super().construct_mapping(node, deep)


def load_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file.

    Raises:
        WorldError: If it cannot be read or is not one mapping.
    """
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), _StrictLoader)  # noqa: S506, is safe
    except OSError as error:
        raise WorldError(f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict):
        raise WorldError(f"{path}: expected a mapping, got {type(data).__name__}")
    return data


def filled_in(data: dict[str, Any], given: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return a file's mapping with every `$name` replaced by the parameter of that name.

    Args:
        data: The mapping; its own key `parameters` holds names and default values.
        given: Values that replace the defaults.
        where: Name of the file, for errors.

    Raises:
        WorldError: A name that the file does not have.
    """
    defaults = data.get("parameters", {})
    if not isinstance(defaults, dict):
        raise WorldError(f"{where}: parameters: expected a mapping, got {defaults!r}")
    known = ", ".join(defaults) or "none"
    for name in given:
        if name not in defaults:
            raise WorldError(f"{where}: no parameter named {name!r}; there are: {known}")
    values = {**defaults, **given}
    rest = {key: item for key, item in data.items() if key != "parameters"}
    return {**_filled(rest, values, where), **({"parameters": values} if values else {})}


def _filled(item: Any, values: Mapping[str, Any], where: str) -> Any:
    if isinstance(item, dict):
        return {key: _filled(value, values, where) for key, value in item.items()}
    if isinstance(item, list):
        return [_filled(value, values, where) for value in item]
    if isinstance(item, str) and item.startswith("$"):
        if item[1:] not in values:
            known = ", ".join(values) or "none"
            raise WorldError(f"{where}: no parameter named {item[1:]!r}; there are: {known}")
        return values[item[1:]]
    return item


def parsed_parameters(texts: Sequence[str]) -> dict[str, Any]:
    """Return `name=value` texts as a mapping; the values are read as YAML.

    Raises:
        WorldError: A text without name or value.
    """
    values = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not name.strip() or not sign or not value.strip():
            raise WorldError(f"a parameter of the world must be name=value, got {text!r}")
        try:
            values[name.strip()] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise WorldError(f"parameter {name}: not YAML: {value!r}") from error
    return values


def build(cls: type[T], data: Any, where: str) -> T:
    """Return `cls` filled from a mapping; nested dataclasses and tuples of them too.

    Args:
        cls: A dataclass; a field without default is required.
        data: What the file holds there.
        where: Name of the place for errors, such as `room.yaml: walls[3]`.

    Raises:
        WorldError: Unknown or missing key, wrong type, not finite, or refused by `cls`.
    """
    if not isinstance(data, dict):
        raise WorldError(f"{where}: expected a mapping, got {data!r}")
    known = {f.name: f for f in fields(cls) if f.init}  # type: ignore[arg-type]
    for key in data:
        if key not in known:
            raise WorldError(f"{where}: unknown key {key!r}; known: {', '.join(known)}")
    for name, f in known.items():
        if name not in data and f.default is MISSING and f.default_factory is MISSING:
            raise WorldError(f"{where}: key {name!r} is missing")
    hints = get_type_hints(cls)
    values = {key: _value(hints[key], item, f"{where}: {key}") for key, item in data.items()}
    # Some say themselves what they take, such as the color of a lamp.
    if "color" in values and "le" not in known["color"].metadata:
        _require_color(values["color"], where)
    try:
        return cls(**values)
    except WorldError:
        raise
    except ValueError as error:
        raise WorldError(f"{where}: {error}") from error


def _require_color(color: tuple[float, ...], where: str) -> None:
    if not all(0.0 <= share <= 1.0 for share in color):
        raise WorldError(f"{where}: color: expected red, green, blue from 0 to 1, got {color}")


def _value(hint: Any, data: Any, where: str) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        inner = [arm for arm in get_args(hint) if arm is not type(None)]
        return None if data is None else _value(inner[0], data, where)
    if is_dataclass(hint):
        return build(hint, data, where)  # type: ignore[arg-type]
    if get_origin(hint) is tuple:
        return _tuple(get_args(hint), data, where)
    if hint is float:
        return _number(data, where)
    if hint is dict or get_origin(hint) is dict:
        if not isinstance(data, dict):
            raise WorldError(f"{where}: expected a mapping, got {data!r}")
        return data
    if not isinstance(data, hint) or (hint is int and isinstance(data, bool)):
        raise WorldError(f"{where}: expected {hint.__name__}, got {data!r}")
    return data


def _tuple(arms: tuple[Any, ...], data: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(data, list):
        raise WorldError(f"{where}: expected a list, got {data!r}")
    if len(arms) == 2 and arms[1] is Ellipsis:
        arms = (arms[0],) * len(data)
    if len(arms) != len(data):
        raise WorldError(f"{where}: expected {len(arms)} values, got {len(data)}")
    return tuple(
        _value(arm, item, f"{where}[{k}]")
        for k, (arm, item) in enumerate(zip(arms, data, strict=True))
    )


def _number(data: Any, where: str) -> float:
    if isinstance(data, bool) or not isinstance(data, int | float) or not math.isfinite(data):
        raise WorldError(f"{where}: expected a finite number, got {data!r}")
    return float(data)
