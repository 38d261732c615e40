"""How much of the views is wrong at a pose, by which poses are held against each other.

The same cost of a pixel as in `stereo_refine`, without derivatives, on finer views and with color
counting as much as distance: places that look alike to stereo often differ in color alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np

from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_refine import Target, fit_scales, refine
from multi_localizer.voxel_view import VoxelScene

_RAYS = (2, 3)
"""Columns and rows of rays that a pixel takes the mean of, as what was seen is a mean."""

_POLISH_STEPS = 3


def judge(
    scene: VoxelScene, targets: Sequence[Target], poses: np.ndarray, config: StereoLocalizerConfig
) -> np.ndarray:
    """Return the mean cost of a pixel at each pose, (N,), 0 to 1."""
    costs = np.zeros(len(poses))
    scales = fit_scales(config.judge_color, len(targets), config, 1.0)
    for target in targets:
        color, distance = scene.render(poses, target.camera, target.size, _RAYS)
        _add_costs(
            color,
            distance,
            target.color,
            target.inverse,
            target.weight,
            target.precision,
            scales,
            costs,
        )
    return costs


def polished(
    scene: VoxelScene, targets: Sequence[Target], poses: np.ndarray, config: StereoLocalizerConfig
) -> np.ndarray:
    """Return poses moved to where `judge` finds them best, (N, 3), so that it is fair to all."""
    fits = refine(
        scene, targets, poses, config, _POLISH_STEPS, config.judge_color, 1.0, None, _RAYS
    )
    return fits.poses


def doubts(costs: np.ndarray, config: StereoLocalizerConfig) -> np.ndarray:
    """Return what mean costs say against poses, as logarithms, (N,).

    Where the map is a good one costs are small and differences between them are the views' noise,
    which `evidence` is for. Where all poses cost more the map itself is wrong in places, by more
    than the noise and not alike at each pose: there the ratio of the costs counts, as it does where
    the size of errors is not known beforehand.
    """
    usual = config.usual_cost
    return np.asarray(config.evidence * usual * np.log1p(np.asarray(costs) / usual))


def known_part(targets: Sequence[Target]) -> float:
    """Return the share of the pixels whose distance is known, 0 to 1."""
    return sum(float(t.weight.mean()) for t in targets) / max(len(targets), 1)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _add_costs(color, distance, seen_color, seen_inverse, seen_weight, precision, scales, costs):  # type: ignore[no-untyped-def]
    rows, columns = seen_weight.shape
    color_part, distance_part = scales[0] / (rows * columns), scales[1] / (rows * columns)
    for n in range(len(costs)):
        for v in range(rows):
            for u in range(columns):
                weight, far = distance_part * seen_weight[v, u], distance[n, v, u]
                if np.isnan(far):
                    costs[n] += color_part + weight
                    continue
                square = (1.0 / max(far, 0.01) - seen_inverse[v, u]) ** 2 * precision[v, u]
                costs[n] += weight * square / (1.0 + square)
                light, square = 1e-3, 0.0
                for c in range(3):
                    light += color[n, v, u, c]
                for c in range(3):
                    square += (color[n, v, u, c] / light - seen_color[v, u, c]) ** 2 * scales[2]
                costs[n] += color_part * square / (1.0 + square)
