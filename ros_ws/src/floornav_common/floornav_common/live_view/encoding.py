"""What goes to a browser: JSON as text, or JSON with points or a picture behind it as bytes.

A binary message is `length of the JSON (uint32) | JSON, filled up with spaces | payload`, all
little-endian, the payload on a multiple of four bytes so that a Float32Array can lie on it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from floornav_common.se2 import SE2

_LENGTH = 4  # bytes of the length, and what payloads are aligned to


def text_message(kind: str, **values: Any) -> str:
    """Return a message without a payload.

    Raises:
        ValueError: If a number is not finite: JSON has no word for it.
    """
    return json.dumps({"kind": kind, **values}, allow_nan=False, separators=(",", ":"))


def binary_message(kind: str, payload: bytes, **values: Any) -> bytes:
    """Return a message with a payload behind its JSON; see the module.

    Raises:
        ValueError: If a number is not finite.
    """
    head = text_message(kind, **values).encode()
    head += b" " * (-len(head) % _LENGTH)
    return len(head).to_bytes(_LENGTH, "little") + head + payload


def split_message(message: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the JSON and the payload of a binary message, as the page reads it."""
    end = _LENGTH + int.from_bytes(message[:_LENGTH], "little")
    return json.loads(message[_LENGTH:end]), message[end:]


def pose_values(pose: SE2) -> dict[str, float]:
    """Return a pose as JSON has it, rounded to what can be seen."""
    return {"x": round(pose.x, 4), "y": round(pose.y, 4), "yaw": round(pose.yaw, 5)}


def points_payload(points: np.ndarray) -> bytes:
    """Return points, shape (N, 2), as float32 x y x y ...; those that are not finite left out."""
    finite = points[np.isfinite(points).all(axis=1)]
    return finite.astype("<f4").tobytes()


def lines_payload(points: np.ndarray) -> bytes:
    """Return ends of lines, shape (2 N, 2), as float32; lines that are not finite left out.

    Raises:
        ValueError: If an end is missing.
    """
    if len(points) % 2:
        raise ValueError(f"lines must have two ends each, got {len(points)} points")
    pairs = points.reshape(-1, 4)
    return pairs[np.isfinite(pairs).all(axis=1)].astype("<f4").tobytes()


def grid_png(cells: np.ndarray) -> bytes:
    """Return a map as a grey PNG: 0 unknown, else 1 + occupancy; the top row is the last one.

    Args:
        cells: Shape (H, W), int8, -1 unknown, 0..100.

    Raises:
        ValueError: If there are no cells.
    """
    if not cells.size:
        raise ValueError(f"map must have cells, got {cells.shape}")
    grey = (np.clip(cells, -1, 100).astype(np.int16) + 1).astype(np.uint8)
    # Level 1: a third of the time of the default for a tenth more bytes.
    return _encoded(".png", grey[::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])


def picture_jpeg(pixels: np.ndarray, width: int, quality: int) -> bytes:
    """Return a picture, BGR or grey, as a JPEG at most `width` pixels wide."""
    if pixels.shape[1] > width:
        height = max(1, round(pixels.shape[0] * width / pixels.shape[1]))
        pixels = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def cone_values(pose: SE2, opening: float, reach: float, is_echo: bool) -> dict[str, Any] | None:
    """Return a sonar's cone as JSON has it; None if it says nothing.

    Args:
        pose: Of the sonar.
        opening: Whole angle, rad.
        reach: Where the echo came from, or how far it is free, m.
        is_echo: Whether there was an echo.
    """
    if not (math.isfinite(opening) and math.isfinite(reach)):
        return None
    return {**pose_values(pose), "opening": round(opening, 4), "reach": round(reach, 3),
            "echo": is_echo}  # fmt: skip


def color_text(rgba: Mapping[str, float] | tuple[float, ...]) -> str:
    """Return red, green, blue and alpha in 0..1 as CSS has it."""
    values = tuple(rgba.values()) if isinstance(rgba, Mapping) else rgba
    red, green, blue, alpha = (min(max(v, 0.0), 1.0) if math.isfinite(v) else 1.0 for v in values)
    return f"rgba({255 * red:.0f},{255 * green:.0f},{255 * blue:.0f},{alpha:.2f})"


def _encoded(kind: str, pixels: np.ndarray, options: list[int]) -> bytes:
    is_done, data = cv2.imencode(kind, pixels, options)
    if not is_done:
        raise ValueError(f"pixels {pixels.shape} {pixels.dtype} cannot be written as {kind}")
    return bytes(data)
