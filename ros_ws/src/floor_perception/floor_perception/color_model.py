"""The color of the floor: learned from pixels of it, looked up for every pixel of an image.

Colors are compared by chromaticity, (R, G) / (R + G + B), which a shadow leaves as it is, within
wide bounds of brightness. The floor's chromaticities are one Gaussian, found as the densest of the
pixels given: lines, dirt and an obstacle among them do not count while they are fewer. Ours: step 1
of the paper says only "extract the floor's color".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from floor_perception.config import ColorConfig

_BINS = 64
_NUM_TRIMS = 4
_MIN_PIXELS = 50
_LEAST_BRIGHTNESS = 30.0  # of R + G + B: darker, noise is larger than color
_DARKEST = 15.0
_SATURATED = 750.0
_MOVED_SD = 0.1
_MOVED_RATIO = 0.05
_NEAR_SD = 2.0
_NEAR_RATIO = 1.5


@dataclass(frozen=True)
class FloorColor:
    """What the floor looks like.

    Attributes:
        chroma: Mean chromaticity (r, g), (2,).
        cov: Its covariance at the brightness `middle`, (2, 2).
        low: Brightness R + G + B below which hardly any pixel of the floor was.
        middle: Median brightness.
        high: Brightness above which hardly any was.
    """

    chroma: np.ndarray
    cov: np.ndarray
    low: float
    middle: float
    high: float


def chromaticity(colors: np.ndarray) -> np.ndarray:
    """Return (r, g) of colors (..., 3) in the order R, G, B, shape (..., 2); black is gray."""
    total = colors.sum(axis=-1, keepdims=True, dtype=float)
    return np.where(total > 0.0, colors[..., :2] / np.maximum(total, 1.0), 1.0 / 3.0)


def learn(colors: np.ndarray, config: ColorConfig, share: float = 0.0) -> FloorColor:
    """Learn the floor's color from pixels most of which, or the densest part of which, are floor.

    Args:
        colors: (N, 3), R, G, B.
        config: Deviations.
        share: Least share of the pixels that must have the color found.

    Raises:
        ValueError: Too few pixels, no color that so many share, or one too dark or too bright.
    """
    color = densest(colors, config, share)
    refuse_useless(color)
    return color


def densest(colors: np.ndarray, config: ColorConfig, share: float = 0.0) -> FloorColor:
    """Return what `learn` does, though it may be too dark or too bright to tell the floor by.

    Raises:
        ValueError: Too few pixels, or no color that so many share.
    """
    if len(colors) < _MIN_PIXELS:
        raise ValueError(f"colors must be at least {_MIN_PIXELS} pixels, got {len(colors)}")
    chroma = chromaticity(colors)
    mean, cov = _peak(chroma), np.eye(2) * (1.5 / _BINS) ** 2
    for _ in range(_NUM_TRIMS):
        near = _distance2(chroma, mean, cov) < 9.0
        mean = chroma[near].mean(axis=0)
        cov = _floored(np.cov(chroma[near].T), config.min_sd)
    near = _distance2(chroma, mean, cov) < 9.0
    if near.mean() < share:
        raise ValueError(f"only {near.mean():.0%} of the pixels share a color, not {share:.0%}")
    return of_pixels(colors[near], config.min_sd)


def of_pixels(colors: np.ndarray, min_sd: float) -> FloorColor:
    """Return the color of pixels (N, 3), R, G, B, that are all of one thing."""
    chroma = chromaticity(colors)
    cov = _floored(np.cov(chroma.T), min_sd)
    low, middle, high = np.percentile(colors.sum(axis=1, dtype=float), (2, 50, 98))
    low, middle, high = (max(float(v), 1.0) for v in (low, middle, high))
    return FloorColor(chroma.mean(axis=0), cov, low, middle, high)


def refuse_useless(color: FloorColor) -> None:
    """Refuse a color by which the floor cannot be told.

    Raises:
        ValueError: It is nearly black, or so bright that the channels are saturated.
    """
    if color.middle < _LEAST_BRIGHTNESS:
        raise ValueError(
            f"too dark: brightness must be >= {_LEAST_BRIGHTNESS:g} of 765, got {color.middle:.0f}"
        )
    if color.middle >= _SATURATED:
        raise ValueError(
            f"saturated: brightness must be < {_SATURATED:g} of 765, got {color.middle:.0f}"
        )


def has_color(color: FloorColor, colors: np.ndarray, config: ColorConfig) -> np.ndarray:
    """Return which colors (N, 3), R, G, B, are the floor's, (N,), bool."""
    total = colors.sum(axis=-1, dtype=float)
    d2 = _distance2(chromaticity(colors), color.chroma, color.cov)
    widened = np.maximum(1.0, color.middle / np.maximum(total, 1.0))
    low, high = bounds(color, config)
    return np.asarray((total >= low) & (total <= high) & (d2 < config.gate_sd**2 * widened))


