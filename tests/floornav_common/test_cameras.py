"""The laws that every kind of camera keeps, upright and tilted, at any size."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_builders import (
    CAMERAS,
    RADII,
    bent_camera,
    fisheye_camera,
    parabolic_camera,
    table_camera,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.cameras.central import LOOKS, CentralCamera, optical_axes
from floornav_common.cameras.hyperboloidal_mirror import MirrorCamera, paper_camera
from floornav_common.cameras.radius_table import RadiusTableCamera
from floornav_common.cameras.unified import UnifiedCamera
from floornav_common.floor_camera import FloorCamera

TOL_PX = 1e-6
TOL_RAY = 1e-9
KINDS = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS.keys())
TILTS = st.floats(-0.15, 0.15)


def seen_pixels(camera: CentralCamera, count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pixels = rng.uniform((0, 0), (camera.width_px - 1, camera.height_px - 1), (20 * count, 2))
    return pixels[camera.sees(pixels)][:count]


def by_steps(function, at: np.ndarray, step: float) -> np.ndarray:
    """Return d(function)/d(at) by central differences, last axis = component of `at`."""
    columns = []
    for k in range(at.shape[-1]):
        delta = np.zeros(at.shape[-1])
        delta[k] = step
        columns.append((function(at + delta) - function(at - delta)) / (2.0 * step))
    return np.stack(columns, axis=-1)


@KINDS
def test_rays_have_length_one_and_come_back_to_their_pixels(camera: CentralCamera) -> None:
    pixels = seen_pixels(camera, 400)
    rays = camera.rays(pixels)
    assert len(pixels) == 400
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1.0, atol=TOL_RAY)
    for distance in (0.01, 1.0, 100.0):
        assert np.allclose(camera.project(distance * rays), pixels, atol=TOL_PX)


@KINDS
def test_points_come_back_as_directions(camera: CentralCamera) -> None:
    points = np.random.default_rng(1).normal(size=(2000, 3))
    pixels = camera.project(points)
    is_seen = np.isfinite(pixels[:, 0])
    assert 50 < is_seen.sum() < 2000
    units = points / np.linalg.norm(points, axis=-1, keepdims=True)
    assert np.allclose(camera.rays(pixels[is_seen]), units[is_seen], atol=TOL_RAY)
    assert camera.sees(pixels[is_seen]).all()


@KINDS
def test_projection_jacobian_is_its_finite_difference(camera: CentralCamera) -> None:
    pixels = seen_pixels(camera, 200)
    points = 2.0 * camera.rays(pixels)
    expected = by_steps(camera.project, points, 1e-6)
    is_inner = np.isfinite(expected).all(axis=(-1, -2))
    assert is_inner.sum() > 150
    J = camera.project_jacobian(points)
    scale = np.abs(expected[is_inner]).max()
    assert np.allclose(J[is_inner], expected[is_inner], atol=1e-6 * scale)


@KINDS
def test_jacobian_at_the_optical_axis_is_finite_and_right(camera: CentralCamera) -> None:
    axis = camera.rays(np.array(camera.center_px))
    expected = by_steps(camera.project, axis, 1e-6)
    J = camera.project_jacobian(axis)
    assert np.allclose(J, expected, atol=2e-4 * np.abs(expected).max())


@KINDS
def test_any_leading_shape_does_and_gives_the_same(camera: CentralCamera) -> None:
    pixels = seen_pixels(camera, 24)
    for shape in ((24,), (4, 6), (2, 3, 4)):
        rays = camera.rays(pixels.reshape(*shape, 2))
        assert rays.shape == (*shape, 3)
        assert camera.project(rays).shape == (*shape, 2)
        assert camera.project_jacobian(rays).shape == (*shape, 2, 3)
        assert camera.sees(pixels.reshape(*shape, 2)).shape == shape
        assert np.allclose(rays.reshape(-1, 3), camera.rays(pixels), atol=TOL_RAY)
    assert camera.rays(pixels[0]).shape == (3,)


@KINDS
def test_another_size_sees_the_same_world(camera: CentralCamera) -> None:
    scale = 1.5
    large = camera.resized(round(scale * camera.width_px), round(scale * camera.height_px))
    pixels = seen_pixels(camera, 100)
    there = (pixels + 0.5) * scale - 0.5  # cv2.resize
    assert np.allclose(large.rays(there), camera.rays(pixels), atol=TOL_RAY)
    assert large.sees(there).all()


@KINDS
def test_pixels_outside_the_image_are_not_seen(camera: CentralCamera) -> None:
    outside = np.array([[-1.0, 5.0], [5.0, -1.0], [camera.width_px, 5.0], [5.0, camera.height_px]])
    assert not camera.sees(outside).any()
    assert not camera.sees(np.array([[np.nan, 3.0]])).any()


@settings(max_examples=25)
@given(roll=TILTS, pitch=TILTS, yaw=st.floats(-3.0, 3.0), height=st.floats(0.05, 3.0))
@pytest.mark.parametrize("name", CAMERAS)
def test_floor_points_come_back_under_any_tilt(
    name: str, roll: float, pitch: float, yaw: float, height: float
) -> None:
    floor = FloorCamera(CAMERAS[name], height, roll, pitch, yaw)
    pixels = seen_pixels(floor.camera, 200)
    points = floor.floor_points(pixels)
    is_near = np.hypot(points[:, 0], points[:, 1]) < 30.0 * height
    assert is_near.any()
    assert np.allclose(floor.floor_pixels(points[is_near]), pixels[is_near], atol=1e-5)


@settings(max_examples=25)
@given(roll=TILTS, pitch=TILTS, yaw=st.floats(-3.0, 3.0))
@pytest.mark.parametrize("name", CAMERAS)
def test_floor_jacobian_is_its_finite_difference(
    name: str, roll: float, pitch: float, yaw: float
) -> None:
    floor = FloorCamera(CAMERAS[name], 0.8, roll, pitch, yaw)
    pixels = seen_pixels(floor.camera, 100)
    points = floor.floor_points(pixels)
    pixels = pixels[np.hypot(points[:, 0], points[:, 1]) < 8.0]
    expected = by_steps(floor.floor_points, pixels, 1e-4)
    is_inner = np.isfinite(expected).all(axis=(-1, -2))
    if isinstance(floor.camera, RadiusTableCamera):  # df/dR has corners at the knots
        R = np.hypot(*(pixels - floor.center_px).T)
        is_inner &= np.abs(R[:, None] - np.array(RADII)).min(axis=1) > 0.01
    J = floor.floor_jacobian(pixels)[is_inner]
    size = np.abs(expected[is_inner]).max(axis=(-1, -2), keepdims=True)
    assert (np.abs(J - expected[is_inner]) <= 1e-4 * size).all()


@pytest.mark.parametrize("name", ["mirror", "mirror_turned", "unified", "table"])
def test_radial_scale_is_the_slope_of_the_floor_distance(name: str) -> None:
    floor = FloorCamera(CAMERAS[name], 0.3)
    # Each ray falls: none of these cameras sees the horizon nearer than 0.9 of its edge.
    R = np.linspace(1.0, 0.9 * (106.0 if floor.width_px == 256 else 350.0), 41)
    step = 1e-4
    expected = (floor.floor_distance(R + step) - floor.floor_distance(R - step)) / (2.0 * step)
    assert np.allclose(floor.radial_scale(R), expected, rtol=1e-6)
    assert (np.diff(floor.floor_distance(R)) > 0.0).all()


def test_the_papers_camera_gives_equation_26_and_its_slope() -> None:
    mirror = paper_camera()
    floor = FloorCamera(mirror, mirror.viewpoint_height)
    R = np.array([60.0, 80.0, 100.0, 105.0, 110.0])
    assert np.allclose(floor.floor_distance(R), [0.30, 0.58, 1.62, 2.61, 6.20], atol=0.006)
    assert np.allclose(floor.floor_distance(R), mirror.floor_distance(R))
    assert np.allclose(floor.radial_scale(R), mirror.floor_slope(R))


def test_a_mirror_above_a_camera_shows_front_right_and_left_below() -> None:
    for camera in (paper_camera(), parabolic_camera(), table_camera()):
        floor = FloorCamera(camera, 0.2)
        center = np.array(floor.center_px)
        forward, left = floor.floor_pixels(np.array([[0.3, 0.0], [0.0, 0.3]])) - center
        assert forward[0] > 10.0 and forward[1] == pytest.approx(0.0, abs=TOL_PX)
        assert left[1] > 10.0 and left[0] == pytest.approx(0.0, abs=TOL_PX)


def test_a_lens_that_looks_down_shows_the_left_above() -> None:
    floor = FloorCamera(replace(fisheye_camera(), fy_px=140.0), 0.5)
    forward, left = floor.floor_pixels(np.array([[0.5, 0.0], [0.0, 0.5]])) - floor.center_px
    assert forward[0] > 10.0 and left[1] < -10.0


def test_a_forward_lens_pitched_down_sees_the_floor_below_the_middle() -> None:
    floor = FloorCamera(replace(fisheye_camera(), looks="forward"), 1.0, 0.0, math.radians(45.0))
    # By hand: 45 degrees down from 1 m meet the floor 1 m ahead; left is left in the image.
    assert np.allclose(floor.floor_points(np.array(floor.center_px)), (1.0, 0.0), atol=1e-12)
    assert floor.floor_pixels(np.array([1.0, 0.5]))[0] < floor.center_px[0]
    assert floor.floor_pixels(np.array([3.0, 0.0]))[1] < floor.center_px[1]


def test_a_yawed_camera_turns_the_floor() -> None:
    camera = parabolic_camera()
    pixels = seen_pixels(camera, 50)
    straight = FloorCamera(camera, 0.6).floor_points(pixels)
    turned = FloorCamera(camera, 0.6, yaw_rad=math.pi / 2.0).floor_points(pixels)
    is_floor = np.isfinite(straight[:, 0])
    assert is_floor.any()
    quarter = np.stack((-straight[:, 1], straight[:, 0]), -1)
    assert np.allclose(turned[is_floor], quarter[is_floor])


def test_height_scales_the_floor() -> None:
    low, high = FloorCamera(bent_camera(), 0.5), FloorCamera(bent_camera(), 1.5)
    pixels = seen_pixels(low.camera, 100)
    points = low.floor_points(pixels)
    is_floor = np.isfinite(points[:, 0])
    assert is_floor.any()
    assert np.allclose(3.0 * points[is_floor], high.floor_points(pixels)[is_floor])


def test_the_horizon_and_the_unseen_are_told_apart() -> None:
    floor = FloorCamera(parabolic_camera(), 0.6)
    # A parabola's horizon: rho = 1, so R = 360.
    pixels = np.array([[640.0 + R, 512.0] for R in (350.0, 359.9, 360.1, 399.0, 401.0)])
    points = floor.floor_points(pixels)
    assert (
        np.isfinite(points[:2]).all() and np.isinf(points[2:4]).all() and np.isnan(points[4]).all()
    )
    assert np.isnan(floor.floor_jacobian(pixels[2:])).all()
    assert floor.floor_distance(np.array([380.0, 401.0])).tolist()[0] == math.inf
    assert floor.radial_scale(380.0) == math.inf and np.isnan(floor.radial_scale(401.0))


def test_masks_say_what_is_seen_and_what_is_floor() -> None:
    floor = FloorCamera(paper_camera(), 0.205).resized(128, 110)
    seen, near = floor.seen_mask(), floor.floor_mask(1.0)
    assert seen.shape == near.shape == (110, 128)
    assert seen.sum() == pytest.approx(math.pi * 55.0**2, rel=0.01)
    assert near[55, 64] and not near[0, 0] and (near <= seen).all()
    R = float(paper_camera().resized(128, 110).floor_radius(1.0))
    assert near.sum() == pytest.approx(math.pi * R**2, rel=0.01)


def test_a_tilted_camera_has_no_radial_law() -> None:
    with pytest.raises(ValueError, match="upright"):
        FloorCamera(paper_camera(), 0.2, 0.01).floor_distance(50.0)
    with pytest.raises(ValueError, match="upright"):
        FloorCamera(bent_camera(), 0.2).radial_scale(50.0)


def test_a_parabola_without_bend_is_eq_26_with_xi_one() -> None:
    # By hand: rho = 2 tan(theta / 2) / 2: straight sideways (theta = 90 deg) at R = f.
    camera = parabolic_camera()
    assert np.allclose(camera.project(np.array([1.0, 0.0, 0.0])), (640.0 + 360.0, 512.0))
    at_45 = camera.project(np.array([1.0, 0.0, -1.0]))
    assert at_45[0] - 640.0 == pytest.approx(360.0 * math.tan(math.radians(22.5)))


def test_every_hyperbolic_mirror_is_a_unified_camera() -> None:
    """Eq. 26 and the sphere are one: xi = H B sqrt(C) / (H A), f = C / (H A), by image_radius."""
    mirror = paper_camera()
    H = 1000.0 * mirror.viewpoint_height
    ha, hb = H * mirror.a_px_per_mm, H * mirror.b_per_mm * math.sqrt(mirror.c_px2)
    # R = C c / (HA s + hb): over the sphere x / (z + xi) with xi = hb / HA.
    unified = UnifiedCamera(
        width_px=256, height_px=220, xi=hb / ha, fx_px=mirror.c_px2 / ha, fy_px=mirror.c_px2 / ha,
        center_u_px=127.5, center_v_px=109.5, max_radius_px=110.0,
    )  # fmt: skip
    pixels = seen_pixels(mirror, 300)
    assert np.allclose(unified.rays(pixels), mirror.rays(pixels), atol=1e-9)


def test_the_fisheye_is_that_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    camera = replace(fisheye_camera(), looks="forward")
    points = np.random.default_rng(2).uniform((-2, -1.5, 0.5), (2, 1.5, 3), (200, 3))
    K = np.array([[140.0, 0.0, 322.0], [0.0, 141.0, 238.0], [0.0, 0.0, 1.0]])
    D = np.array([camera.k1, camera.k2, camera.k3, camera.k4])
    theirs = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), K, D)[0][:, 0]
    ours = camera.project(points @ optical_axes("forward").T)
    is_seen = np.isfinite(ours[:, 0])
    assert is_seen.sum() > 100
    assert np.allclose(ours[is_seen], theirs[is_seen], atol=1e-6)


def test_a_pinhole_with_bend_is_that_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    camera = replace(bent_camera(), xi=0.0, skew_px=0.0, looks="forward", max_radius_px=0.0)
    points = np.random.default_rng(3).uniform((-1, -1, 1), (1, 1, 3), (200, 3))
    K = np.array([[355.0, 0.0, 640.0], [0.0, 362.0, 512.0], [0.0, 0.0, 1.0]])
    D = np.array([camera.k1, camera.k2, camera.p1, camera.p2])
    theirs = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, D)[0][:, 0]
    ours = camera.project(points @ optical_axes("forward").T)
    is_seen = np.isfinite(ours[:, 0])
    assert is_seen.sum() > 100
    assert np.allclose(ours[is_seen], theirs[is_seen], atol=1e-6)


def test_the_table_gives_its_own_entries() -> None:
    camera = table_camera()
    floor = FloorCamera(camera, camera.measured_height_m)
    assert np.allclose(floor.floor_distance(np.array(RADII)), camera.distances_m)
    assert np.isnan(floor.floor_distance(108.5))
    # Between them it is nearer to eq. 26 than a pixel's blur: 2 %.
    R = np.linspace(25.0, 105.0, 30)
    assert np.allclose(floor.floor_distance(R), paper_camera().floor_distance(R), rtol=0.02)


def test_axes_are_turns_and_only_the_mirror_reflects() -> None:
    for looks in LOOKS:
        axes = optical_axes(looks)
        assert np.allclose(axes @ axes.T, np.eye(3))
        assert np.linalg.det(axes) == pytest.approx(-1.0 if looks == "mirror_above" else 1.0)
    with pytest.raises(ValueError, match="sideways"):
        optical_axes("sideways")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: replace(fisheye_camera(), k1=-0.5), "fold"),
        (lambda: replace(fisheye_camera(), looks="left"), "looks"),
        (lambda: replace(parabolic_camera(), xi=-0.1), "xi"),
        (lambda: replace(parabolic_camera(), fx_px=math.nan), "fx_px"),
        (lambda: replace(table_camera(), radii_px=RADII[:3]), "one length"),
        (lambda: replace(table_camera(), radii_px=RADII[::-1]), "radii_px must grow"),
        (lambda: replace(table_camera(), distances_m=(1.0,) * 6), "distances_m must grow"),
        (lambda: FloorCamera(paper_camera(), 0.0), "height_m"),
        (lambda: FloorCamera(paper_camera(), 0.2, math.nan), "finite"),
        (lambda: MirrorCamera(**{**paper_camera().__dict__, "c_px2": -1.0}), "c_px2"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(make, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        make()
