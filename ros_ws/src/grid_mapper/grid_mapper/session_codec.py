"""Values and the state of objects as bytes and back, without running anything that a file says.

A tree of plain values is JSON; arrays stand behind it in one block, by type, shape and place.
Dataclasses are named by their class; only those that the reader knows are made. Of other objects
the attributes are taken, and put into an object that is already there and has just these; one with
`as_state` and `take_state` says itself what it is made of. An object met again is written once.
"""

from __future__ import annotations

import json
from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_LENGTH_BYTES = 8


def packed(value: Any, left_out: frozenset[str] = frozenset()) -> bytes:
    """Return a value as bytes.

    Args:
        value: Plain values, arrays, dataclasses, and objects of these.
        left_out: Attributes of objects that are not taken.
    """
    arrays: list[bytes] = []
    tree = _Packer(arrays, left_out).tree(value)
    head = json.dumps(tree, separators=(",", ":")).encode()
    return len(head).to_bytes(_LENGTH_BYTES, "little") + head + b"".join(arrays)


def unpacked(
    data: bytes, kinds: Mapping[str, type], into: object | None = None,
    left_out: frozenset[str] = frozenset(),
) -> Any:  # fmt: skip
    """Return what was packed.

    Args:
        data: The bytes.
        kinds: Dataclasses that may be in it, by name.
        into: Object whose attributes are set, where an object was packed.
        left_out: Attributes of objects that were not taken, and stay as they are.

    Raises:
        ValueError: The bytes are not of this form, or of an object with other attributes.
    """
    try:
        end = _LENGTH_BYTES + int.from_bytes(data[:_LENGTH_BYTES], "little")
        tree = json.loads(data[_LENGTH_BYTES:end])
        return _Unpacker(memoryview(data)[end:], kinds, left_out).value(tree, into)
    except (KeyError, IndexError, TypeError, AttributeError, UnicodeDecodeError) as error:
        raise ValueError(f"not readable ({type(error).__name__}: {error})") from error


def kept(value: object, left_out: frozenset[str]) -> list[str]:
    """Return the attributes of an object that are saved."""
    return [name for name in vars(value) if name not in left_out]


class _Packer:
    """Builds the tree and gathers the arrays."""

    def __init__(self, arrays: list[bytes], left_out: frozenset[str]) -> None:
        self._arrays, self._left_out, self._size = arrays, left_out, 0
        self._met: set[int] = set()

    def tree(self, value: Any) -> Any:
        """Return a value as JSON has it; what JSON does not have is a mapping of one kind."""
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, np.generic):
            return value.item()
        if isinstance(value, np.ndarray):
            return {"array": self._place(value)}
        for kind, name in ((list, "list"), (tuple, "tuple"), (deque, "deque")):
            if isinstance(value, kind):
                return {name: [self.tree(item) for item in value]}
        if isinstance(value, Counter | dict):
            name = "counter" if isinstance(value, Counter) else "dict"
            return {name: [[self.tree(k), self.tree(v)] for k, v in value.items()]}
        if is_dataclass(value):
            parts = [self.tree(getattr(value, f.name)) for f in fields(value)]
            return {"data": [type(value).__name__, *parts]}
        return {"object": [type(value).__name__, self._object(value)]}

    def _object(self, value: Any) -> Any:
        """Return what an object is made of; None if it was met before."""
        if id(value) in self._met:
            return None
        self._met.add(id(value))
        if hasattr(value, "as_state"):
            return self.tree(value.as_state())
        return {"dict": [[k, self.tree(vars(value)[k])] for k in kept(value, self._left_out)]}

    def _place(self, array: np.ndarray) -> list[Any]:
        if array.dtype.hasobject:
            raise TypeError(f"an array of {array.dtype} cannot be saved")
        data = np.ascontiguousarray(array).tobytes()
        self._arrays.append(data)
        self._size += len(data)
        return [array.dtype.str, list(array.shape), self._size - len(data)]


class _Unpacker:
    """Makes values of the tree."""

    def __init__(
        self, block: memoryview, kinds: Mapping[str, type], left_out: frozenset[str]
    ) -> None:
        self._block, self._kinds, self._left_out = block, kinds, left_out

    def value(self, tree: Any, into: object | None = None) -> Any:
        """Return the value of a part of the tree."""
        if not isinstance(tree, dict):
            return tree
        ((kind, content),) = tree.items()
        if kind == "object":
            return self._fill(content, into)
        if kind == "array":
            dtype, shape, start = content
            num = int(np.prod(shape))
            array = np.frombuffer(self._block, np.dtype(dtype), num, start)
            return array.reshape(shape).copy()
        if kind == "data":
            return self._kinds[content[0]](*(self.value(part) for part in content[1:]))
        if kind in ("counter", "dict"):
            items = {self.value(k): self.value(v) for k, v in content}
            return Counter(items) if kind == "counter" else items
        sequence = {"list": list, "tuple": tuple, "deque": deque}[kind]
        return sequence(self.value(item) for item in content)

    def _fill(self, content: list[Any], into: object | None) -> object:
        """Set the attributes of an object; objects among them are filled in their turn."""
        name, parts = content
        if type(into).__name__ != name:
            raise KeyError(f"expected {type(into).__name__}, found {name}")
        if parts is None:
            return into
        if hasattr(into, "take_state"):
            into.take_state(self.value(parts))
            return into
        found, expected = {k for k, _ in parts["dict"]}, set(kept(into, self._left_out))
        if found != expected:
            missing, unknown = sorted(expected - found), sorted(found - expected)
            raise KeyError(f"{name}: missing {missing}, unknown {unknown}")
        for attribute, part in parts["dict"]:
            setattr(into, attribute, self.value(part, vars(into)[attribute]))
        return into
