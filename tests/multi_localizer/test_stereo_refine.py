import numpy as np
import pytest
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.stereo_judge import doubts, judge, known_part, polished
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_refine import Prior, refine, targets_of
from multi_localizer.voxel_view import VoxelScene

POSE = SE2(1.6, 1.3, 0.4)
CONFIG = StereoLocalizerConfig()


@pytest.fixture(scope="module")
def scene():
    return VoxelScene(room())


@pytest.fixture(scope="module")
def targets(scene):
    return targets_of(views_at(scene.voxels, POSE), CAMERAS, (80, 8), CONFIG)


def away(offset):
    return POSE.as_array()[None] + np.array([offset])


@pytest.mark.parametrize("offset", [(0.05, -0.04, 0.02), (-0.06, 0.03, -0.04), (0.0, 0.0, 0.06)])
def test_a_pose_near_by_is_drawn_to_the_true_one(scene, targets, offset):
    near = refine(scene, targets, away(offset), CONFIG, 6, 0.1, 4.0)
    fits = refine(scene, targets, near.poses, CONFIG, 6, 0.1)
    assert np.hypot(*(fits.poses[0, :2] - [POSE.x, POSE.y])) < 0.005
    assert abs(fits.poses[0, 2] - POSE.yaw) < 0.003
    assert fits.costs[0] < 0.05


def test_no_step_makes_it_worse(scene, targets):
    rng = np.random.default_rng(0)
    poses = POSE.as_array() + rng.normal(0.0, 1.0, (12, 3)) * [0.2, 0.2, 0.3]
    before = refine(scene, targets, poses, CONFIG, 0, 0.1)
    after = refine(scene, targets, poses, CONFIG, 3, 0.1)
    assert np.array_equal(before.poses[:, :2], poses[:, :2])
    assert (after.costs <= before.costs + 1e-12).all()
    assert (after.costs < before.costs).any()


def test_a_batch_is_refined_as_each_alone(scene, targets):
    poses = np.concatenate((away((0.05, 0.0, 0.0)), away((0.0, 0.05, 0.03))))
    both = refine(scene, targets, poses, CONFIG, 3, 0.1)
    for k in range(2):
        alone = refine(scene, targets, poses[k : k + 1], CONFIG, 3, 0.1)
        assert alone.poses[0] == pytest.approx(both.poses[k], abs=1e-9)


def test_a_strong_prior_keeps_the_pose(scene, targets):
    start = away((0.05, 0.0, 0.0))
    prior = Prior(start, np.eye(3)[None] * 1e6)
    held = refine(scene, targets, start, CONFIG, 4, 0.1, 1.0, prior)
    assert held.poses[0] == pytest.approx(start[0], abs=1e-3)


def test_the_hessian_is_symmetric_and_says_what_the_views_say(scene, targets):
    fits = refine(scene, targets, POSE.as_array()[None], CONFIG, 0, 0.1)
    assert np.allclose(fits.hessians[0], fits.hessians[0].T)
    assert (np.linalg.eigvalsh(fits.hessians[0]) > 0.0).all()


def test_the_true_pose_costs_next_to_nothing_and_others_more(scene, targets):
    poses = np.concatenate([away(o) for o in ((0, 0, 0), (0.1, 0, 0), (0, 0, 0.3), (0.5, -0.5, 2))])
    costs = judge(scene, targets, poses, CONFIG)
    assert costs[0] < 0.1
    assert (np.diff(costs) > 0.0).all()
    assert costs[-1] <= 1.0
    assert known_part(targets) == 1.0


def test_where_nothing_is_known_distances_can_cost_nothing(scene):
    views = views_at(scene.voxels, POSE)
    for view in views:
        view.weight[:] = 0.0
        view.inverse[:] = np.nan
    targets = targets_of(views, CAMERAS, (80, 8), CONFIG)
    assert known_part(targets) == 0.0
    assert judge(scene, targets, away((0, 0, 0)), CONFIG)[0] < 0.1


def test_polishing_ends_where_judging_finds_no_better(scene, targets):
    starts = np.concatenate([away((0.01, 0.0, 0.0)), away((0.0, -0.01, 0.005))])
    poses = polished(scene, targets, starts, CONFIG)
    costs = judge(scene, targets, poses, CONFIG)
    assert (costs < judge(scene, targets, starts, CONFIG)).all()
    assert costs == pytest.approx(judge(scene, targets, away((0, 0, 0)), CONFIG)[0], abs=0.005)


def test_small_costs_count_by_their_difference_and_great_ones_by_their_ratio():
    usual, evidence = CONFIG.usual_cost, CONFIG.evidence
    one, other = doubts(usual * np.array([0.0, 1e-4]), CONFIG)
    assert other - one == pytest.approx(evidence * usual * 1e-4, rel=1e-3)
    one, other = doubts(usual * np.array([1e6, 2e6]), CONFIG)
    assert other - one == pytest.approx(evidence * usual * np.log(2.0), rel=1e-3)
    assert (np.diff(doubts(np.linspace(0.0, 1.0, 50), CONFIG)) > 0.0).all()


@pytest.mark.parametrize(("costs", "is_sure"), [((0.03, 0.05), True), ((0.15, 0.165), False)])
def test_what_settles_on_a_good_map_does_not_on_one_that_is_wrong_in_places(costs, is_sure):
    against = doubts(np.array(costs), CONFIG)
    shares = np.exp(-against) / np.exp(-against).sum()
    assert (shares[0] >= CONFIG.settle_share) == is_sure
