"""Pose from the border of the floor region, beyond the published steps."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from floor_masks import alcoves, ell, first_wall, mask_of, rectangle, small_camera
from scipy.stats import chi2

from floornav_common.calibration import calibration_of
from floornav_common.camera_files import load_camera_model
from floornav_common.floor_camera import FloorCamera
from floornav_common.se2 import SE2
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_fitter import CLEAR_COST, FloorShapeFitter
from multi_localizer.floor_plan import FloorPlan, load_plan
from multi_localizer.floor_rays import rays_of_pixels
from multi_localizer.pose_estimate import PoseEstimate, difference

TOL_M, TOL_RAD = 0.008, math.radians(0.4)
CAMERA = small_camera()


@lru_cache
def fitter_of(name: str) -> FloorShapeFitter:
    plans = {"rectangle": rectangle(2.74, 1.525), "ell": ell(), "alcoves": alcoves()}
    plan = plans[name] if name in plans else load_plan(name)
    return FloorShapeFitter(CAMERA, plan)


def nearest(fit, truth):
    assert fit.problem == ""
    return min((np.abs(difference(c.pose, truth)) for c in fit.candidates), key=lambda e: e[2])


def assert_found(fit, truth):
    x, y, yaw = nearest(fit, truth)
    assert max(x, y) < TOL_M and yaw < TOL_RAD


def random_poses(plan: FloorPlan, num: int, seed: int) -> list[SE2]:
    rng = np.random.default_rng(seed)
    low, high = plan.corners.min(axis=0), plan.corners.max(axis=0)
    found: list[SE2] = []
    while len(found) < num:
        x, y = (float(p) for p in rng.uniform(low, high))
        turns = np.linspace(0.0, 2.0 * math.pi, 12)
        if all(plan.contains(x + 0.2 * math.cos(t), y + 0.2 * math.sin(t)) for t in turns):
            found.append(SE2(x, y, float(rng.uniform(-math.pi, math.pi))))
    return found


@pytest.mark.parametrize("name", ["rectangle", "small_size_field", "ell"])
def test_any_pose_is_found_without_a_guess(name):
    fitter = fitter_of(name)
    for pose in random_poses(fitter.plan, 12, 1):
        assert_found(fitter.fit(mask_of(CAMERA, fitter.plan, pose)), pose)


def test_a_symmetric_floor_gives_both_poses_and_an_ell_one():
    pose = SE2(0.3, -0.2, 0.5)
    field, room = fitter_of("small_size_field"), fitter_of("ell")
    both = field.fit(mask_of(CAMERA, field.plan, pose)).candidates
    assert len(both) == 2
    mate = field.plan.symmetries[1] @ both[0].pose
    assert np.abs(difference(both[1].pose, mate)).max() < 1e-9
    corner = SE2(-0.5, -0.3, 0.5)
    assert len(room.fit(mask_of(CAMERA, room.plan, corner)).candidates) == 1


def test_a_mates_covariance_is_turned_with_it():
    fitter, pose = FloorShapeFitter(CAMERA, rectangle(1.6, 1.6)), SE2(0.3, 0.1, 0.4)
    fit = fitter.fit(mask_of(CAMERA, fitter.plan, pose))
    assert len(fit.candidates) == 4
    for motion, c in zip(fitter.plan.symmetries, fit.candidates, strict=True):
        turn = np.eye(3)
        turn[:2, :2] = [
            [math.cos(motion.yaw), -math.sin(motion.yaw)],
            [math.sin(motion.yaw), math.cos(motion.yaw)],
        ]
        assert c.cov == pytest.approx(turn @ fit.candidates[0].cov @ turn.T)


def test_posts_that_hide_a_third_of_the_border_move_nothing():
    fitter, pose = fitter_of("small_size_field"), SE2(0.2, 0.1, 1.0)
    posts = tuple(
        (pose.x + 0.4 * math.cos(a), pose.y + 0.4 * math.sin(a), 0.1) for a in (0.2, 1.7, 3.0, 4.4)
    )
    fit = fitter.fit(mask_of(CAMERA, fitter.plan, pose, posts))
    assert fit.hidden_share > 0.3
    assert_found(fit, pose)


def test_a_border_that_lies_inside_everywhere_is_an_offset_not_a_pose():
    """Pixels that are part wall are no floor to a detector of color."""
    fitter, pose = fitter_of("small_size_field"), SE2(0.6, 0.2, 0.3)
    mask = mask_of(CAMERA, fitter.plan, pose)
    inner = mask.copy()
    for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
        inner &= np.roll(mask, shift, axis)
    fit = fitter.fit(inner)
    assert 0.6 < fit.offset_px < 1.3
    x, y, yaw = nearest(fit, pose)
    assert max(x, y) < 0.015 and yaw < TOL_RAD


def test_a_guess_leads_there_where_the_border_says_little():
    fitter, pose = fitter_of("rectangle"), SE2(0.4, 0.1, 0.7)
    mask = mask_of(CAMERA, fitter.plan, pose)
    fit = fitter.fit(mask, PoseEstimate(SE2(0.45, 0.06, 0.75), np.diag([0.01, 0.01, 0.01])))
    assert np.abs(difference(fit.candidates[0].pose, pose)).max() < 0.01
    far_off = PoseEstimate(SE2(-1.0, -0.4, -2.0), np.diag([1e-4, 1e-4, 1e-4]))
    assert_found(fitter.fit(mask, far_off), pose)  # carried away


def test_a_camera_beside_the_middle_gives_the_pose_of_the_base():
    offset, base = (0.05, -0.02), SE2(0.2, 0.1, 2.0)
    camera = FloorCamera(CAMERA.camera, CAMERA.height_m, position_m=offset)
    fitter = FloorShapeFitter(camera, rectangle(2.74, 1.525))
    seen_from = base @ SE2(*offset, 0.0)
    assert_found(fitter.fit(mask_of(CAMERA, fitter.plan, seen_from)), base)


def test_a_tilted_camera_is_none_the_worse():
    camera = replace(CAMERA, roll_rad=0.02, pitch_rad=-0.03)
    fitter, pose = FloorShapeFitter(camera, rectangle(2.0, 1.6)), SE2(0.2, 0.1, 1.0)
    assert_found(fitter.fit(mask_of(camera, fitter.plan, pose)), pose)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda m: np.zeros_like(m), "border are seen"),
        (lambda m: np.full_like(m, 255), "border are seen"),
    ],
)
def test_a_mask_that_is_none_gives_no_pose(change, word):
    fitter = fitter_of("small_size_field")
    fit = fitter.fit(change(mask_of(CAMERA, fitter.plan, SE2(0.1, 0.0, 0.2))))
    assert fit.candidates == () and word in fit.problem and fit.problem


def test_another_floor_gives_no_pose():
    """A robot that was carried to a round place."""
    fitter = fitter_of("small_size_field")
    angles = np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)
    circle = FloorPlan(0.6 * np.stack((np.cos(angles), np.sin(angles)), axis=-1))
    for place in (SE2(0.0, 0.0, 0.3), SE2(0.2, 0.0, 0.0)):
        fit = fitter.fit(mask_of(CAMERA, circle, place))
        assert fit.problem and fit.candidates == ()


def test_a_second_blob_of_floor_outside_does_no_harm():
    fitter, pose = fitter_of("small_size_field"), SE2(0.5, 0.2, 0.0)
    mask = mask_of(CAMERA, fitter.plan, pose)
    v, u = np.mgrid[:220, :256]
    far = np.hypot(u - CAMERA.center_px[0], v - CAMERA.center_px[1])
    # The end wall is seen there at 101 px.
    blob = (far > 103.0) & (far < 106.0) & (np.arctan2(v - 109.5, u - 127.5) > 2.6)
    fit = fitter.fit(np.where(blob, 255, mask).astype(np.uint8))
    assert_found(fit, pose)


def test_border_of_known_noise_is_fitted_as_well_as_can_be():
    """Errors and covariances agree: the mean NEES lies within its 99.9 % band."""
    sd, num = 0.3, 60
    config = FloorFitConfig(border_sd_px=sd, offset_sd_px=0.0, wall_sd_px=0.0)
    plan = rectangle(2.74, 1.525)
    fitter, rng, nees = FloorShapeFitter(CAMERA, plan, config), np.random.default_rng(0), []
    bearings = np.linspace(-math.pi, math.pi, 400, endpoint=False)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    for pose in random_poses(plan, num, 2):
        r = first_wall(np.array([pose.x, pose.y]), SE2(0.0, 0.0, pose.yaw) @ ways, plan)
        pixels = CAMERA.floor_pixels(ways * r[:, None])
        noisy = pixels + rng.normal(0.0, sd, pixels.shape)
        fit = fitter.fit_border(rays_of_pixels(CAMERA, noisy))
        best = min(fit.candidates, key=lambda c: abs(difference(c.pose, pose)[2]))
        e = difference(best.pose, pose)
        nees.append(float(e @ np.linalg.solve(best.cov, e)))
    low, high = chi2.ppf((0.0005, 0.9995), 3 * num) / num
    assert low < np.mean(nees) < high


def test_the_field_moved_moves_the_pose_with_it():
    motion, pose = SE2(5.0, -3.0, 0.9), SE2(0.2, -0.1, 0.4)
    plan = rectangle(2.74, 1.525)
    moved = FloorPlan(motion @ plan.corners)
    mask = mask_of(CAMERA, plan, pose)
    here = FloorShapeFitter(CAMERA, plan).fit(mask)
    there = FloorShapeFitter(CAMERA, moved).fit(mask)
    want = motion @ min(here.candidates, key=lambda c: abs(c.pose.yaw - pose.yaw)).pose
    assert min(np.abs(difference(c.pose, want)).max() for c in there.candidates) < 1e-4


def test_a_calibration_that_errs_as_it_says_leaves_covariances_true():
    """Centers off by half a pixel: told, the NEES stays in its band; not told, it is far above."""
    sd, num, off_px = 0.3, 40, 0.5
    config = FloorFitConfig(border_sd_px=sd, offset_sd_px=0.0, wall_sd_px=0.0)
    plan, rng = rectangle(2.74, 1.525), np.random.default_rng(0)
    one = dict(zip(("center_u_px", "center_v_px"), np.eye(2), strict=True))
    calibration = calibration_of(one, off_px**2 * np.eye(2))
    bearings = np.linspace(-math.pi, math.pi, 400, endpoint=False)
    ways = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    nees: dict[str, list[float]] = {"told": [], "not told": []}
    for pose in random_poses(plan, num, 2):
        r = first_wall(np.array([pose.x, pose.y]), SE2(0.0, 0.0, pose.yaw) @ ways, plan)
        pixels = CAMERA.floor_pixels(ways * r[:, None])
        noisy = pixels + rng.normal(0.0, sd, pixels.shape)
        u, v = np.array(CAMERA.center_px) + rng.normal(0.0, off_px, 2)
        moved = replace(CAMERA.camera, center_u_px=float(u), center_v_px=float(v))
        for name, known in (("told", calibration), ("not told", None)):
            camera = replace(CAMERA, camera=moved, calibration=known)
            fitter = FloorShapeFitter(camera, plan, config)
            fit = fitter.fit_border(rays_of_pixels(camera, noisy))
            best = min(fit.candidates, key=lambda c: abs(difference(c.pose, pose)[2]))
            e = difference(best.pose, pose)
            nees[name].append(float(e @ np.linalg.solve(best.cov, e)))
    low, high = chi2.ppf((0.0005, 0.9995), 3 * num) / num
    assert low < np.mean(nees["told"]) < high
    assert np.mean(nees["not told"]) > 2.0 * high


def test_a_guess_far_from_what_fits_does_not_keep_rivals_from_being_looked_for(monkeypatch):
    """Half the border hidden: without a guess that is followed the whole plan is searched."""
    fitter, pose = fitter_of("rectangle"), SE2(0.3, 0.1, 0.5)
    posts = tuple(
        (pose.x + 0.3 * math.cos(a), pose.y + 0.3 * math.sin(a), 0.1) for a in (0.2, 1.7, 3.0, 4.4)
    )
    mask, searched = mask_of(CAMERA, fitter.plan, pose, posts), []
    starts = fitter.search.starts
    monkeypatch.setattr(
        fitter.search, "starts", lambda values: (searched.append(1), starts(values))[1]
    )
    cov = np.diag([0.01, 0.01, 0.01]) ** 2
    fitter.fit_border(fitter.scanner.scan(mask), PoseEstimate(pose, cov))
    assert searched == []
    fitter.fit_border(fitter.scanner.scan(mask), PoseEstimate(SE2(-0.9, -0.4, 2.0), cov))
    fitter.fit_border(fitter.scanner.scan(mask))
    assert searched == [1, 1]


@pytest.mark.parametrize("x", [3.39, 4.40, 5.28])
def test_places_that_look_alike_are_all_candidates_however_well_they_fit(x):
    fitter, pose = fitter_of("alcoves"), SE2(x, 1.38, 0.4)
    fit = fitter.fit(mask_of(CAMERA, fitter.plan, pose))
    assert fit.costs[0] < CLEAR_COST and len(fit.candidates) >= 2
    apart = [c.pose.x - fit.candidates[0].pose.x for c in fit.candidates]
    assert np.abs(np.array(apart) - np.round(apart)).max() < 0.02  # alcoves are 1 m apart


def test_the_whole_border_tells_a_nearly_square_rooms_poses_apart():
    """Of few pieces of border a quarter turn fits nearly as well, of all of them it does not."""
    fitter = FloorShapeFitter(CAMERA, rectangle(2.0, 1.95))
    for pose in random_poses(fitter.plan, 12, 3):
        fit = fitter.fit(mask_of(CAMERA, fitter.plan, pose))
        assert len(fit.candidates) == 2
        assert_found(fit, pose)


def test_with_a_quarter_hidden_what_fits_worse_by_far_stays_a_candidate():
    fitter, pose = FloorShapeFitter(CAMERA, rectangle(2.0, 1.7)), SE2(0.2, 0.1, 0.5)
    posts = tuple(
        (pose.x + 0.4 * math.cos(a), pose.y + 0.4 * math.sin(a), 0.1) for a in (0.2, 2.3, 4.4)
    )
    fit = fitter.fit(mask_of(CAMERA, fitter.plan, pose, posts))
    assert fit.costs[0] > CLEAR_COST and fit.costs[-1] > fit.costs[0] + 0.1
    assert_found(fit, pose)


@pytest.mark.parametrize("size", [(3.1, 1.525), (2.0, 1.0)])
def test_a_border_that_fits_worse_than_nothing_gives_no_pose(size):
    """The best costs over 1: a disk of floor in which no piece of the border is at a wall."""
    plan, camera = rectangle(*size), load_camera_model("soccer_small_size")
    mask = camera.floor_mask(0.3 * plan.reach).astype(np.uint8)
    fit = FloorShapeFitter(camera, plan).fit(mask)
    assert fit.problem and fit.candidates == ()
