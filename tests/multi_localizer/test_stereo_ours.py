import numpy as np

from multi_localizer.stereo_config import StereoMatcherConfig
from multi_localizer.stereo_matcher import StereoMatcher


def matched(left, right, **settings):
    config = StereoMatcherConfig(method="ours", num_disparities=32, **settings)
    return StereoMatcher(config).match(left, right)


def wall_of_noise(shift, seed=0):
    wall = np.random.default_rng(seed).integers(0, 256, (40, 140), dtype=np.uint8)
    return wall[:, :120].copy(), wall[:, shift : 120 + shift].copy()


def test_columns_whose_partner_is_outside_are_holes_or_filled():
    left, right = wall_of_noise(9)
    assert np.isnan(matched(left, right)[:, :9]).mean() > 0.95
    filled = matched(left, right, fill_holes=True)
    assert np.all(np.abs(filled - 9.0) <= 0.5)


def test_columns_added_for_the_search_change_what_is_found_nowhere():
    left, right = wall_of_noise(9)
    wide = [np.pad(image, ((0, 0), (32, 0)), mode="edge") for image in (left, right)]
    found = matched(*wide)[:, 32:]
    assert np.isnan(found[:, :9]).mean() > 0.95
    assert np.all(np.abs(matched(*wide, fill_holes=True)[:, 32:] - 9.0) <= 0.5)


def test_a_plain_stripe_takes_the_distance_of_the_texture_above_it():
    left, right = wall_of_noise(9)
    for image in (left, right):
        image[18:22] = 128
    assert np.abs(matched(left, right)[18:22, 20:] - 9.0).mean() <= 0.5


def test_half_a_pixel_is_found():
    wall = np.random.default_rng(1).integers(0, 256, (40, 70)).astype(float)
    fine = np.repeat(wall, 4, axis=1)  # soft texture, sampled at every second column
    fine = sum(np.roll(fine, k, axis=1) for k in range(6)) / 6.0
    left, right = (fine[:, start : start + 240 : 2].astype(np.uint8) for start in (0, 15))
    found = matched(left, right)[:, 20:-10]
    assert np.isnan(found).mean() < 0.05
    assert abs(float(np.nanmean(found)) - 7.5) < 0.15
