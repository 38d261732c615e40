"""The pose at which what the cameras saw fits the map best, from poses near it.

A pixel of a view costs (q / (1 + q)) with q the square of its error over what is half wrong (Geman
and McClure): some of it for its color, the rest for its inverse distance, so that wrong
matches and what is not in the map hardly count. The sum is brought to its least by Gauss-Newton
steps, damped as by Levenberg and Marquardt; derivatives are differences of views rendered a little
to both sides of the pose, over which the steps of cells and layers even out. Pixels whose
distance jumps between them say nothing about the derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_normal_equations import STEP, normal_equations
from multi_localizer.stereo_score import normalized
from multi_localizer.stereo_view import StereoView, coarser
from multi_localizer.voxel_view import ViewCamera, VoxelScene

_SIDES = np.concatenate((np.zeros((1, 3)), np.repeat(np.eye(3), 2, axis=0) * STEP))
_SIDES[2::2] *= -1.0
_FIRST_DAMPING, _LESS, _MORE = 1e-3, 0.3, 10.0
_LONGEST = np.array([0.15, 0.15, 0.15])


@dataclass(frozen=True, eq=False)
class Target:
    """What one camera saw, as it is compared.

    Attributes:
        camera: The camera.
        color: Normalized RGB, (h, w, 3), float32.
        inverse: One over the distance, (h, w), float32; 0 where unknown.
        weight: Of the distance, (h, w), float32; 0 where unknown.
        precision: One over the square of its error that counts as half wrong, (h, w), float32.
    """

    camera: ViewCamera
    color: np.ndarray
    inverse: np.ndarray
    weight: np.ndarray
    precision: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows."""
        return self.weight.shape[1], self.weight.shape[0]


