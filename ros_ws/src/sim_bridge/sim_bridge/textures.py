"""Pictures on floors and walls, made from numbers, and how a ray looks them up.

An atlas holds every texture with its mip levels: a ray takes the level whose texels are as large
as the patch it stands for, so that far lines fade instead of flicker. Patterns on walls and
furniture repeat and scale the color below them; a floor picture is a color of its own.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import NamedTuple

import cv2
import numba
import numpy as np

PATTERN_EDGE_PX = 512
PATTERN_TEXEL = 0.004  # m; a pattern repeats after about 2 m
_UNIT = 127.5  # the texel of a pattern that leaves a color as it is
_MAX_LEVELS = 12


class TextureAtlas(NamedTuple):
    """All textures with their mip levels.

    Attributes:
        texels: RGB uint8, (M, 3).
        levels: (first texel, rows, columns) of each texture and level, (K, L, 3); rows 0 = none.
        texel_sizes: Edge of a texel of level 0, (K,), m.
    """

    texels: np.ndarray
    levels: np.ndarray
    texel_sizes: np.ndarray


def atlas_of(pictures: list[np.ndarray], texel_sizes: list[float]) -> TextureAtlas:
    """Return an atlas of RGB uint8 pictures (rows along +y, columns along +x)."""
    levels = np.zeros((max(len(pictures), 1), _MAX_LEVELS, 3), dtype=np.int64)
    texels, count = [np.zeros((1, 3), dtype=np.uint8)], 1
    for k, picture in enumerate(pictures):
        for level in range(_MAX_LEVELS):
            rows, columns = picture.shape[:2]
            levels[k, level] = count, rows, columns
            texels.append(picture.reshape(-1, 3))
            count += rows * columns
            if rows < 2 or columns < 2:
                break
            picture = _halved(picture)
    return TextureAtlas(np.concatenate(texels), levels, np.array(texel_sizes or [1.0]))


def _halved(picture: np.ndarray) -> np.ndarray:
    # An odd edge is repeated first, so that a texel stays exactly twice as large.
    rows, columns = picture.shape[:2]
    even = np.pad(picture, ((0, rows % 2), (0, columns % 2), (0, 0)), mode="edge")
    quads = even.reshape(len(even) // 2, 2, even.shape[1] // 2, 2, 3).astype(np.float32)
    return np.rint(quads.mean(axis=(1, 3))).astype(np.uint8)


def pattern(name: str) -> np.ndarray:
    """Return a repeating pattern, RGB uint8; `_UNIT` leaves the color below as it is."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    factor = _PATTERNS[name](rng)
    return np.clip(np.rint(factor * _UNIT), 0, 255).astype(np.uint8)


