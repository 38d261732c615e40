"""How unlike what the cameras saw and what the map shows are (stereo paper, eq. 1).

Colors are normalized: shares of red, green and blue that sum to 1, so that shading does not count.
How the distance counts against them is not in the paper: here 1 m counts as `distance_weight`,
chosen on places that no figure is from.
"""

from __future__ import annotations

import numba
import numpy as np

from multi_localizer.stereo_view import StereoView


def published_scores(
    color: np.ndarray,
    distance: np.ndarray,
    view: StereoView,
    distance_weight: float,
    farthest_m: float,
) -> np.ndarray:
    """Return eq. 1, its mean over the pixels, for views rendered at many poses.

    Where the cameras know no distance only color counts; where the map has none, it is as far as
    can be.

    Args:
        color: Rendered mean RGB, (N, h, w, 3), float32.
        distance: Rendered, (N, h, w), float32, m; NaN where there is none.
        view: What was seen, of the same size.
        distance_weight: What 1 m counts; 0 for color alone.
        farthest_m: What is in the place of no distance.

    Returns:
        (N,), float64; less is better.
    """
    if color.shape[1:] != view.color.shape:
        raise ValueError(f"views must be of one size, got {color.shape[1:]}, {view.color.shape}")
    scores = np.empty(len(color))
    _published(
        color, distance, normalized(view.color), view.distance, distance_weight, farthest_m, scores
    )
    return scores


def normalized(color: np.ndarray) -> np.ndarray:
    """Return RGB (..., 3) as shares that sum to 1, float32; even where there is no light."""
    total = color.sum(axis=-1, keepdims=True, dtype=np.float32)
    shares = np.full(color.shape, 1.0 / 3.0, dtype=np.float32)
    np.divide(color, total, out=shares, where=total > 0.0)
    return shares


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _published(color, distance, seen_color, seen_distance, weight, farthest, scores):  # type: ignore[no-untyped-def]
    third = np.float32(1.0 / 3.0)
    rows, columns = seen_distance.shape
    for n in range(len(scores)):
        total = 0.0
        for v in range(rows):
            for u in range(columns):
                red, green, blue = color[n, v, u]
                light = red + green + blue
                if light > 0.0:
                    red, green, blue = red / light, green / light, blue / light
                else:
                    red, green, blue = third, third, third
                total += abs(red - seen_color[v, u, 0])  # eq. 1
                total += abs(green - seen_color[v, u, 1])
                total += abs(blue - seen_color[v, u, 2])
                seen = seen_distance[v, u]
                if weight > 0.0 and not np.isnan(seen):
                    far = distance[n, v, u]
                    total += weight * abs((farthest if np.isnan(far) else far) - seen)
        scores[n] = total / (rows * columns)