@dataclass(frozen=True, eq=False)
class Fits:
    """Poses refined.

    Attributes:
        poses: (N, 3): x, y, yaw.
        costs: Mean cost of a pixel at each, (N,), 0 to 1.
        hessians: Of these costs, (N, 3, 3), as Gauss and Newton have it.
    """

    poses: np.ndarray
    costs: np.ndarray
    hessians: np.ndarray

    def part(self, which: slice) -> Fits:
        """Return some of them."""
        return Fits(self.poses[which], self.costs[which], self.hessians[which])

    def joined(self, other: Fits) -> Fits:
        """Return these and others."""
        return Fits(
            np.concatenate((self.poses, other.poses)),
            np.concatenate((self.costs, other.costs)),
            np.concatenate((self.hessians, other.hessians)),
        )


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of a pose beforehand, as a cost.

    Attributes:
        poses: Where it is expected, (N, 3).
        information: Weight of a deviation from it, (N, 3, 3), in the unit of the mean cost.
    """

    poses: np.ndarray
    information: np.ndarray


def targets_of(
    views: Sequence[StereoView | None], cameras: Sequence[ViewCamera], size: tuple[int, int],
    config: StereoLocalizerConfig,
) -> list[Target]:  # fmt: skip
    """Return what is compared at a resolution, of those pairs that saw something.

    Near things show errors of map and pose enlarged: a place off by e at the distance z has an
    inverse distance off by e / z^2, which stands beside the error of stereo itself.
    """
    targets = []
    for view, camera in zip(views, cameras, strict=True):
        if view is None:
            continue
        seen = coarser(view, size)
        inverse = np.nan_to_num(seen.inverse, nan=0.0).astype(np.float32)
        weight = np.where(np.isnan(seen.inverse), 0.0, seen.weight).astype(np.float32)
        variance = config.inverse_error_per_m**2 + (config.map_error_m * inverse**2) ** 2
        targets.append(Target(camera, normalized(seen.color), inverse, weight, 1.0 / variance))
    return targets


def refine(
    scene: VoxelScene,
    targets: Sequence[Target],
    poses: np.ndarray,
    config: StereoLocalizerConfig,
    num_steps: int,
    color_share: float,
    looseness: float = 1.0,
    prior: Prior | None = None,
    rays: tuple[int, int] = (1, 1),
) -> Fits:
    """Return poses moved to where the views fit best.

    Args:
        scene: The map.
        targets: What was seen.
        poses: Where to begin, (N, 3).
        config: Errors that count as half wrong.
        num_steps: How often a step is tried.
        color_share: What colors count; distances count the rest.
        looseness: Factor on these errors: more than 1 finds the way from farther off.
        prior: What is known of each pose beforehand.
        rays: Columns and rows of rays that a pixel of the map's view takes the mean of.
    """
    scales = fit_scales(color_share, len(targets), config, looseness)
    best = _linearized(scene, targets, poses, scales, prior, rays)
    damping = np.full(len(poses), _FIRST_DAMPING)
    for _ in range(num_steps):
        curvature = best.hessians + prior.information if prior is not None else best.hessians
        diagonal = np.einsum("nii->ni", curvature)
        eye = np.eye(3) * (damping[:, None] * diagonal + 1e-12)[:, None, :]
        step = -np.linalg.solve(curvature + eye, best.gradients[..., None])[..., 0]
        step /= np.maximum(np.abs(step) / _LONGEST, 1.0).max(axis=1, keepdims=True)
        tried = _linearized(scene, targets, best.poses + step, scales, prior, rays)
        better = tried.totals < best.totals
        damping = np.where(better, _LESS * damping, _MORE * damping)
        best = best.where(better, tried)
    yaw = np.pi - (np.pi - best.poses[:, 2]) % (2.0 * np.pi)
    return Fits(np.column_stack((best.poses[:, :2], yaw)), best.costs, best.hessians)


def fit_scales(
    color_share: float, num_targets: int, config: StereoLocalizerConfig, looseness: float
) -> np.ndarray:
    """Return the parts of color and distance, factors of their precisions, looseness."""
    return np.array([
        color_share / num_targets, (1.0 - color_share) / num_targets,
        1.0 / (looseness * config.color_error) ** 2,
        1.0 / looseness**2, max(looseness, 1.0),
    ])  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Linearized:
    """Costs around poses; gradients and totals with the prior, costs and Hessians without."""

    poses: np.ndarray
    costs: np.ndarray
    gradients: np.ndarray
    hessians: np.ndarray
    totals: np.ndarray

    def where(self, better: np.ndarray, other: _Linearized) -> _Linearized:
        """Return the other's where it is better."""
        return _Linearized(
            np.where(better[:, None], other.poses, self.poses),
            np.where(better, other.costs, self.costs),
            np.where(better[:, None], other.gradients, self.gradients),
            np.where(better[:, None, None], other.hessians, self.hessians),
            np.where(better, other.totals, self.totals),
        )


def _linearized(
    scene: VoxelScene, targets: Sequence[Target], poses: np.ndarray, scales: np.ndarray,
    prior: Prior | None, rays: tuple[int, int],
) -> _Linearized:  # fmt: skip
    around = (poses[:, None] + _SIDES).reshape(-1, 3)
    num, sums = len(poses), np.zeros((len(poses), 10))
    for target in targets:
        color, distance = scene.render(around, target.camera, target.size, rays)
        shape = (num, len(_SIDES), *target.weight.shape)
        scene.share(
            num, normal_equations, color.reshape(*shape, 3), distance.reshape(shape),
            target.color, target.inverse, target.weight, target.precision, scales, sums,
        )  # fmt: skip
    hessians = np.empty((num, 3, 3))
    rows, columns = np.triu_indices(3)
    hessians[:, rows, columns] = hessians[:, columns, rows] = sums[:, 4:]
    costs, gradients = sums[:, 0], sums[:, 1:4]
    totals = costs.copy()
    if prior is not None:
        off = poses - prior.poses
        off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
        pull = np.einsum("nij,nj->ni", prior.information, off)
        gradients, totals = gradients + pull, totals + 0.5 * (off * pull).sum(axis=1)
    return _Linearized(poses, costs, gradients, hessians, totals)
