"""docs/world-files.md: every key of a world file, written from the dataclasses that read it."""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any

from _docs_world_texts import EXAMPLES, HEAD, MEANINGS
from floornav_common.config import range_text
from sim_bridge.appearance import PATTERN_NAMES, Area, Dirt, Floor, Light, Line, Ring
from sim_bridge.glass import Frame, Glass
from sim_bridge.measures import Measure
from sim_bridge.people.config import PeopleConfig
from sim_bridge.people.schema import Crowd, Recording, WalkerPlan
from sim_bridge.places import Goals, Route
from sim_bridge.surfaces import SURFACES
from sim_bridge.world import Ball, Column, Door, Furniture, RobotPlacement, Wall, World

PAGE = "world-files.md"
SECTIONS: dict[str, type] = {
    "Top level": World, "walls": Wall, "doors": Door, "glass": Glass, "frame": Frame,
    "boxes, tables, shelves": Furniture, "columns": Column, "balls": Ball,
    "robots": RobotPlacement, "route": Route, "goals": Goals, "floor": Floor, "areas": Area,
    "lines": Line, "rings": Ring, "dirt": Dirt, "light": Light, "measures": Measure,
    "people": WalkerPlan, "crowd": Crowd, "recorded_people": Recording,
    "people_model": PeopleConfig,
}  # fmt: skip
"""Headings of the page, and what is read there."""

_TABLE_HEAD = "| key | kind | default | range | meaning |\n| --- | --- | --- | --- | --- |\n"
_VECTORS = {2: "[x, y]", 3: "[x, y, z]"}


def world_files_page() -> str:
    """Return the text of docs/world-files.md.

    Raises:
        ValueError: A key has no meaning written down, neither in its class nor here.
    """
    parts = [HEAD]
    for title, cls in SECTIONS.items():
        parts.append(f"## {title}\n\n{_summary(cls)}\n")
        if title in EXAMPLES:
            parts.append(f"```yaml\n{EXAMPLES[title].strip()}\n```\n")
        rows = "".join(f"| {' | '.join(row)} |\n" for row in _rows(title, cls))
        parts.append(_TABLE_HEAD + rows)
    parts.append(_surfaces())
    return "\n".join(parts).rstrip() + "\n"


def examples() -> list[str]:
    """Return the YAML texts on the page, each a part of a world file."""
    return re.findall(r"```yaml\n(.*?)```", world_files_page(), flags=re.DOTALL)


def _rows(title: str, cls: type) -> Iterator[list[str]]:
    hints, documented = typing.get_type_hints(cls), _attributes(cls)
    for f in fields(cls):
        meaning = f.metadata.get("doc") or documented.get(f.name) or MEANINGS.get(title, {}).get(
            f.name, MEANINGS["anywhere"].get(f.name)
        )  # fmt: skip
        if not meaning:
            raise ValueError(f"no meaning is written for {cls.__name__}.{f.name}")
        limits = range_text(f) if f.metadata else ""
        yield [f"`{f.name}`", _kind(f.name, hints[f.name]), _default(f), limits, meaning]


def _kind(name: str, hint: Any) -> str:
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return _kind(name, next(a for a in typing.get_args(hint) if a is not type(None)))
    if is_dataclass(hint):
        return _link(hint)  # type: ignore[arg-type]
    if typing.get_origin(hint) is tuple:
        first, *rest = typing.get_args(hint)
        if rest == [Ellipsis]:
            return f"list of {_kind(name, first)}"
        vector = "[r, g, b]" if name == "color" else _VECTORS[1 + len(rest)]
        return f"`{vector}`"
    words = {float: "number", int: "integer", bool: "true or false", str: "text"}
    return words.get(hint, "mapping")


def _link(cls: type) -> str:
    title = next(title for title, known in SECTIONS.items() if known is cls)
    return f"[{title}](#{title.lower().replace(',', '').replace(' ', '-')})"


def _default(f: Field[Any]) -> str:
    if f.default is MISSING:
        return "*required*" if f.default_factory is MISSING else "none"
    value = f.default
    if value is None or value in ((), ""):
        return "none"
    return "its defaults" if dataclasses.is_dataclass(value) else f"`{_as_yaml(value)}`"


def _as_yaml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(_as_yaml(item) for item in value) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _summary(cls: type) -> str:
    text = (cls.__doc__ or "").partition("Attributes:")[0]
    return "\n".join(line.strip() for line in text.strip().splitlines())


def _attributes(cls: type) -> dict[str, str]:
    """Return what a Google docstring says of each attribute."""
    text = (cls.__doc__ or "").partition("Attributes:")[2]
    found = re.findall(r"^        (\w+): (.*(?:\n {12}.*)*)", text, flags=re.MULTILINE)
    return {name: " ".join(doc.split()) for name, doc in found}


def _surfaces() -> str:
    rows = "".join(
        f"| `{name}` | {s.rough_rad:.2f} rad | {s.reflectance:.2f} |\n"
        for name, s in SURFACES.items()
    )
    return (
        "## surface and texture\n\n`surface` is what a thing is to sonar and laser: how much "
        "farther from its normal than a smooth one it answers sound, and which share of light it "
        "sends back. Without one, what its `texture` or its kind usually is. `texture` is how "
        f"cameras see it: {', '.join(f'`{name}`' for name in PATTERN_NAMES)}.\n\n"
        f"| surface | answers sound farther by | reflectance |\n| --- | --- | --- |\n{rows}"
    )