def noise(rng: np.random.Generator, shape: tuple[int, int], cell: int) -> np.ndarray:
    """Return smooth noise that repeats, mean 0, deviation 1, with features of `cell` pixels."""
    rows, columns = max(shape[0] // cell, 1), max(shape[1] // cell, 1)
    coarse = np.pad(rng.standard_normal((rows, columns)), 2, mode="wrap").astype(np.float32)
    height, width = round(shape[0] * (rows + 4) / rows), round(shape[1] * (columns + 4) / columns)
    fine = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    top, left = (height - shape[0]) // 2, (width - shape[1]) // 2
    cut = fine[top : top + shape[0], left : left + shape[1]]
    return np.asarray((cut - cut.mean()) / max(cut.std(), 1e-6))


def _square(rng: np.random.Generator, cell: int) -> np.ndarray:
    return noise(rng, (PATTERN_EDGE_PX, PATTERN_EDGE_PX), cell)


def _grain(rng: np.random.Generator) -> np.ndarray:
    gray = 1.0 + 0.10 * _square(rng, 2) + 0.08 * _square(rng, 8) + 0.08 * _square(rng, 64)
    return np.repeat(gray[:, :, None], 3, axis=2)


def _paper(rng: np.random.Generator) -> np.ndarray:
    """Wallpaper: colored blotches of several sizes, so that every place looks its own."""
    tint = np.stack([_square(rng, 128) for _ in range(3)], axis=2)
    fine = 0.16 * _square(rng, 4) + 0.16 * _square(rng, 16)
    return 1.0 + 0.12 * tint + fine[:, :, None]


def _bricks(rng: np.random.Generator) -> np.ndarray:
    rows, columns = np.mgrid[:PATTERN_EDGE_PX, :PATTERN_EDGE_PX]
    course = rows // 32
    across = (columns + 32 * (course % 2)) % PATTERN_EDGE_PX
    tone = 1.0 + 0.15 * rng.standard_normal((16, 8))[course, across // 64]
    is_joint = (rows % 32 < 3) | (across % 64 < 3)
    return (
        np.repeat(np.where(is_joint, 0.6, tone)[:, :, None], 3, axis=2)
        + 0.05 * (_square(rng, 2)[:, :, None])
    )


def _wood(rng: np.random.Generator) -> np.ndarray:
    rings = np.sin(0.35 * np.arange(PATTERN_EDGE_PX)[:, None] + 2.0 * _square(rng, 64))
    gray = 1.0 + 0.15 * rings + 0.06 * _square(rng, 2)
    return np.asarray(gray[:, :, None] * np.array([1.0, 0.97, 0.92]))


def _books(rng: np.random.Generator) -> np.ndarray:
    """Upright spines of all colors, dark between the boards."""
    out = np.ones((PATTERN_EDGE_PX, PATTERN_EDGE_PX, 3))
    left = 0
    while left < PATTERN_EDGE_PX:
        width = int(rng.integers(5, 14))
        out[:, left : left + width] = rng.uniform(0.3, 1.8, 3)
        out[:, left : left + 1] = 0.3
        left += width
    return out + 0.08 * _square(rng, 2)[:, :, None]


def _stripes(rng: np.random.Generator) -> np.ndarray:
    columns = np.arange(PATTERN_EDGE_PX) // 64 % 2
    gray = np.where(columns == 0, 0.75, 1.2)[None, :] + 0.05 * _square(rng, 2)
    return np.repeat(gray[:, :, None], 3, axis=2)


_PATTERNS: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "books": _books,
    "bricks": _bricks,
    "grain": _grain,
    "paper": _paper,
    "stripes": _stripes,
    "wood": _wood,
}


@numba.njit(cache=True, error_model="numpy", inline="always")
def sample(texels, levels, texel_sizes, k, u, v, patch, is_repeated):  # type: ignore[no-untyped-def]
    """Return the color (r, g, b), 0..1, of a texture between its four nearest texels.

    Args:
        texels: Of the atlas, as levels and texel_sizes.
        levels: See texels.
        texel_sizes: See texels.
        k: The texture.
        u: Place along the columns, m.
        v: Place along the rows, m.
        patch: Edge of the patch that the ray stands for, m.
        is_repeated: True for a pattern.
    """
    level, size = 0, texel_sizes[k]
    while patch > 1.4 * size and level + 1 < levels.shape[1] and levels[k, level + 1, 1] > 0:
        level, size = level + 1, 2.0 * size
    start, height, width = levels[k, level, 0], levels[k, level, 1], levels[k, level, 2]
    j0, j1, x = _neighbors(u / size - 0.5, width, is_repeated)
    i0, i1, y = _neighbors(v / size - 0.5, height, is_repeated)
    a, b = start + i0 * width + j0, start + i0 * width + j1
    c, d = start + i1 * width + j0, start + i1 * width + j1
    p, q = (1.0 - x) * (1.0 - y) / 255.0, x * (1.0 - y) / 255.0
    r, s = (1.0 - x) * y / 255.0, x * y / 255.0
    red = p * texels[a, 0] + q * texels[b, 0] + r * texels[c, 0] + s * texels[d, 0]
    green = p * texels[a, 1] + q * texels[b, 1] + r * texels[c, 1] + s * texels[d, 1]
    blue = p * texels[a, 2] + q * texels[b, 2] + r * texels[c, 2] + s * texels[d, 2]
    return red, green, blue


@numba.njit(cache=True, error_model="numpy")
def _neighbors(place, count, is_repeated):  # type: ignore[no-untyped-def]
    """Return the two texels around a place and the share of the second."""
    first = int(math.floor(place))
    share = place - first
    if is_repeated:
        first %= count
        return first, first + 1 if first + 1 < count else 0, share
    return min(max(first, 0), count - 1), min(max(first + 1, 0), count - 1), share
