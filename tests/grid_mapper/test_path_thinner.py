"""The published path: thin, bounded, and never without the newest pose."""

import pytest

from floornav_common.se2 import SE2
from grid_mapper.path_thinner import PathThinner


def row(stamp_ns: int, pose: SE2) -> list:
    """Return a row that is equal to no other but itself by identity."""
    return [stamp_ns, pose]


def stamps(path: PathThinner) -> list[int]:
    return [stamp_ns for stamp_ns, _ in path.rows()]


def test_poses_closer_than_the_spacing_are_left_out_but_for_the_newest():
    path = PathThinner(row, spacing=0.1)
    for k in range(13):
        path.add(k, SE2(0.03 * k, 0.0, 0.0))
    assert stamps(path) == [0, 4, 8, 12]
    path.add(13, SE2(0.39, 0.0, 0.0))
    assert stamps(path) == [0, 4, 8, 12, 13]
    assert path.newest_stamp_ns == 13


def test_a_path_without_poses_is_empty():
    path = PathThinner(row)
    assert path.rows() == [] and path.newest_stamp_ns is None


def test_a_row_is_made_once_and_not_each_time_it_is_asked_for():
    made = []

    def counted(stamp_ns: int, pose: SE2) -> list:
        made.append(stamp_ns)
        return row(stamp_ns, pose)

    path = PathThinner(counted, spacing=0.1)
    for k in range(50):
        path.add(k, SE2(0.2 * k, 0.0, 0.0))
    first, second = path.rows(), path.rows()
    assert made == list(range(50))
    assert all(a is b for a, b in zip(first, second, strict=True))


@pytest.mark.parametrize("max_poses", [10, 11])
def test_a_long_path_is_bounded_and_keeps_its_ends(max_poses):
    path = PathThinner(row, spacing=0.1, max_poses=max_poses)
    for k in range(1000):
        path.add(k, SE2(0.11 * k, 0.0, 0.0))
        kept = stamps(path)
        assert len(kept) <= max_poses + 1
        assert kept[0] == 0 and kept[-1] == k and kept == sorted(set(kept))
    assert len(kept) > max_poses // 2
    gaps = [b - a for a, b in zip(kept[:-2], kept[1:-1], strict=True)]
    assert max(gaps) <= 2 * min(gaps)


def test_a_bound_below_two_is_refused():
    with pytest.raises(ValueError, match="max_poses must be >= 2, got 1"):
        PathThinner(row, max_poses=1)
