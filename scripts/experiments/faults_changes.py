"""What a relay does to messages on their way: each change takes one, and gives what is sent on.

A change is called with a message and the simulator's time, and returns pairs of a delay (ns) and a
message. It may change the message that it is given: nobody else has it.
"""

from __future__ import annotations

import copy
import math
from array import array
from collections.abc import Callable
from typing import Any

import numpy as np

from floornav_common.ros.messages import ns_to_stamp, stamp_to_ns

Change = Callable[[Any, int], list[tuple[int, Any]]]


def drop(_msg: Any, _now_ns: int) -> list[tuple[int, Any]]:
    """Send nothing on."""
    return []


class Freeze:
    """Sends the first message again and again.

    Args:
        keeps_stamp: False for the stamps of those that it replaces.
    """

    def __init__(self, *, keeps_stamp: bool) -> None:
        self._keeps_stamp = keeps_stamp
        self._first: Any = None

    def __call__(self, msg: Any, _now_ns: int) -> list[tuple[int, Any]]:
        """Replace a message."""
        if self._first is None:
            self._first = msg
        frozen = copy.deepcopy(self._first)
        if not self._keeps_stamp:
            frozen.header.stamp = msg.header.stamp
        return [(0, frozen)]


class Lossy:
    """Loses a share of the messages and delays the others.

    Args:
        share: That is lost.
        delay_ns: Of the others.
        rng: Draws which.
    """

    def __init__(self, share: float, delay_ns: int, rng: np.random.Generator) -> None:
        self._share, self._delay_ns, self._rng = share, delay_ns, rng

    def __call__(self, msg: Any, _now_ns: int) -> list[tuple[int, Any]]:
        """Pass a message on, or lose it."""
        return [] if self._rng.random() < self._share else [(self._delay_ns, msg)]


class Often:
    """Sends each message many times, their stamps spread over the time before it.

    Args:
        num: How many times.
        period_ns: Between two messages of the sensor.
    """

    def __init__(self, num: int, period_ns: int) -> None:
        self._num, self._step_ns = num, period_ns // num

    def __call__(self, msg: Any, _now_ns: int) -> list[tuple[int, Any]]:
        """Return the message many times, the oldest stamp first."""
        copies = [copy.deepcopy(msg) for _ in range(self._num - 1)] + [msg]
        for k, each in enumerate(copies):
            shift_stamps(each, -(self._num - 1 - k) * self._step_ns)
        return [(0, each) for each in copies]


def edited(edit: Callable[[Any], None]) -> Change:
    """Return the change that edits every message."""

    def change(msg: Any, _now_ns: int) -> list[tuple[int, Any]]:
        edit(msg)
        return [(0, msg)]

    return change


def shift_stamps(msg: Any, shift_ns: int) -> None:
    """Move every stamp in a message; none goes below 0."""
    for owner, name in _stamps(msg):
        moved = max(0, stamp_to_ns(getattr(owner, name)) + shift_ns)
        setattr(owner, name, ns_to_stamp(moved))


def _stamps(msg: Any) -> list[tuple[Any, str]]:
    if hasattr(msg, "transforms"):
        return [(each.header, "stamp") for each in msg.transforms]
    return [(msg.header, "stamp")] if hasattr(msg, "header") else [(msg, "clock")]


def no_numbers(msg: Any) -> None:
    """Set every float of a message to NaN, those of its parts too."""
    for name, kind in msg.get_fields_and_field_types().items():
        value = getattr(msg, name)
        if kind in ("float", "double"):
            setattr(msg, name, math.nan)
        elif hasattr(value, "get_fields_and_field_types"):
            no_numbers(value)
        elif "float" in kind or "double" in kind:
            _fill_with_nan(msg, name, value)
        elif isinstance(value, list):
            for each in value:
                if hasattr(each, "get_fields_and_field_types"):
                    no_numbers(each)


def _fill_with_nan(msg: Any, name: str, value: Any) -> None:
    if isinstance(value, np.ndarray):
        value[:] = math.nan
    else:
        setattr(msg, name, array(getattr(value, "typecode", "d"), [math.nan] * len(value)))


def no_ranges(msg: Any) -> None:
    """Set the ranges of a scan to NaN: nothing was seen."""
    msg.ranges = array("f", [math.nan] * len(msg.ranges))


def pixels_changed(change: Callable[[np.ndarray], np.ndarray]) -> Change:
    """Return the change that does something to the pixels of an image, (H, W, C) uint8."""

    def edit(msg: Any) -> None:
        pixels = np.frombuffer(msg.data, np.uint8).reshape(msg.height, msg.width, -1)
        found = np.ascontiguousarray(change(pixels))
        msg.height, msg.width = found.shape[:2]
        msg.step = found.shape[1] * found.shape[2]
        msg.data = array("B", found.tobytes())

    return edited(edit)


black = pixels_changed(np.zeros_like)
saturated = pixels_changed(lambda pixels: np.full_like(pixels, 255))
upside_down = pixels_changed(lambda pixels: pixels[::-1, ::-1])
half_size = pixels_changed(lambda pixels: pixels[::2, ::2])
