import numpy as np
import pytest
from voxel_rooms import CAMERAS, room

from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_search import (
    Candidates,
    PublishedSearch,
    first_candidates,
    subdivided,
)
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import VoxelScene


def paper_map():
    shape = (2, 512, 512)
    return VoxelMap(np.zeros((*shape, 3), np.uint8), np.zeros(shape, bool), 0.01, 1.28, -1.0, 2.0)


def test_the_papers_first_mesh():
    first = first_candidates(VoxelScene(paper_map()), StereoLocalizerConfig())
    assert len(first.nodes) == 32 * 32 * 16
    assert first.spacing == pytest.approx([0.16, 0.16, 2 * np.pi / 16])
    assert first.poses.min(axis=0) == pytest.approx([-1.0 + 0.08, 2.0 + 0.08, -np.pi])
    assert first.poses.max(axis=0)[:2] == pytest.approx([4.12 - 0.08, 7.12 - 0.08])


def test_a_candidate_is_surrounded_at_half_the_step():
    one = Candidates(np.array([[3, 4, 5]]), np.array([0.2, 0.2, np.pi / 8]), np.zeros(3))
    around = subdivided(one)
    assert len(around.nodes) == 27
    assert around.spacing == pytest.approx([0.1, 0.1, np.pi / 16])
    off = around.poses - one.poses
    assert np.unique(np.round(off[:, 0], 9)).tolist() == pytest.approx([-0.1, 0.0, 0.1])
    assert (np.abs(off).sum(axis=1) < 1e-9).sum() == 1  # it stays a candidate itself


def test_neighbors_share_what_is_between_them():
    pair = Candidates(
        np.array([[3, 4, 5], [4, 4, 5]]), np.array([0.2, 0.2, 0.1 * np.pi]), np.zeros(3)
    )
    assert len(subdivided(pair).nodes) == 27 + 18


def test_headings_are_those_of_a_circle():
    edge = Candidates(
        np.array([[3, 4, 0], [3, 4, 15]]), np.array([0.2, 0.2, np.pi / 8]), np.zeros(3)
    )
    nodes = subdivided(edge).nodes
    assert sorted(set(nodes[:, 2].tolist())) == [0, 1, 29, 30, 31]


def test_subdividing_ends_at_the_mesh_of_the_last_stage():
    config = StereoLocalizerConfig(mesh_cells=4, num_headings=8)
    search = PublishedSearch(VoxelScene(room()), CAMERAS, config)
    assert search.spacing == pytest.approx([3.2 / 64, 2.4 / 64, 2 * np.pi / 128])
