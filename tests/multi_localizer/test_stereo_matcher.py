import numpy as np
import pytest

from multi_localizer.stereo_config import METHODS, StereoMatcherConfig
from multi_localizer.stereo_matcher import StereoMatcher

FAR, NEAR = 6, 18


@pytest.fixture(scope="module")
def pair():
    """A near square before a far wall, both of noise; also the truth and what is hidden."""
    rng = np.random.default_rng(0)
    wall = rng.integers(0, 256, (48, 160, 3), dtype=np.uint8)
    square = rng.integers(0, 256, (24, 40, 3), dtype=np.uint8)
    left, right = wall[:, :120].copy(), wall[:, FAR : 120 + FAR].copy()
    left[12:36, 60:100] = square
    right[12:36, 60 - NEAR : 100 - NEAR] = square
    truth = np.full((48, 120), FAR, dtype=np.float32)
    truth[12:36, 60:100] = NEAR
    is_hidden = np.zeros(truth.shape, dtype=bool)
    is_hidden[12:36, 60 - (NEAR - FAR) : 60] = True
    is_hidden[:, :FAR] = True
    return left, right, truth, is_hidden


def matcher(method, **kwargs):
    config = StereoMatcherConfig(method=method, num_disparities=32, support_rows=1)
    return StereoMatcher(config, **kwargs)


@pytest.mark.parametrize("method", METHODS)
def test_a_square_before_a_wall_is_found_to_half_a_pixel(method, pair):
    left, right, truth, is_hidden = pair
    found = matcher(method).match(left, right)
    assert found.dtype == np.float32 and found.shape == truth.shape
    inner = ~is_hidden & (np.abs(np.arange(120) - 98) > 12)  # off the edges
    share = np.mean(np.abs(found - truth)[inner] <= 0.5)
    assert share > (0.75 if method == "bm" else 0.95)


@pytest.mark.parametrize("method", METHODS)
def test_number_of_threads_and_pairs_before_change_nothing(method, pair):
    left, right, _, _ = pair
    first = matcher(method)
    one = first.match(left, right)
    first.match(right[:, ::-1], left[:, ::-1])
    again = first.match(left, right)
    two = matcher(method, num_threads=2).match(left, right)
    assert np.array_equal(one, again, equal_nan=True)
    assert np.array_equal(one, two, equal_nan=True)


def test_images_of_two_shapes_or_kinds_are_refused():
    image = np.zeros((20, 40, 3), np.uint8)
    with pytest.raises(ValueError, match="one shape"):
        matcher("interval_dp").match(image, image[:, :30])
    with pytest.raises(ValueError, match="uint8"):
        matcher("interval_dp").match(image, image.astype(float))
    with pytest.raises(ValueError, match="H, W"):
        matcher("interval_dp").match(image[..., :2], image[..., :2])


def test_odd_numbers_of_disparities_are_refused():
    with pytest.raises(ValueError, match="multiple of 16"):
        StereoMatcherConfig(num_disparities=40)
    with pytest.raises(ValueError, match="odd"):
        StereoMatcherConfig(support_rows=4)