def bounds(color: FloorColor, config: ColorConfig) -> tuple[float, float]:
    """Return least and greatest brightness of the floor; nearly black is never floor."""
    return max(config.darker * color.low, _DARKEST), config.brighter * color.high


def followed(old: FloorColor, colors: np.ndarray, part: float) -> FloorColor:
    """Return a color that has gone a part of the way to what pixels (N, 3), R, G, B, show.

    Medians are gone after, which an obstacle among the pixels hardly moves while it is the smaller
    part. The spread of chromaticity and of brightness about the median stays as it was learned:
    if it followed, whatever is let in would widen it and let more in.
    """
    chroma = np.median(chromaticity(colors), axis=0)
    middle = max(float(np.median(colors.sum(axis=1, dtype=float))), 1.0)
    scale = (middle / old.middle) ** part
    return replace(
        old,
        chroma=old.chroma + part * (chroma - old.chroma),
        low=old.low * scale,
        middle=old.middle * scale,
        high=old.high * scale,
    )


def is_near(a: FloorColor, b: FloorColor) -> bool:
    """Return whether a color is one that a light which changed a little makes of another."""
    is_hue_near = float(_distance2(b.chroma, a.chroma, a.cov)) < _NEAR_SD**2
    return is_hue_near and abs(math.log(b.middle / a.middle)) < math.log(_NEAR_RATIO)


def response_part(dt: float, time_constant: float) -> float:
    """Return the part of a step response that has passed after dt; 0 for no time constant."""
    return 1.0 - math.exp(-dt / time_constant) if time_constant > 0.0 and dt > 0.0 else 0.0


def differs(a: FloorColor, b: FloorColor) -> bool:
    """Return whether two colors are so far apart that a table of one does not do for the other."""
    is_moved = float(_distance2(b.chroma, a.chroma, a.cov)) > _MOVED_SD**2
    ratios = [b.low / a.low, b.high / a.high, *(np.diag(b.cov) / np.diag(a.cov))]
    return is_moved or max(abs(np.log(ratios))) > _MOVED_RATIO


def _peak(chroma: np.ndarray) -> np.ndarray:
    """Return the chromaticity that most pixels have nearby."""
    counts = np.histogram2d(chroma[:, 0], chroma[:, 1], bins=_BINS, range=((0, 1), (0, 1)))[0]
    smooth = cv2.GaussianBlur(counts, (0, 0), 1.0, borderType=cv2.BORDER_CONSTANT)
    peak = np.unravel_index(int(smooth.argmax()), smooth.shape)
    return (np.array(peak) + 0.5) / _BINS


def _distance2(chroma: np.ndarray, mean: np.ndarray, cov: np.ndarray) -> np.ndarray:
    off = chroma - mean
    return np.einsum("...i,ij,...j->...", off, np.linalg.inv(cov), off)


def _floored(cov: np.ndarray, min_sd: float) -> np.ndarray:
    values, axes = np.linalg.eigh(cov)
    return np.asarray(axes @ np.diag(np.maximum(values, min_sd**2)) @ axes.T)
