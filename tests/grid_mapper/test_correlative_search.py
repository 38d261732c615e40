import numpy as np
import pytest
from worlds import scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper.correlative_search import CELL_M, _scores, find_peaks, is_same_peak

TOL_M, TOL_RAD = 0.08, 0.03


def points_at(pose):
    return scan_at(pose, square_room()).points()


@pytest.mark.parametrize("moved", [SE2(0.0, 0.0, 0.0), SE2(-0.9, 0.8, 0.9), SE2(-1.6, 0.5, 3.0)])
def test_the_best_peak_is_where_the_query_was_taken(moved):
    here = SE2(0.3, -0.4, 0.2)
    best = find_peaks(points_at(here), points_at(here @ moved), SE2.identity(), (2.0, np.pi), 3)[0]
    off = best.pose.between(moved)
    assert off.distance < TOL_M and abs(off.yaw) < TOL_RAD
    assert best.score > 0.7


def test_peaks_come_best_first_and_apart_from_each_other():
    here = SE2(0.3, -0.4, 0.2)
    peaks = find_peaks(points_at(here), points_at(here), SE2.identity(), (1.5, np.pi), 4)
    scores = [peak.score for peak in peaks]
    assert len(peaks) > 1 and scores == sorted(scores, reverse=True)
    pairs = [(a.pose, b.pose) for k, a in enumerate(peaks) for b in peaks[:k]]
    assert not any(is_same_peak(a, b) for a, b in pairs)


def test_the_window_bounds_what_is_found():
    here, moved = SE2(0.3, -0.4, 0.2), SE2(1.5, 0.0, 0.0)
    found = find_peaks(points_at(here), points_at(here @ moved), SE2.identity(), (0.4, 0.1), 3)
    assert all(peak.pose.distance < 0.4 * np.sqrt(2.0) + 0.3 for peak in found)


def test_nothing_to_compare_gives_no_peak():
    points = points_at(SE2.identity())
    assert find_peaks(np.zeros((0, 2)), points, SE2.identity(), (1.0, 1.0), 3) == []
    assert find_peaks(points, np.zeros((0, 2)), SE2.identity(), (1.0, 1.0), 3) == []


@pytest.mark.parametrize("stride", [1, 4])
def test_scores_are_the_means_of_the_cells_that_the_points_fall_into(stride):
    rng = np.random.default_rng(0)
    field = rng.integers(0, 255, (31, 27), dtype=np.uint8)
    query = rng.uniform(-1.0, 1.0, (15, 2))
    corner, center, turns, num = np.array([-0.4, -0.7]), SE2(0.1, 0.2, 0.3), [-0.2, 0.1], 3
    found = _scores(field, corner, query, center.as_array(), np.array(turns), num, stride)
    for k, turn in enumerate(turns):
        for r, c in np.ndindex(2 * num + 1, 2 * num + 1):
            at = SE2(center.x, center.y, center.yaw + turn) @ query - corner
            cells = np.floor(at / CELL_M).astype(int) + stride * (np.array([c, r]) - num)
            inside = ((cells >= 0) & (cells < field.shape[::-1])).all(axis=1)
            cols, rows = cells[inside].T
            total = field[rows, cols].astype(int).sum()
            assert found[k, r, c] == pytest.approx(total / len(query), abs=1e-4)
