"""The team experiment's simulator, bounds, oracle and judge, on layouts made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.bench_team import fit_alone
from experiments.team_alone import circles, least_squares
from experiments.team_bounds import bearing_gradients, bound, information, oracle_ids
from experiments.team_faults import FAULTS
from experiments.team_judge import faulty_figures, figures, judge
from experiments.team_layouts import BODY_RADIUS, FIELD_X, FIELD_Y, POSTS, Layout, random_layout
from experiments.team_paper_cases import METHODS, PAPER_ALONE, fits_best, paper_case
from experiments.team_peers import count_triangles, gtsam_poses, num_triples, scipy_poses
from experiments.team_rows import Row, judged, num_layouts, scene_of
from experiments.team_things import matched, things_on, with_things
from experiments.team_views_sim import Senses, hidden, see
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_views import NOBODY, ObjectEstimate, TeamSolution

DEGREE = float(np.radians(1.0))
SHARP = Senses(noise=1e-6)
IN_A_ROW = Layout(
    np.array([[-1.0, 0.0, 0.0], [0.0, 0.1, 1.0], [1.0, 0.0, 2.0]]), np.empty((0, 2))
)  # the middle one hides the outer two from each other


def truthful(scene, cov=None) -> TeamSolution:
    """Return the truth as an answer."""
    cov = np.eye(3) if cov is None else cov
    names = scene.layout.names
    return TeamSolution(
        names,
        {n: PoseEstimate(SE2(*p), cov) for n, p in zip(names, scene.layout.poses, strict=True)},
        dict(zip(names, scene.true_ids, strict=True)),
    )


def test_a_body_hides_what_is_behind_it_and_nothing_else():
    disk = np.array([[1.0, 0.1, 0.15]])
    targets = np.array([[2.0, 0.0], [2.0, 0.6], [0.8, 0.0], [-2.0, 0.0], [1.0, 0.0]])
    assert hidden(np.zeros(2), targets, disk).tolist() == [True, False, False, False, False]


def test_the_outer_two_of_a_row_see_the_middle_one_only():
    scene = see(IN_A_ROW, SHARP, 0)
    assert [sorted(ids) for ids in scene.true_ids] == [[1], [0, 2], [1]]
    open_air = see(IN_A_ROW, Senses(noise=1e-6, hides=False), 0)
    assert [sorted(ids) for ids in open_air.true_ids] == [[1, 2], [0, 2], [0, 1]]


def test_an_obstacle_hides_robots_and_posts():
    layout = Layout(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.array([[1.0, 0.0]]))
    assert [len(ids) for ids in see(layout, SHARP, 0).true_ids] == [0, 0]
    at_post = Layout(np.array([[0.0, 0.0, 0.0]]), POSTS["yellow_left"] * 0.9)
    assert set(see(at_post, SHARP, 0).views[0].landmark_bearings) == set(POSTS) - {"yellow_left"}


def test_a_bearing_is_the_direction_in_the_robots_own_frame():
    layout = Layout(np.array([[0.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0]]), np.empty((0, 2)))
    ahead, left = (view.bearings[0] for view in see(layout, SHARP, 0).views)
    assert (ahead, abs(left)) == pytest.approx((-np.pi / 2, np.pi), abs=1e-4)


def test_bearings_have_the_deviation_asked_for():
    off = []
    for seed in range(30):
        scene = see(random_layout(seed, 12), Senses(noise=3.0 * DEGREE), seed)
        for view, ids, pose in zip(scene.views, scene.true_ids, scene.layout.poses, strict=True):
            dx, dy = (scene.layout.poses[ids, :2] - pose[:2]).T
            off.append(np.angle(np.exp(1j * (view.bearings - np.arctan2(dy, dx) + pose[2]))))
    values = np.concatenate(off)
    assert abs(values.mean()) < 4.0 * values.std() / np.sqrt(len(values))
    assert values.std() == pytest.approx(3.0 * DEGREE, rel=0.06)


def test_missing_and_false_detections_come_as_often_as_asked_for():
    layout = random_layout(3, 20)
    whole = see(layout, SHARP, 3)
    poor = [see(layout, Senses(noise=DEGREE, miss_share=0.3, num_false=2.0), s) for s in range(40)]
    num_seen = sum(map(len, whole.true_ids))
    real = np.mean([sum((ids != NOBODY).sum() for ids in s.true_ids) for s in poor])
    false = np.mean([sum((ids == NOBODY).sum() for ids in s.true_ids) for s in poor])
    assert real == pytest.approx(0.7 * num_seen, rel=0.04)
    assert false == pytest.approx(2.0 * 20, rel=0.1)


@pytest.mark.parametrize("num", [3, 10, 50])
def test_robots_of_a_layout_stand_on_the_field_and_touch_nobody(num):
    layout = random_layout(1, num, 3)
    places = np.concatenate((layout.poses[:, :2], layout.obstacles))
    apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) + 9.0 * np.eye(len(places))
    assert apart.min() > 2.0 * BODY_RADIUS
    assert np.all(np.abs(places) < (0.5 * FIELD_X, 0.5 * FIELD_Y))
    assert np.array_equal(layout.poses, random_layout(1, num, 3).poses)


def test_views_tell_nothing_of_the_truth_but_what_is_seen():
    """Where two robots swap places, a third one sees the same, but for the order."""
    layout = random_layout(5, 3)
    swapped = Layout(layout.poses[[0, 2, 1]], layout.obstacles)
    a, b = (see(each, SHARP, 5).views[0] for each in (layout, swapped))
    assert np.sort(a.bearings) == pytest.approx(np.sort(b.bearings), abs=1e-4)
    assert a.known == b.known == ()


def test_bearings_come_in_any_order():
    first = [see(random_layout(s, 6), SHARP, s).true_ids[0] for s in range(20)]
    assert any(np.any(np.diff(ids) < 0) for ids in first)


@settings(max_examples=30)
@given(
    st.tuples(st.floats(-3, 3), st.floats(-2, 2), st.floats(-3, 3)),
    st.tuples(st.floats(4, 6), st.floats(-2, 2)),
)
def test_gradients_of_a_bearing_agree_with_differences(pose, place):
    def bearing(p, q):
        return np.arctan2(q[1] - p[1], q[0] - p[0]) - p[2]

    p, q, h = np.array(pose), np.array(place), 1e-6
    by_pose, by_place = bearing_gradients(p, q[None])
    expected = [(bearing(p + h * e, q) - bearing(p - h * e, q)) / (2 * h) for e in np.eye(3)]
    assert by_pose[0] == pytest.approx(expected, abs=1e-6)
    expected = [(bearing(p, q + h * e) - bearing(p, q - h * e)) / (2 * h) for e in np.eye(2)]
    assert by_place[0] == pytest.approx(expected, abs=1e-6)


def test_bound_of_a_robot_that_sees_nothing_is_its_rough_pose():
    scene = see(
        Layout(np.zeros((1, 3)), np.empty((0, 2))), Senses(noise=DEGREE, sees_posts=False), 0
    )
    assert bound(scene, counts_rough=True)[0] == pytest.approx(np.diag(scene.views[0].rough.cov))
    assert bound(scene, counts_rough=False) is None


def test_bound_across_a_known_baseline_by_hand():
    """Posts lie symmetrically around it, so that x is coupled with nothing."""
    scene = see(Layout(np.zeros((1, 3)), np.empty((0, 2))), Senses(noise=DEGREE, rough_sd=None), 0)
    x, y = POSTS["yellow_left"][0]
    # d bearing / d x = +-y / r^2 for all four posts
    expected = DEGREE**2 / (4.0 * (y / (x * x + y * y)) ** 2)
    assert bound(scene, counts_rough=False)[0, 0] == pytest.approx(expected)


def test_a_robot_more_to_be_seen_never_raises_the_bound():
    layout = random_layout(2, 6)
    with_all = see(layout, Senses(noise=DEGREE, hides=False), 2)
    fewer = see(Layout(layout.poses[:5], layout.obstacles), Senses(noise=DEGREE, hides=False), 2)
    a, b = (bound(s, counts_rough=True) for s in (with_all, fewer))
    assert np.all(a[:5] <= b + 1e-12)


def test_false_detections_give_no_information():
    layout = random_layout(2, 5)
    clean = information(see(layout, Senses(noise=DEGREE), 2), counts_rough=True)
    false = information(see(layout, Senses(noise=DEGREE, num_false=3.0), 2), counts_rough=True)
    assert false == pytest.approx(clean)


def test_oracle_is_right_on_sharp_bearings_and_refuses_false_ones():
    for seed in range(5):
        scene = see(random_layout(seed, 10), Senses(noise=1e-5, num_false=1.0), seed)
        for found, truth in zip(oracle_ids(scene), scene.true_ids, strict=True):
            assert np.array_equal(found, truth)


def test_truth_is_judged_right_and_a_swap_of_two_identities_is_not():
    scene = see(random_layout(4, 5), Senses(noise=DEGREE, hides=False), 4)
    perfect = judge(scene, truthful(scene), 1.0)
    assert perfect.is_exact and perfect.num_right == perfect.num_views == 20
    assert np.all(perfect.errors == 0.0)
    answer = truthful(scene)
    ids = dict(answer.identities)
    ids["r0"] = ids["r0"][[1, 0, 2, 3]]
    wrong = judge(scene, TeamSolution(answer.names, answer.estimates, ids), 1.0)
    assert not wrong.is_exact and wrong.num_right == 18 and wrong.num_wrong == 2
    assert figures([wrong])["wrong_share"] == pytest.approx(0.1)
    ids["r0"] = np.full(4, NOBODY)
    silent = judge(scene, TeamSolution(answer.names, answer.estimates, ids), 1.0)
    assert silent.num_right == 16 and silent.num_wrong == 0


def test_no_answer_is_no_identity_and_no_pose():
    scene = see(random_layout(4, 5), Senses(noise=DEGREE), 4)
    none = judge(scene, TeamSolution(scene.layout.names, problem="nothing"), 1.0)
    assert none.num_right == 0 and np.all(np.isnan(none.errors))
    assert figures([none])["rms_m"] is None and figures([none])["answered_share"] == 0.0


def test_nees_of_draws_from_the_covariance_lies_in_its_band():
    rng, cov = np.random.default_rng(0), np.diag([0.04, 0.01, 0.0025])
    verdicts, boasting = [], []
    for seed in range(200):
        scene = see(random_layout(seed, 3), Senses(noise=DEGREE), seed)
        off = rng.multivariate_normal(np.zeros(3), cov, 3)
        names = scene.layout.names
        for found, said in ((verdicts, cov), (boasting, 0.5 * cov)):
            poses = {
                n: PoseEstimate(SE2(*p), said)
                for n, p in zip(names, scene.layout.poses + off, strict=True)
            }
            found.append(judge(scene, TeamSolution(names, poses), 1.0))
    low, high = figures(verdicts)["nees_band"]
    assert (low, high) == pytest.approx((2.67, 3.35), abs=0.01)  # chi2 of 600 degrees, over 200
    assert low < figures(verdicts)["nees"] < high < figures(boasting)["nees"]
    assert figures(verdicts)["tail_share"] == pytest.approx(0.05, abs=0.02)
    assert figures(boasting)["tail_share"] == pytest.approx(0.27, abs=0.05)
    assert figures(boasting)["nees"] == pytest.approx(6.0, rel=0.15)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_robot_is_not_judged_and_the_others_views_stay(fault):
    scene = see(random_layout(6, 6), Senses(noise=DEGREE), 6)
    faulty = FAULTS[fault](scene)
    assert faulty.views[1:] == scene.views[1:] and faulty.views[0] is not scene.views[0]
    verdict = judge(faulty, truthful(faulty), 1.0)
    assert len(verdict.errors) == 5 and verdict.is_exact


def test_a_pose_of_the_faulty_robot_counts_only_where_it_would_be_published():
    scene = FAULTS["carried away"](see(random_layout(6, 6), Senses(noise=DEGREE), 6))
    said = truthful(scene, np.diag([0.01, 0.01, 0.01]))
    assert judge(scene, said, 1.0).faulty_chi2 == 0.0
    estimates = dict(said.estimates)
    right = estimates["r0"].pose
    estimates["r0"] = PoseEstimate(SE2(right.x + 1.0, right.y, right.yaw), estimates["r0"].cov)
    wrong = replace(said, estimates=estimates)
    assert judge(scene, wrong, 1.0).faulty_chi2 == pytest.approx(100.0)
    refused = judge(scene, replace(wrong, suspects=("r0",)), 1.0)
    assert np.isnan(refused.faulty_chi2)
    both = faulty_figures([judge(scene, wrong, 1.0), refused])
    assert both == {
        "faulty_published_share": 0.5, "faulty_wrong_share": 0.5,
        "honest_published_share": 1.0, "honest_wrong_share": 0.0,
    }  # fmt: skip


def test_a_wrong_pose_of_another_robot_counts_where_it_is_published():
    scene = FAULTS["carried away"](see(random_layout(6, 6), Senses(noise=DEGREE), 6))
    said = truthful(scene, np.diag([0.01, 0.01, 0.01]))
    right = said.estimates["r1"].pose
    off = PoseEstimate(SE2(right.x, right.y - 1.0, right.yaw), said.estimates["r1"].cov)
    wrong = replace(said, estimates={**said.estimates, "r1": off})
    shares = faulty_figures([judge(scene, wrong, 1.0)])
    assert shares["honest_wrong_share"] == pytest.approx(0.2)  # one of five
    refused = faulty_figures([judge(scene, replace(wrong, suspects=("r1",)), 1.0)])
    assert refused["honest_published_share"] == pytest.approx(0.8)
    assert refused["honest_wrong_share"] == 0.0


def test_a_solver_can_be_told_another_noise_than_the_true_one():
    told = scene_of(Row(table="", title="", num_robots=3, told_sd=2.0), 0)
    plain = scene_of(Row(table="", title="", num_robots=3), 0)
    for a, b in zip(told.views, plain.views, strict=True):
        assert a.bearing_sd == pytest.approx(2.0 * b.bearing_sd)
        assert np.array_equal(a.bearings, b.bearings)


@pytest.mark.parametrize("method", [circles, least_squares])
def test_robots_alone_find_themselves_by_sharp_bearings(method):
    for seed in range(5):
        scene = see(random_layout(seed, 4), SHARP, seed)
        answer = judge(scene, method(scene), 0.0, counts_rough=False)
        seen = np.array([len(view.landmark_bearings) >= 3 for view in scene.views])
        assert np.array_equal(np.isfinite(answer.errors[:, 0]), seen)
        assert np.nanmax(np.abs(answer.errors)) < 2e-3


def test_peers_agree_with_each_other():
    scene = see(random_layout(1, 6), Senses(noise=DEGREE), 1)
    a, b = scipy_poses(scene), gtsam_poses(scene)
    assert a[:, :2] == pytest.approx(b[:, :2], abs=1e-3)
    assert np.hypot(*(a - scene.layout.poses)[:, :2].T).max() < 0.2
    assert fit_alone(scene).poses[:, :2] == pytest.approx(b[:, :2], abs=1e-2)


def test_every_triangle_of_three_robots_is_one():
    poses = np.array([[0.0, 0.0, 0.3], [2.0, 0.0, 1.0], [0.5, 1.5, -2.0]])
    scene = see(Layout(poses, np.empty((0, 2))), SHARP, 0)
    assert count_triangles(scene, 0.001) == num_triples(3) == 1
    assert num_triples(10) == 120


def test_a_row_is_judged_over_its_layouts():
    row = judged(Row(table="sweep", title="three", num_robots=3), range(1000, 1012))
    assert row["layouts"] == 12 and row["identified_share"] == 1.0
    assert row["crlb_ratio"] == pytest.approx(1.0, abs=0.5)
    assert row["nees_band"][0] < 3.0 < row["nees_band"][1]


def test_the_papers_case_holds_every_method_on_the_same_robots():
    case = paper_case(2.0, range(1000, 1003))
    assert case["robots"] == 12 and case["noise_deg"] == 2.0
    assert all(case[method]["answers"] <= 12 for method in METHODS)
    assert 0.0 < case["ratio_to_alone"] < 1.0


def test_the_deviation_that_fits_the_papers_robots_alone_is_found():
    near = {"noise_deg": 3.0, "alone": {key: 1.1 * value for key, value in PAPER_ALONE.items()}}
    far = {"noise_deg": 2.0, "alone": {key: 0.5 * value for key, value in PAPER_ALONE.items()}}
    assert fits_best([far, near]) == 3.0


def test_large_teams_get_fewer_layouts_and_never_none():
    assert num_layouts(Row(table="sweep", title="", num_robots=4), 200) == 200
    assert num_layouts(Row(table="sweep", title="", num_robots=50), 200) == 18
    assert num_layouts(Row(table="faults", title="", num_robots=50), 1) == 1


def test_things_are_matched_to_the_nearest_found_and_phantoms_to_none():
    things = np.array([[0.0, 0.0], [2.0, 0.0], [-2.0, 1.0]])
    places = [[2.1, 0.0], [0.0, 0.1], [3.9, 2.0]]
    found = [ObjectEstimate("ball", np.array(p), np.eye(2), ("r0", "r1")) for p in places]
    pairs = [(thing.tolist(), each.position.tolist()) for thing, each in matched(things, found)]
    assert pairs == [([0.0, 0.0], [0.0, 0.1]), ([2.0, 0.0], [2.1, 0.0])]
    assert matched(things, []) == []


def test_each_robot_sees_the_balls_that_nothing_hides():
    scene = see(random_layout(2, 4), Senses(noise=1e-6, hides=False), 2)
    things = things_on(scene, 2)
    assert np.hypot(*(things[:, None] - scene.layout.poses[:, :2]).transpose(2, 0, 1)).min() > 0.5
    for view, pose in zip(with_things(scene, things, 2).views, scene.layout.poses, strict=True):
        rays = np.arctan2(*(things - pose[:2]).T[::-1]) - pose[2]
        off = np.exp(1j * (view.object_bearings["ball"][:, None] - rays))
        assert np.all(np.abs(off - 1.0).min(axis=1) < 1e-4)
