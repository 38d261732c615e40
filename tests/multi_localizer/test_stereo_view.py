import numpy as np
import pytest

from multi_localizer.stereo_view import coarser, observe
from multi_localizer.voxel_view import ViewCamera

CAMERA = ViewCamera(4, 4, 20.0, 0.1, 1.0)  # 2 px m
NAN = np.nan


def test_blocks_by_hand():
    disparity = np.full((4, 4), 2.0, dtype=np.float32)  # 1 m
    disparity[0, :2] = 1.0, NAN
    disparity[1, :2] = 4.0, 1.0  # 2, 0.5, 2 m
    disparity[2:, 2:] = NAN
    left = np.zeros((4, 4, 3), dtype=np.uint8)
    left[:2, :2] = (10, 20, 30)
    left[0, 0] = (50, 20, 30)
    view = observe(disparity, left, CAMERA, 100.0, (2, 2))
    assert view.color[0, 0].tolist() == [20.0, 20.0, 30.0]
    assert view.distance[0, 0] == pytest.approx(1.5)
    assert view.inverse[0, 0] == pytest.approx(0.5)
    assert view.distance[0, 1] == pytest.approx(1.0)
    assert np.isnan(view.distance[1, 1]) and np.isnan(view.inverse[1, 1])
    assert view.weight.tolist() == [[0.75, 1.0], [1.0, 0.0]]


def test_nothing_is_farther_than_the_map():
    disparity = np.array([[0.0, 0.001]] * 2, dtype=np.float32)
    camera = ViewCamera(2, 2, 20.0, 0.1, 1.0)
    view = observe(disparity, np.zeros((2, 2, 3), np.uint8), camera, 5.0, (2, 2))
    assert np.allclose(view.distance, 5.0)


def test_the_disparity_of_infinity_is_taken_off():
    camera = ViewCamera(2, 2, 20.0, 0.1, 1.0, disparity_offset_px=-3.0)
    disparity = np.full((2, 2), -1.0, dtype=np.float32)
    view = observe(disparity, np.zeros((2, 2, 3), np.uint8), camera, 5.0, (1, 1))
    assert view.distance[0, 0] == pytest.approx(1.0)


def test_a_coarser_view_is_the_coarser_observation():
    rng = np.random.default_rng(0)
    camera = ViewCamera(320, 240, 276.0, 0.1, 1.0)
    disparity = rng.uniform(5.0, 40.0, (240, 320)).astype(np.float32)
    disparity[rng.random(disparity.shape) < 0.3] = NAN
    left = rng.integers(0, 256, (240, 320, 3), dtype=np.uint8)
    fine = observe(disparity, left, camera, 10.0)
    for size in ((320, 8), (80, 4), (5, 1), (1, 1)):
        direct, made = observe(disparity, left, camera, 10.0, size), coarser(fine, size)
        assert np.allclose(made.color, direct.color, atol=1e-3)
        assert np.allclose(made.distance, direct.distance, atol=1e-4)
        assert np.allclose(made.weight, direct.weight, atol=1e-6)


def test_wrong_matches_do_not_move_the_inverse_distance():
    disparity = np.full((30, 4), 10.0, dtype=np.float32)
    camera = ViewCamera(4, 30, 20.0, 0.1, 1.0)
    left = np.zeros((30, 4, 3), dtype=np.uint8)
    clean = observe(disparity, left, camera, 10.0, (1, 1))
    disparity[:12] = 60.0
    assert observe(disparity, left, camera, 10.0, (1, 1)).inverse == clean.inverse


def test_nothing_seen_stays_nothing():
    view = observe(
        np.full((4, 4), NAN, np.float32), np.zeros((4, 4, 3), np.uint8), CAMERA, 9.0, (2, 2)
    )
    low = coarser(view, (1, 1))
    assert np.isnan(low.distance).all() and np.isnan(low.inverse).all()
    assert low.weight.tolist() == [[0.0]]


def test_what_does_not_fit_is_refused():
    good = np.zeros((4, 4), np.float32), np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(ValueError, match="as the camera's"):
        observe(good[0][:3], good[1], CAMERA, 9.0, (2, 2))
    with pytest.raises(ValueError, match="as the camera's"):
        observe(good[0], good[1][:, :, 0], CAMERA, 9.0, (2, 2))
    with pytest.raises(ValueError, match="at least one column"):
        observe(*good, CAMERA, 9.0, (0, 2))
    with pytest.raises(ValueError, match="must divide"):
        coarser(observe(*good, CAMERA, 9.0, (4, 4)), (3, 1))


@pytest.mark.parametrize("width", [160, 240, 320, 424, 640, 752, 800])
def test_the_middles_of_blocks_are_where_the_rays_through_them_are(width):
    camera = ViewCamera(width, 240, 300.0, 0.1, 1.0)
    left = np.zeros((240, width, 3), dtype=np.uint8)
    left[..., 0], left[..., 1] = np.arange(width) % 256, np.arange(width) // 256
    view = observe(np.full((240, width), 10.0, np.float32), left, camera, 10.0)
    assert view.color.shape == (8, 320, 3)
    seen = view.color[..., 0] + 256.0 * view.color[..., 1]
    asked = camera.center_px[0] - 300.0 * camera.rays(320, 8)[..., 0]
    assert abs(float(np.mean(seen - asked))) < 0.03
    assert np.abs(seen - asked).max() <= 0.51
