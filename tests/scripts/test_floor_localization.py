"""The judge of the floor-shape experiment: what it takes for truth, bounds and failures."""

from __future__ import annotations

import argparse
import math

import numpy as np
import pytest

from experiments import floor_localization, floor_pose_bounds, floor_pose_report
from experiments.floor_pose_bounds import (
    NUM_PAIRS,
    border_pixels,
    bound,
    calibrated,
    calibration_cov,
    camera_of,
    true_mirror,
)
from experiments.floor_pose_drives import Moment, first_right_s, summary
from experiments.floor_pose_runs import Outcome, border_errors, cell, consistency, judge, rms
from experiments.floor_pose_scenes import (
    CUBE_M,
    NEAREST_CUBE_M,
    Cube,
    hidden_share,
    random_cubes,
    scene_hiding,
    wall_distance,
)
from floornav_common.cameras.hyperboloidal_mirror import paper_camera
from floornav_common.floor_camera import FloorCamera
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from multi_localizer.floor_fitter import FloorFit
from multi_localizer.floor_plan import load_plan
from multi_localizer.floor_tracker import TrackState
from multi_localizer.pose_estimate import PoseEstimate

CAMERA = FloorCamera(paper_camera(), paper_camera().viewpoint_height)
PLAN = load_plan("small_size_field")
GRAY = (0.5, 0.5, 0.5)


def test_walls_of_the_field_are_where_the_paper_has_them():
    ways = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    assert wall_distance(np.array([0.5, 0.1]), ways, PLAN) == pytest.approx(
        [1.05, 0.6625, 2.05, 0.8625]
    )
    assert wall_distance(np.array([0.5, 0.4]), ways[:1], PLAN) == pytest.approx([0.87])


def test_a_cube_hides_what_the_eyes_height_lets_it_hide():
    """From 205 mm a cube of 130 mm hides from its near face to 2.73 times as far."""
    pose, height = SE2(0.0, 0.0, 0.0), 0.205
    farther = Cube(SE2(0.0, 0.30, 0.0), GRAY)
    nearer = Cube(SE2(0.0, -0.15, 0.0), GRAY)  # its far edge at 0.215 m hides to 0.587 m only
    widths = [2.0 * math.atan2(CUBE_M / 2.0, 0.30 + s * CUBE_M / 2.0) for s in (1.0, -1.0)]
    share = hidden_share(pose, [farther], PLAN, height)
    assert widths[0] < 2.0 * math.pi * share < widths[1]
    assert hidden_share(pose, [nearer], PLAN, height) == 0.0


def test_cubes_stand_apart_and_hide_the_share_asked_for():
    rng = np.random.default_rng(0)
    for share in (0.0, 0.3, 0.5):
        pose, cubes = scene_hiding(share, PLAN, 0.205, rng)
        assert abs(hidden_share(pose, list(cubes), PLAN, 0.205) - share) <= 0.02
    cubes = random_cubes(SE2(0.0, 0.0, 0.0), 6, PLAN, rng)
    places = np.array([(c.pose.x, c.pose.y) for c in cubes])
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)[np.triu_indices(6, 1)]
    assert apart.min() > CUBE_M * math.sqrt(2.0)
    assert np.hypot(*places.T).min() > NEAREST_CUBE_M


def test_the_mirrors_parameters_make_the_same_camera():
    same = camera_of(true_mirror(CAMERA), CAMERA)
    radii = np.linspace(20.0, 108.0, 9)
    assert same.floor_distance(radii) == pytest.approx(CAMERA.floor_distance(radii), rel=1e-6)


def test_calibrations_scatter_as_their_covariance_says():
    rng, p = np.random.default_rng(0), true_mirror(CAMERA)
    cov, near = calibration_cov(CAMERA), []
    for _ in range(60):
        e = calibrated(CAMERA, rng).parameters - p
        near.append(float(e @ np.linalg.solve(cov, e)))
    assert 2.5 < np.median(near) < 6.5  # 4.4 for five parameters
    assert NUM_PAIRS > 3


def test_true_border_lies_on_the_walls_and_on_the_cubes_feet():
    pose, cube = SE2(0.1, 0.0, 0.4), Cube(SE2(0.1, 0.4, 0.0), GRAY)
    pixels, is_wall = border_pixels(CAMERA, pose, (cube,), PLAN, 200)
    seen = np.isfinite(pixels[:, 0])
    points = pose @ CAMERA.floor_points(pixels[seen])
    gaps = PLAN.offsets - points @ PLAN.normals.T
    on_wall = np.abs(gaps).min(axis=1) < 1e-6
    assert on_wall[is_wall[seen]].all() and not on_wall[~is_wall[seen]].any()
    feet = points[~is_wall[seen]]
    assert np.abs(feet[:, 1] - (0.4 - CUBE_M / 2.0)).max() < 1e-6


