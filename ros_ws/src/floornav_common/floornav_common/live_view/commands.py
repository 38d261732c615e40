"""What a browser may ask for: a goal."""

from __future__ import annotations

import json
import math

from floornav_common.se2 import SE2

_FARTHEST_M = 1e5


def goal_of(text: str | bytes) -> SE2:
    """Return the goal that a browser sent, in the map frame.

    Args:
        text: `{"kind": "goal", "x": 1.0, "y": 2.0, "yaw": 0.0}`.

    Raises:
        ValueError: If it is anything else.
    """
    if isinstance(text, bytes):
        raise ValueError("a message must be text, got bytes")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"a message must be JSON: {error}") from None
    if not isinstance(message, dict) or message.get("kind") != "goal":
        raise ValueError(f'a message must be {{"kind": "goal", ...}}, got {text[:60]}')
    x, y, yaw = (_number(message, key) for key in ("x", "y", "yaw"))
    if max(abs(x), abs(y)) > _FARTHEST_M:
        raise ValueError(f"a goal must be within {_FARTHEST_M:g} m, got ({x:g}, {y:g})")
    return SE2(x, y, yaw)


def _number(message: dict[str, object], key: str) -> float:
    value = message.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"goal's {key} must be a number, got {value!r}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"goal's {key} must be finite, got {value!r:.20}")
    return number
