"""Settings drawn at random: each set is refused by an error that names one, or it stands."""

from __future__ import annotations

import math
import typing
from dataclasses import Field
from typing import Any

import numpy as np

from _docs_parameters import NODES
from floornav_common.config_files import (
    config_from_mapping,
    parameter_fields,
    refuse_unknown,
)

_MOST = 4
_ODD: tuple[Any, ...] = (
    math.nan, math.inf, -math.inf, -1, 0, 1, -1.0, 0.0, 1e-300, 1e300, -1e300, 2**31, 2**62, 10**9,
    "", "x", "../..", "\x00", "1.0", True, False, (), (1,), (1.0, 2.0), ("",), ("x", "x"),
    [math.nan], "omni", "icp", "/", "é" * 40,
)  # fmt: skip


def draw_set(rng: np.random.Generator, node: str) -> dict[str, Any]:
    """Return some parameters of a node, drawn at random; one in twenty is a name of no one's."""
    fields = _fields(node)
    names = rng.choice(sorted(fields), size=min(len(fields), 1 + int(rng.integers(_MOST))))
    drawn = {str(name): _draw(rng, *fields[str(name)]) for name in names}
    if rng.random() < 0.05:
        drawn["no_such_parameter"] = 1
    return drawn


def try_set(node: str, values: dict[str, Any]) -> tuple[bool, str]:
    """Build a node's settings from parameters, as the node does.

    Returns:
        Whether they were taken, and what is wrong with how they were refused ("" for nothing).
    """
    try:
        refuse_unknown(values, _fields(node), node)
        for config_class in NODES[node]:
            own = {k: v for k, v in values.items() if k in parameter_fields(config_class)}
            config_from_mapping(config_class, own)
    except ValueError as error:
        text = str(error)
        # A value may only be wrong beside another: then that one is named.
        is_named = any(name.rpartition(".")[2] in text for name in (*values, *_fields(node)))
        is_one_line = "\n" not in text
        return False, "" if is_named and is_one_line else f"{values}: {text!r}"
    except Exception as error:
        return False, f"{values}: {type(error).__name__}: {error}"
    return True, ""


def as_words(values: dict[str, Any]) -> list[str]:
    """Return parameters as a command line gives them, those left out that none can hold."""
    words = []
    for name, value in values.items():
        text = _as_yaml(value)
        if text is not None:
            words += ["-p", f"{name}:={text}"]
    return words


def _fields(node: str) -> dict[str, tuple[Field[Any], Any]]:
    found: dict[str, tuple[Field[Any], Any]] = {}
    for config_class in NODES[node]:
        found |= parameter_fields(config_class)
    return found


def _draw(rng: np.random.Generator, field: Field[Any], hint: Any) -> Any:
    """Return a value for a setting: half of them odd ones, half of its own kind."""
    if rng.random() < 0.5:
        return _ODD[int(rng.integers(len(_ODD)))]
    return _of_kind(rng, field, hint)


def _of_kind(rng: np.random.Generator, field: Field[Any], hint: Any) -> Any:
    if typing.get_origin(hint) is tuple:
        kinds = typing.get_args(hint)
        num = int(rng.integers(5)) if kinds[-1] is Ellipsis else len(kinds)
        return tuple(_of_kind(rng, field, kinds[0]) for _ in range(num))
    if hint is bool:
        return bool(rng.integers(2))
    if hint is str:
        choices = field.metadata.get("choices") or ("a", "b c", "")
        return str(choices[int(rng.integers(len(choices)))])
    size = 10.0 ** rng.uniform(-3.0, 3.0) * (1.0 if rng.random() < 0.8 else -1.0)
    return round(size) if hint is int else float(size)


def _as_yaml(value: Any) -> str | None:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else (".inf" if value > 0 else "-.inf")
    if isinstance(value, str):
        return None if "\x00" in value else f"'{value}'"
    if isinstance(value, list | tuple):
        inner = [_as_yaml(each) for each in value]
        return None if None in inner else f"[{', '.join(t for t in inner if t)}]"
    return repr(value)
