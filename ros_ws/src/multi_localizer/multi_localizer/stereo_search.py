"""The pose by search from coarse to fine over map and views at once (stereo paper, 3.3.2, Fig. 5).

The map is cut into a coarse mesh, 32 x 32 with 16 headings, and each of its poses is scored on
views of a single pixel, their mean. The 100 best stay; around each the mesh is halved, which makes
new candidates, and all are scored on finer views; and so on until the views are 320 x 8. The paper
does not say which views are between: `view_columns` and `view_rows` do.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_score import published_scores
from multi_localizer.stereo_view import StereoView, coarser
from multi_localizer.voxel_view import ViewCamera, VoxelScene

_CHUNK_RAYS = 1 << 20
_LEAST_RAYS = (40, 4)
"""A view of fewer pixels takes the mean of so many rays."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Poses of a mesh.

    Attributes:
        nodes: Steps along x, y and yaw, (N, 3), int.
        spacing: Length of these steps, m, m, rad.
        origin: Where node (0, 0, 0) is.
    """

    nodes: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray

    @property
    def poses(self) -> np.ndarray:
        """(N, 3): x, y, yaw."""
        return np.asarray(self.origin + self.nodes * self.spacing)


class PublishedSearch:
    """The paper's search in one map.

    Args:
        scene: The map.
        cameras: One for each pair.
        config: Mesh, views, weight of distances.
    """

    def __init__(
        self, scene: VoxelScene, cameras: Sequence[ViewCamera], config: StereoLocalizerConfig
    ) -> None:
        self._scene, self._cameras, self._config = scene, tuple(cameras), config
        self._first = self._free(first_candidates(scene, config))
        self._first_views: list[tuple[np.ndarray, np.ndarray]] = [
            self._render(self._first.poses, camera, self._sizes[0]) for camera in self._cameras
        ]

    def reconfigure(self, config: StereoLocalizerConfig) -> None:
        """Take other tuning; mesh and views stay."""
        self._config = config

    def search(
        self, views: Sequence[StereoView | None], distance_weight: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the candidates of the last stage, best first, (N, 3), and their scores, (N,)."""
        best = self._first
        scores = np.zeros(len(best.nodes))
        for stage, size in enumerate(self._sizes):
            if stage > 0:
                best = self._free(subdivided(best))
            scores = self._scores(best, views, size, distance_weight, stage == 0)
            order = np.argsort(scores, kind="stable")[: self._config.num_kept]
            best = Candidates(best.nodes[order], best.spacing, best.origin)
            scores = scores[order]
        return best.poses, scores

    @property
    def spacing(self) -> np.ndarray:
        """Of the last stage's mesh: m, m, rad."""
        return np.asarray(self._first.spacing / 2.0 ** (len(self._sizes) - 1))

    @property
    def _sizes(self) -> list[tuple[int, int]]:
        return list(zip(self._config.view_columns, self._config.view_rows, strict=True))

    def _free(self, candidates: Candidates) -> Candidates:
        poses = candidates.poses
        free = np.ones(len(poses), dtype=bool)
        for camera in self._cameras:
            free &= self._scene.is_free(poses, camera)
        return Candidates(candidates.nodes[free], candidates.spacing, candidates.origin)

    def _scores(
        self,
        candidates: Candidates,
        views: Sequence[StereoView | None],
        size: tuple[int, int],
        distance_weight: float,
        is_first: bool,
    ) -> np.ndarray:
        """Return the mean of eq. 1 over the pairs that saw something, (N,)."""
        poses, farthest = candidates.poses, self._scene.voxels.farthest_m
        total = np.zeros(len(poses))
        for k, (camera, view) in enumerate(zip(self._cameras, views, strict=True)):
            if view is None:
                continue
            seen = coarser(view, size)
            step = len(poses) if is_first else max(1, _CHUNK_RAYS // (size[0] * size[1]))
            for start in range(0, len(poses), max(step, 1)):
                part = slice(start, start + step)
                shown = (
                    self._first_views[k] if is_first else self._render(poses[part], camera, size)
                )
                total[part] += published_scores(*shown, seen, distance_weight, farthest)
        return total / max(sum(v is not None for v in views), 1)

    def _render(
        self, poses: np.ndarray, camera: ViewCamera, size: tuple[int, int]
    ) -> tuple[np.ndarray, np.ndarray]:
        wide, tall = (max(1, -(-least // n)) for least, n in zip(_LEAST_RAYS, size, strict=True))
        return self._scene.render(poses, camera, size, (wide, tall))


def first_candidates(scene: VoxelScene, config: StereoLocalizerConfig) -> Candidates:
    """Return the middles of the coarse mesh's squares with every heading."""
    width, depth, _ = scene.voxels.size_m
    num, turns = config.mesh_cells, config.num_headings
    spacing = np.array([width / num, depth / num, 2.0 * np.pi / turns])
    corner = np.array([scene.voxels.origin_x_m, scene.voxels.origin_y_m, -np.pi])
    nodes = np.stack(np.meshgrid(np.arange(num), np.arange(num), np.arange(turns)), axis=-1)
    half = np.array([0.5, 0.5, 0.0])
    return Candidates(nodes.reshape(-1, 3), spacing, corner + half * spacing)


def subdivided(candidates: Candidates) -> Candidates:
    """Return candidates and all that lie half a step from them (Fig. 5), none twice."""
    around = np.array(list(itertools.product((-1, 0, 1), repeat=3)))
    nodes = (2 * candidates.nodes[:, None] + around).reshape(-1, 3)
    spacing = candidates.spacing / 2.0
    nodes[:, 2] %= round(2.0 * np.pi / spacing[2])
    return Candidates(np.unique(nodes, axis=0), spacing, candidates.origin)
