"""The newest word of every view."""

import pickle

import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.sonar_views import END, SonarViews

POSE = SE2(0.02, 0.02, 0.01)


def empty(max_views=1000):
    return SonarViews(0.05, 0.1, max_views)


def test_echoes_again_from_one_place_make_one_view_of_bounded_weight():
    views = empty()
    for k, r in enumerate((1.00, 1.02, 1.01, 1.01, 1.01)):
        row = views.add(POSE, 0.17, r, True, k, 3.0)
    assert (views.num, row, views.used["weight"][0]) == (1, 0, 3.0)
    assert views.used["r"][0] == pytest.approx(1.01, abs=0.005)
    assert views.used["stamp_ns"][0] == 4


def test_another_word_takes_weight_first_and_then_replaces():
    views = empty()
    for _ in range(3):
        views.add(POSE, 0.17, 1.0, True, 0, 3.0)
    for weight in (2.0, 1.0):
        views.add(POSE, 0.17, 5.0, False, 1, 3.0)
        assert (views.used["is_echo"][0], views.used["weight"][0]) == (True, weight)
    views.add(POSE, 0.17, 5.0, False, 2, 3.0)
    assert (views.used["is_echo"][0], views.used["r"][0]) == (False, 5.0)


def test_another_place_or_direction_is_another_view():
    views = empty()
    for pose in (POSE, SE2(0.07, 0.02, 0.01), SE2(0.02, 0.02, 0.11), SE2(-0.02, 0.02, 0.01)):
        views.add(pose, 0.17, 1.0, True, 0, 3.0)
    assert views.num == 4


def walked(views, row):
    """Return the rows that walks from the cells about a view come by."""
    found = []
    for first in views.near(row):
        while first != END:
            found.append(int(first))
            first = views.rows[first]["next"]
    return sorted(found)


def test_neighbors_are_all_views_of_the_cells_about():
    views = empty()
    for x in (0.1, 0.5, 1.5, 2.5, -0.5):  # cells of 0.8 m: 0, 0, 1, 3, -1
        views.add(SE2(x, 0.1, 0.0), 0.17, 1.0, True, 0, 3.0)
    assert walked(views, 0) == [0, 1, 2, 4]


def test_memory_is_bounded_and_the_oldest_goes():
    views = empty(max_views=3)
    for k in range(10):
        views.add(SE2(0.1 * k, 0.0, 0.0), 0.17, 1.0, True, k, 3.0)
    assert views.num == 3
    assert sorted(views.used["stamp_ns"].tolist()) == [7, 8, 9]
    assert walked(views, 0) == [0, 1, 2]


def test_weight_depends_on_no_rate_once_it_is_full():
    slow, fast = empty(), empty()
    for _ in range(3):
        slow.add(POSE, 0.17, 1.0, True, 0, 3.0)
    for _ in range(300):
        fast.add(POSE, 0.17, 1.0, True, 0, 3.0)
    assert np.array_equal(slow.used, fast.used)


def test_views_are_the_same_after_they_were_pickled():
    views = SonarViews(0.05, 0.1, 3000)
    rng = np.random.default_rng(4)
    for k in range(5000):  # more than it holds, so that rows were used again
        pose = SE2(*(float(v) for v in rng.uniform(0.0, 4.0, 3)))
        views.add(pose, 0.15, 1.0, True, k, 3.0)
    again = pickle.loads(pickle.dumps(views))
    assert np.array_equal(again.used, views.used) and again.num == views.num
    assert all(np.array_equal(again.near(k), views.near(k)) for k in range(views.num))
    for held in (views, again):
        held.add(SE2(1.0, 1.0, 1.0), 0.15, 1.0, True, 9000, 3.0)
    assert np.array_equal(again.used, views.used)
