import numpy as np
import pytest

from multi_localizer.stereo_score import normalized, published_scores
from multi_localizer.stereo_view import StereoView


def one_pixel(color, distance):
    shape = (1, 1)
    return StereoView(
        np.array(color, np.float32).reshape(1, 1, 3), np.full(shape, distance, np.float32),
        np.full(shape, 1.0 / distance, np.float32), np.ones(shape, np.float32),
    )  # fmt: skip


def shown(color, distance):
    return np.array(color, np.float32).reshape(-1, 1, 1, 3), np.array(distance, np.float32).reshape(
        -1, 1, 1
    )


def test_eq_1_by_hand():
    view = one_pixel((50, 25, 25), 2.0)  # shares 1/2, 1/4, 1/4
    color, distance = shown([(30, 30, 60), (100, 50, 50)], [2.5, 2.0])  # 1/4, 1/4, 1/2
    assert published_scores(color, distance, view, 0.4, 9.0) == pytest.approx([0.7, 0.0])
    assert published_scores(color, distance, view, 0.0, 9.0) == pytest.approx([0.5, 0.0])


def test_without_a_distance_in_the_map_it_is_the_farthest():
    color, distance = shown([(1, 1, 1)], [np.nan])
    scores = published_scores(color, distance, one_pixel((9, 9, 9), 2.0), 1.0, 9.0)
    assert scores == pytest.approx([7.0])


def test_without_a_distance_seen_only_color_counts():
    color, distance = shown([(0, 0, 10)], [3.0])
    scores = published_scores(color, distance, one_pixel((0, 10, 0), np.nan), 1.0, 9.0)
    assert scores == pytest.approx([2.0])


def test_shading_does_not_count():
    rng = np.random.default_rng(0)
    color = rng.uniform(10, 100, (3, 5, 3)).astype(np.float32)
    shading = rng.uniform(0.5, 2.0, (3, 5, 1)).astype(np.float32)
    assert np.allclose(normalized(color), normalized(color * shading), atol=1e-6)
    assert np.allclose(normalized(np.zeros((1, 3), np.float32)), 1.0 / 3.0)


def test_views_of_other_sizes_are_refused():
    color, distance = shown([(1, 1, 1)], [1.0])
    with pytest.raises(ValueError, match="one size"):
        published_scores(color[0], distance[0], one_pixel((1, 1, 1), 1.0), 1.0, 9.0)
