"""Numbers on a command line, as types for argparse: no NaN, nothing infinite, one sentence if not.

Each takes the word of the command line, returns its number, and raises
`argparse.ArgumentTypeError`, which argparse prints behind the option's name and ends with 2.
"""

from __future__ import annotations

import argparse
import math


def finite(text: str) -> float:
    """Return a number."""
    return _within(text, -math.inf, math.inf, "a number")


def positive(text: str) -> float:
    """Return a number > 0."""
    value = _within(text, 0.0, math.inf, "a number > 0")
    if value == 0.0:
        raise argparse.ArgumentTypeError(f"must be a number > 0, got {text}")
    return value


def not_negative(text: str) -> float:
    """Return a number >= 0."""
    return _within(text, 0.0, math.inf, "a number >= 0")


def share(text: str) -> float:
    """Return a number in 0..1."""
    return _within(text, 0.0, 1.0, "a number in 0..1")


def whole(text: str) -> int:
    """Return a whole number."""
    return _whole(text, None, "a whole number")


def count(text: str) -> int:
    """Return a whole number >= 1."""
    return _whole(text, 1, "a whole number >= 1")


def natural(text: str) -> int:
    """Return a whole number >= 0."""
    return _whole(text, 0, "a whole number >= 0")


def _within(text: str, low: float, high: float, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and low <= value <= high):
        raise argparse.ArgumentTypeError(f"must be {what}, got {text}")
    return value


def _whole(text: str, low: int | None, what: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = None
    if value is None or (low is not None and value < low):
        raise argparse.ArgumentTypeError(f"must be {what}, got {text}")
    return value
