"""Message types by name: their classes and definitions, if this machine has them."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

SEPARATOR = "=" * 80
BUILT_IN = (
    "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16",
    "int32", "uint32", "int64", "uint64", "string", "wstring",
)  # fmt: skip


def message_class(msgtype: str) -> Any | None:
    """Return the class of a type such as `std_msgs/msg/String`; None if it is not installed."""
    package, _, name = msgtype.partition("/msg/")
    try:
        found = getattr(importlib.import_module(f"{package}.msg"), name, None)
        if found is not None:
            found.__class__.__import_type_support__()
    except (ImportError, AttributeError, RuntimeError):
        return None
    return found


def message_definition(msgtype: str) -> str:
    """Return the definition of a type and of all it is made of, as bags hold it; "" if unknown."""
    texts: dict[str, str] = {}
    open_types = [msgtype]
    while open_types:
        current = open_types.pop(0)
        if current in texts:
            continue
        text = _definition_file(current)
        if text is None:
            return ""
        texts[current] = text
        open_types.extend(_parts(text, current.partition("/")[0]))
    first, *others = texts.items()
    rest = [f"{SEPARATOR}\nMSG: {name.replace('/msg/', '/')}\n{text}" for name, text in others]
    return "\n".join([first[1], *rest])


def _definition_file(msgtype: str) -> str | None:
    package, _, name = msgtype.partition("/msg/")
    try:
        path = Path(get_package_share_directory(package)) / "msg" / f"{name}.msg"
        return path.read_text(encoding="utf-8")
    except (PackageNotFoundError, OSError, ValueError):
        return None


def _parts(text: str, package: str) -> list[str]:
    """Return the types that a definition names, in order."""
    found = []
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if len(words) < 2:
            continue
        base = words[0].split("[")[0].split("<")[0]
        if base in BUILT_IN:
            continue
        owner, _, name = base.rpartition("/")
        found.append(f"{owner.removesuffix('/msg') or package}/msg/{name}")
    return found
