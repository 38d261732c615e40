"""Which color around the robot is the floor's, when nothing is known of it yet.

The robot stands on the floor, so on the way outward from it an obstacle begins where floor ends,
and floor does not begin where an obstacle ends but behind a low one. The color most around the
robot is taken for the floor's unless another lies inside of it: from there the floor grows outward,
and a wall that the robot touches is not learned however much of the picture it fills. Ours; the
paper takes samples.
"""

from __future__ import annotations

import numpy as np

from floor_perception.color_model import FloorColor, densest, has_color, refuse_useless
from floor_perception.config import ColorConfig

_NUM_DIRECTIONS = 72
_NUM_BANDS = 10
_THICK_BANDS = 2
_MIN_SHARE = 0.1
_MAX_COLORS = 4
_MIN_DIRECTIONS = 2
_OUTRIGHT = 0.75


def learn_first(
    colors: np.ndarray, bearings: np.ndarray, distances: np.ndarray, config: ColorConfig
) -> FloorColor:
    """Return the color of the floor around a robot.

    Args:
        colors: Of the ring around it, (N, 3), R, G, B.
        bearings: Of these pixels, (N,), rad.
        distances: Of these pixels on the floor, (N,), m.
        config: How near colors are, and the share one must have.

    Raises:
        ValueError: No color prevails, the one that does lies outside of another, or the floor is
            too dark or too bright to have a color.
    """
    color = _innermost(colors, bearings, distances, config)
    refuse_useless(color)
    return color


def _innermost(
    colors: np.ndarray, bearings: np.ndarray, distances: np.ndarray, config: ColorConfig
) -> FloorColor:
    found, labels = colors_of(colors, config)
    shares = np.bincount(labels[labels >= 0], minlength=len(found)) / len(labels)
    most = int(shares.argmax())
    inside = order_outward(labels, bearings, distances, len(found))
    is_inside = (inside[:, most] >= _MIN_DIRECTIONS) & (inside[:, most] > 2 * inside[most])
    if not is_inside.any():
        if shares[most] < config.ring_share:
            refuse_useless(found[most])  # the better reason: it has hardly a pixel then
            raise ValueError(
                f"only {shares[most]:.0%} of the pixels share a color, not {config.ring_share:.0%}"
            )
        return found[most]
    if shares[most] >= _OUTRIGHT:
        raise ValueError(f"{shares[most]:.0%} of the ring has a color that begins behind another")
    return found[int(np.where(is_inside, inside[:, most], -1).argmax())]


def colors_of(colors: np.ndarray, config: ColorConfig) -> tuple[list[FloorColor], np.ndarray]:
    """Return the colors that a good part of some pixels (N, 3) have, and which each has, (N,).

    Raises:
        ValueError: Too few pixels.
    """
    found: list[FloorColor] = [densest(colors, config)]
    labels = np.where(has_color(found[0], colors, config), 0, -1)
    while len(found) < _MAX_COLORS:
        (rest,) = np.nonzero(labels < 0)
        if len(rest) < _MIN_SHARE * len(labels):
            break
        try:
            color = densest(colors[rest], config)
        except ValueError:
            break
        own = rest[has_color(color, colors[rest], config)]
        if len(own) < _MIN_SHARE * len(labels):
            break
        labels[own] = len(found)
        found.append(color)
    return found, labels


def order_outward(
    labels: np.ndarray, bearings: np.ndarray, distances: np.ndarray, num: int
) -> np.ndarray:
    """Return in how many directions color a is nearest and color b comes behind it, (num, num).

    What is nearest counts if it is a fifth of the ring thick at least: lines are not.

    Args:
        labels: Color of each pixel, -1 for another, (N,).
        bearings: Their bearings, (N,), rad.
        distances: Their distances, (N,), m.
        num: Number of colors.
    """
    turn = (bearings + np.pi) / (2.0 * np.pi)
    direction = (turn * _NUM_DIRECTIONS).astype(int) % _NUM_DIRECTIONS
    low, high = distances.min(), distances.max()
    band = ((distances - low) / max(high - low, 1e-9) * _NUM_BANDS).astype(int)
    cell = direction * _NUM_BANDS + np.minimum(band, _NUM_BANDS - 1)
    counts = np.zeros((_NUM_DIRECTIONS * _NUM_BANDS, num + 1), dtype=int)
    np.add.at(counts, (cell, labels), 1)  # label -1 is the last column
    most = np.where(counts.any(axis=1), counts.argmax(axis=1), num)
    inside = np.zeros((num + 1, num + 1), dtype=int)
    for way in most.reshape(_NUM_DIRECTIONS, _NUM_BANDS):
        if (way[:_THICK_BANDS] == way[0]).all():
            for behind in set(way.tolist()) - {int(way[0])}:
                inside[way[0], behind] += 1
    return inside[:num, :num]
