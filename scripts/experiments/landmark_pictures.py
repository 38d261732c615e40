"""The field from above, with errors of poses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from multi_localizer.landmarks import load_landmarks

_PX_PER_M = 100.0
_HALF_M = np.array([4.9, 2.7])
_LONGER = 20.0
_LEGEND_PX, _LEGEND_M = 36, 0.05
_BLACK = (0, 0, 0)
_GREEN, _WHITE, _RED = (58, 110, 44), (240, 240, 240), (40, 40, 220)
_GOALS = {"goal_yellow_left": (30, 200, 240), "goal_blue_left": (215, 90, 40)}


def draw_errors(
    path: Path, errors: Sequence[np.ndarray], places: Sequence[tuple[float, float]], num: int
) -> Path:
    """Draw the errors, `num` at each place in order as far as there are, and return the path."""
    width, height = (2.0 * _HALF_M * _PX_PER_M).astype(int)
    picture = np.full((height, width, 3), _GREEN, dtype=np.uint8)
    corners = [_pixel(np.array(p)) for p in ((-4.11, -2.2875), (4.11, 2.2875))]
    cv2.rectangle(picture, *corners, _WHITE, 3)
    cv2.line(picture, _pixel(np.array((0.0, -2.2875))), _pixel(np.array((0.0, 2.2875))), _WHITE, 3)
    marks = load_landmarks("middle_size_field")
    for kind, color in _GOALS.items():
        outline = np.array([_pixel(np.array(c)) for c in marks[kind][0].corners])
        cv2.polylines(picture, [outline], True, color, 5)
    for place, error in zip(np.repeat(places, num, axis=0), errors, strict=False):
        end = place + _LONGER * error[:2]
        cv2.line(picture, _pixel(place), _pixel(end), _RED, 2, cv2.LINE_AA)
    for place in places:
        cv2.circle(picture, _pixel(np.array(place)), 5, _WHITE, -1, cv2.LINE_AA)
    cv2.imwrite(str(path), np.vstack((picture, _legend(picture.shape[1]))))
    return path


def _legend(width: int) -> np.ndarray:
    """Return a strip that says what is drawn, with a bar as long as an error of 5 cm."""
    strip = np.full((_LEGEND_PX, width, 3), 255, dtype=np.uint8)
    row, bar = _LEGEND_PX // 2, round(_LEGEND_M * _LONGER * _PX_PER_M)
    cv2.circle(strip, (30, row), 5, _BLACK, 1, cv2.LINE_AA)
    _write(strip, "a place", 45)
    cv2.line(strip, (165, row), (165 + bar, row), _RED, 2, cv2.LINE_AA)
    _write(strip, f"to a pose found there; this long: {100.0 * _LEGEND_M:.0f} cm off", 175 + bar)
    _write(strip, "blue, yellow: goals", 700)
    return strip


def _write(strip: np.ndarray, text: str, column: int) -> None:
    at = (column, _LEGEND_PX // 2 + 6)
    cv2.putText(strip, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, _BLACK, 1, cv2.LINE_AA)


def _pixel(place: np.ndarray) -> tuple[int, int]:
    u, v = (place + _HALF_M) * _PX_PER_M
    return int(round(u)), int(round(2.0 * _HALF_M[1] * _PX_PER_M - v))
