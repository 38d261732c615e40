"""The published path: thin, and never without the newest pose."""

from floornav_common.se2 import SE2
from grid_mapper.path_thinner import PathThinner


def test_poses_closer_than_the_spacing_are_left_out_but_for_the_newest():
    path = PathThinner(spacing=0.1)
    for k in range(13):
        path.add(k, SE2(0.03 * k, 0.0, 0.0))
    assert [stamp for stamp, _ in path.poses()] == [0, 4, 8, 12]
    path.add(13, SE2(0.39, 0.0, 0.0))
    assert [stamp for stamp, _ in path.poses()] == [0, 4, 8, 12, 13]


def test_a_path_without_poses_is_empty():
    assert PathThinner().poses() == []
