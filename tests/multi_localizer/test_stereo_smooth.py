import numpy as np
import pytest

from multi_localizer.stereo_smooth import drop_islands, mean_within

NAN = np.nan


def test_islands_become_holes_and_larger_pieces_stay():
    image = np.full((6, 10), NAN, dtype=np.float32)
    image[1:3, 1:3] = 7.0  # 4 pixels
    image[1:6, 5:8] = 3.0  # 15 pixels
    image[4, 6] = 9.0  # an island of 1 within
    kept = drop_islands(image, 5)
    assert np.isnan(kept[1:3, 1:3]).all() and np.isnan(kept[4, 6])
    assert np.count_nonzero(kept == 3.0) == 14
    assert np.array_equal(drop_islands(image, 4)[1:3, 1:3], image[1:3, 1:3])
    assert np.array_equal(drop_islands(image, 0), image, equal_nan=True)


def test_a_mean_takes_no_part_of_what_differs_by_more():
    image = np.zeros((8, 12), dtype=np.float32)
    image[:, 6:] = 5.0
    assert np.array_equal(mean_within(image, 3, 1.0), image)


def test_means_by_hand_at_the_edge_and_within():
    row = np.array([[0.0, 0.3, 0.6, 4.0]], dtype=np.float32)
    assert mean_within(row, 1, 1.0)[0].tolist() == pytest.approx([0.15, 0.3, 0.45, 4.0])
    assert mean_within(row.T, 1, 1.0)[:, 0].tolist() == pytest.approx([0.15, 0.3, 0.45, 4.0])
    assert np.array_equal(mean_within(row, 0, 1.0), row)


def test_a_mean_reaches_beyond_a_small_image():
    image = np.full((2, 3), 2.5, dtype=np.float32)
    assert np.array_equal(mean_within(image, 15, 1.0), image)


def test_scatter_falls_with_the_root_of_the_number_averaged():
    scatter = np.random.default_rng(0).normal(10.0, 0.1, (60, 80)).astype(np.float32)
    assert mean_within(scatter, 3, 1.0).std() == pytest.approx(0.1 / 7.0, rel=0.15)
