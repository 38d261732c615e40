"""Eq. 26 by hand, its inverse and slope, the viewpoint, handedness and sizes."""

import math

import numpy as np
import pytest

from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera, paper_camera

TOL_PX = 1e-6
CAMERA = paper_camera()


def test_floor_distances_are_those_of_equation_26() -> None:
    # By hand: R = 60: 60 / (10.12 - 0.02054 sqrt(233400)) mm, and the reading notes' 5 figures.
    by_hand = 60.0 / (10.12 - 0.02054 * math.sqrt(233400.0)) / 1000.0
    assert CAMERA.floor_distance(60.0) == pytest.approx(by_hand)
    seen = CAMERA.floor_distance(np.array([60.0, 80.0, 100.0, 105.0, 110.0]))
    assert np.allclose(seen, [0.30, 0.58, 1.62, 2.61, 6.20], atol=0.006)


def test_viewpoint_is_205_mm_above_the_floor_and_the_edge_below_the_horizon() -> None:
    assert CAMERA.viewpoint_height == pytest.approx(0.205, abs=0.0005)
    assert CAMERA.horizon_radius == pytest.approx(113.8, abs=0.05)
    assert math.degrees(CAMERA.elevation(110.0)) == pytest.approx(-1.9, abs=0.05)


def test_all_rays_meet_in_the_viewpoint() -> None:
    R = np.linspace(1.0, 110.0, 50)
    drop = CAMERA.floor_distance(R) * np.tan(-CAMERA.elevation(R))
    assert np.allclose(drop, CAMERA.viewpoint_height)


def test_radius_and_elevation_are_inverse_also_above_the_horizon() -> None:
    R = np.linspace(0.0, 150.0, 301)
    assert np.allclose(CAMERA.image_radius(CAMERA.elevation(R)), R, atol=TOL_PX)
    distances = np.array([0.01, 0.3, 2.0, 50.0])
    assert np.allclose(CAMERA.floor_distance(CAMERA.floor_radius(distances)), distances)


def test_nothing_of_the_floor_is_seen_beyond_the_horizon() -> None:
    assert CAMERA.floor_distance(120.0) == math.inf
    assert CAMERA.elevation(120.0) > 0.0


def test_forward_is_right_in_the_image_and_left_is_down() -> None:
    u, v = CAMERA.project(np.array([[1.0, 0.0, -0.2], [0.0, 1.0, -0.2]])).T
    assert u[0] > CAMERA.center_u_px and v[0] == pytest.approx(CAMERA.center_v_px)
    assert u[1] == pytest.approx(CAMERA.center_u_px) and v[1] > CAMERA.center_v_px


def test_projection_brings_rays_back() -> None:
    rng = np.random.default_rng(0)
    R, bearing = 110.0 * np.sqrt(rng.random(200)), rng.uniform(-math.pi, math.pi, 200)
    pixels = CAMERA.center_px + R[:, None] * np.stack((np.cos(bearing), np.sin(bearing)), -1)
    turned = MirrorCamera(**{**CAMERA.__dict__, "rotation_rad": 0.7})
    for camera in (CAMERA, turned):
        assert np.allclose(camera.project(3.0 * camera.rays(pixels)), pixels, atol=TOL_PX)


def test_another_size_shows_the_same_picture() -> None:
    large = CAMERA.resized(640, 480)
    s = 480 / 220
    assert (large.center_u_px, large.center_v_px) == (319.5, 239.5)
    assert large.viewpoint_height == pytest.approx(CAMERA.viewpoint_height)
    assert large.floor_distance(80.0 * s) == pytest.approx(CAMERA.floor_distance(80.0))


def test_a_camera_without_viewpoint_is_refused() -> None:
    with pytest.raises(ValueError, match="viewpoint"):
        MirrorCamera(**{**CAMERA.__dict__, "a_px_per_mm": 9.0})


def test_the_slope_of_equation_26_is_its_finite_difference() -> None:
    R = np.linspace(1.0, 112.0, 60)
    step = 1e-4
    by_steps = (CAMERA.floor_distance(R + step) - CAMERA.floor_distance(R - step)) / (2 * step)
    assert np.allclose(CAMERA.floor_slope(R), by_steps, rtol=1e-6)
    # By hand at the notes' radii, m per pixel.
    by_hand = [0.009, 0.022, 0.126, 0.31, 1.66]
    seen = CAMERA.floor_slope(np.array([60.0, 80.0, 100.0, 105.0, 110.0]))
    assert np.allclose(seen, by_hand, rtol=0.06)


def test_what_is_off_the_mirror_has_no_pixel() -> None:
    up, over = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.5])
    assert np.isnan(CAMERA.project(np.stack((up, over)))).all()
    assert CAMERA.sees(np.array([[127.5, 109.5], [127.5 + 110.5, 109.5]])).tolist() == [True, False]