def test_the_bound_falls_with_the_noise_and_grows_with_an_unknown_mirror():
    pose = SE2(0.6, 0.1, 0.3)
    pixels, _ = border_pixels(CAMERA, pose, (), PLAN, 300)
    one = bound(CAMERA, pose, pixels, PLAN, 0.3)
    assert bound(CAMERA, pose, pixels, PLAN, 0.6) == pytest.approx(4.0 * one)
    unknown = bound(CAMERA, pose, pixels, PLAN, 0.3, calibration_cov(CAMERA))
    assert np.linalg.eigvalsh(unknown - one).min() > -1e-12
    assert (np.diag(unknown) > np.diag(one)).all()


def test_the_fit_comes_near_the_bound():
    row = border_errors(CAMERA, (0, 0), 12, PLAN, 1000)
    assert row["true_failures"] == 0
    assert all(0.4 < ratio < 1.8 for ratio in row["true_ratio"])


def test_only_the_heading_settles_which_of_the_mates_counts():
    cov = np.diag([1e-4, 1e-4, 1e-4])
    truth = SE2(0.5, 0.1, 3.0)
    right = PoseEstimate(SE2(0.51, 0.1, 3.0), cov)
    mate = PoseEstimate(SE2(-0.51, -0.1, 3.0 - math.pi), cov)
    found = judge(FloorFit((mate, right), 100, 0.3, 0.0, ""), truth)
    assert found.error == pytest.approx([0.01, 0.0, 0.0])
    assert found.nees == pytest.approx(1.0)
    assert not found.has_failed


def test_no_pose_and_a_pose_far_off_are_failures():
    nothing = judge(FloorFit((), 0, math.nan, 1.0, "no floor"), SE2(0.0, 0.0, 0.0))
    far = Outcome(np.array([0.08, 0.08, 0.0]), np.eye(3))
    turned = Outcome(np.array([0.0, 0.0, 0.1]), np.eye(3))
    good = Outcome(np.array([0.03, 0.04, 0.0]), np.eye(3))
    assert [o.has_failed for o in (nothing, far, turned, good)] == [True, True, True, False]
    assert rms([nothing, good]) == pytest.approx([0.03, 0.04, 0.0])
    row = cell((600, 0), [nothing, good])
    assert row["failures"] == 1 and row["rms_x_mm"] == pytest.approx(30.0)
    assert (row["paper_x_mm"], row["paper_y_mm"], row["paper_theta_deg"]) == (41, 16, 2.6)


def test_true_covariances_lie_in_their_band():
    rng = np.random.default_rng(0)
    cov = np.diag([4e-4, 1e-4, 1e-5])
    drawn = [Outcome(rng.multivariate_normal(np.zeros(3), cov), cov) for _ in range(400)]
    found = consistency(drawn)
    assert found["band"][0] < found["mean"] < found["band"][1]
    assert abs(found["share_in_band"] - 0.95) < 0.03


def test_too_few_poses_are_refused():
    with pytest.raises(UserError, match="--poses"):
        floor_localization.check(argparse.Namespace(poses=1))


def test_the_report_needs_no_pose_at_all():
    """A sweep where every pose was refused has NaN for errors, and is told, not hidden."""
    row = {
        "share": 0.6, "rms_m": math.nan, "rms_x_m": math.nan, "rms_y_m": math.nan,
        "rms_theta_deg": math.nan, "failures": 3, "refused": 3, "wrong_and_sure": 0,
        "ambiguous": 0, "poses": 3,
        "published_rms_m": 0.1, "published_failures": 1,
    }  # fmt: skip
    table = floor_pose_report._sweep([row], "share", "share hidden")
    assert table.rows[0][5:9] == [3, 3, 0, 0]
    assert floor_pose_bounds.PAIR_NOISE_PX == 0.3


def test_a_drive_is_settled_when_the_pose_is_right_and_never_wrong_again():
    right, wrong = Moment(TrackState.KNOWN, True), Moment(TrackState.KNOWN, False)
    is_open, lost = Moment(TrackState.OPEN, False), Moment(TrackState.LOST, False)
    assert first_right_s([is_open, lost, right, is_open, right]) == pytest.approx(0.2)
    assert first_right_s([right, wrong, is_open, right]) == pytest.approx(0.3)
    assert first_right_s([is_open, wrong]) is None
    found = summary([[is_open, right], [lost, right]], [[lost, lost], [wrong, right]])
    assert (found["settled"], found["wrong"], found["open"], found["lost"]) == (3, 1, 1, 3)
    assert found["settle_s"]["median"] == pytest.approx(0.1)
    assert (found["never_settled"], found["never_recovered"]) == (0, 1)


def test_pairs_that_the_calibration_refuses_are_measured_again() -> None:
    class Noise:
        """Draws that a calibration refuses, then none at all."""

        def __init__(self, num_bad: int) -> None:
            self.num_bad = num_bad

        def normal(self, mean: float, sd: float, num: int) -> np.ndarray:
            self.num_bad -= 1
            return np.where(np.arange(num) == 12, -40.0 if self.num_bad >= 0 else 0.0, 0.0)

    found = calibrated(CAMERA, Noise(3)).parameters
    assert found == pytest.approx(true_mirror(CAMERA), rel=1e-3)
    with pytest.raises(ValueError, match="radii must grow"):
        calibrated(CAMERA, Noise(100))
