"""The published steps: triangles, enumeration, growth by edges, circle and size, by hand."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from team_builders import GOALS, SIX, TRIANGLE, bearing, team, wrapped

from floornav_common.se2 import SE2
from multi_localizer.enumeration import holds, num_seen, num_there
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.rays import crossing
from multi_localizer.relative_layout import grow
from multi_localizer.team_config import PublishedTeamConfig, TeamConfig
from multi_localizer.team_problem import make_problem
from multi_localizer.team_published import size_ratios, solve_published
from multi_localizer.triangles import angles_between, count_sums, folded, is_ordered, makes_triangle
from multi_localizer.two_landmarks import SeenPair, circle, circle_distance, two_landmarks

EXACT = TeamConfig(published=PublishedTeamConfig(angle_tolerance_rad=1e-3))
TOL = 1e-6
GOOD = (0.01, 0.01, 0.01)


def test_angles_are_folded_below_half_a_turn() -> None:
    assert folded(-3.0, 3.0) == pytest.approx(2.0 * pi - 6.0)
    assert folded(0.2, 1.4) == pytest.approx(1.2)


def test_angles_make_a_triangle_if_their_sum_is_half_a_turn() -> None:
    assert makes_triangle(pi / 2.0, pi / 4.0, pi / 4.0 + 0.05, 0.06)
    assert not makes_triangle(pi / 2.0, pi / 4.0, pi / 4.0 + 0.05, 0.04)


def test_bearings_are_ordered_by_turning_less_than_half_a_turn() -> None:
    assert is_ordered(3.0, -3.0, 1.0)
    assert not is_ordered(3.0, -3.0, -1.0)


def test_every_triple_of_robots_is_checked() -> None:
    assert angles_between(np.array([0.0, pi / 3.0, -pi / 2.0])) == pytest.approx(
        [pi / 3.0, pi / 2.0, 5.0 * pi / 6.0]
    )
    four, right = np.array([0, 1, 2, 3, 4]), np.array([1.0, 1.0, 1.0, 2.0]) * pi / 3.0
    assert count_sums(four, np.array([0]), 0.01, 99) == 0
    assert count_sums(right, four, 0.01, 99) == 1  # 60, 60, 60; with 120 the sum is 240
    assert count_sums(np.full(4, pi / 3.0), four, 0.01, 99) == 4
    assert count_sums(np.full(4, pi / 3.0), four, 0.01, 2) == 2


def test_robots_are_counted_on_both_sides() -> None:
    places = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, -1.0], [5.0, 2.0]])
    known = np.ones(5, dtype=np.bool_)
    assert num_there(places, known, 0, 1) == (2, 1)
    known[4] = False  # it may stand on either side
    assert num_there(places, known, 0, 1) == (2, 2)
    assert num_seen(np.array([0.0, 0.5, 1.0, -0.5]), 0, 4, 0) == (2, 1)


def test_more_robots_seen_than_there_are_refuse_a_pair_of_rays() -> None:
    places = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 1.0]])
    start = np.array([0, 2, 4, 4])
    known = np.ones(3, dtype=np.bool_)
    bearings = np.array([0.0, 0.7, pi, 2.4])  # robot 2 stands left of 0 -> 1, and is seen there
    assert holds(0, 0, 1, 2, start, bearings, places, known)
    assert not holds(0, 1, 1, 2, start, bearings, places, known)  # 0 would see one on the right


def test_rays_cross_ahead_only() -> None:
    origin, east = np.zeros(2), np.array([2.0, 0.0])
    assert crossing(origin, pi / 4.0, east, 3.0 * pi / 4.0) == pytest.approx([1.0, 1.0])
    assert crossing(origin, -3.0 * pi / 4.0, east, 3.0 * pi / 4.0) is None
    assert crossing(origin, 0.5, east, 0.5) is None


def test_layout_is_similar_to_the_truth_and_grows_triangle_by_triangle() -> None:
    views, truth = team(SIX, noise=0.0, rough_sd=GOOD)
    problem = make_problem(views, GOALS, EXACT)
    layouts = list(grow(problem, 1e-3))
    assert [layout.num_triangles for layout in layouts] == list(range(1, len(layouts) + 1))
    assert len(layouts[0].robots) == 3
    last = layouts[-1]
    assert sorted(last.robots) == list(range(6))
    assert np.array_equal(last.owner, np.concatenate(truth))
    a, b = last.robots[:2]
    size = np.hypot(*(SIX[b] - SIX[a])[:2])
    for i in range(6):
        for j in range(i):
            true_length = np.hypot(*(SIX[i] - SIX[j])[:2])
            assert np.hypot(*(last.places[i] - last.places[j])) * size == pytest.approx(
                true_length, rel=1e-3
            )
    turn = wrapped(last.yaws - SIX[:, 2])
    assert np.allclose(turn, turn[0], atol=1e-3)


def test_robots_that_only_see_their_own_half_make_two_parts_and_the_larger_one_counts() -> None:
    poses = np.vstack((SIX, [0.4, 2.1, 0.5]))
    views, truth = team(poses, noise=0.0, rough_sd=GOOD)
    halves = ({0, 1, 2}, {3, 4, 5, 6})
    owners = []
    for i, ids in enumerate(truth):
        kept = np.array([any({i, int(j)} <= half for half in halves) for j in ids])
        views[i] = replace(views[i], bearings=views[i].bearings[kept])
        owners.append(ids[kept])
    layouts = list(grow(make_problem(views, GOALS, EXACT), 1e-3))
    assert sorted(layouts[0].robots) == [0, 1, 2]
    assert sorted(layouts[-1].robots) == [3, 4, 5, 6]
    assert np.array_equal(layouts[-1].owner, np.concatenate(owners))
    assert [layout.num_triangles for layout in layouts] == list(range(1, len(layouts) + 1))
    solution = solve_published(views, GOALS, EXACT)
    assert set(solution.relative) == {"r3", "r4", "r5", "r6"}


def test_circle_goes_through_both_landmarks_and_the_robot() -> None:
    pair = SeenPair(np.array([0.0, -1.0]), np.array([0.0, 1.0]), pi / 2.0)
    middle, radius = circle(pair)
    # 3.3 with L = 2 and theta = 90 degrees: x^2 + y^2 = 1
    assert middle == pytest.approx([0.0, 0.0], abs=TOL)
    assert radius == pytest.approx(1.0)


def test_circle_is_met_on_the_right_side_of_the_landmarks() -> None:
    pair = SeenPair(np.array([0.0, -1.0]), np.array([0.0, 1.0]), pi / 2.0)
    # Seen from x < 0 the second one is to the left of the first: at the left point of the circle.
    assert circle_distance(np.array([-3.0, 0.0]), 0.0, pair, None) == pytest.approx(2.0)
    other = SeenPair(pair.first, pair.second, -pi / 2.0)
    assert circle_distance(np.array([-3.0, 0.0]), 0.0, other, None) == pytest.approx(4.0)
    assert circle_distance(np.array([-3.0, 5.0]), 0.0, pair, None) is None


def test_exact_views_and_base_robot_give_exact_poses() -> None:
    views, truth = team(SIX, noise=0.0, rough_sd=(1e-5, 1e-5, 1e-5))
    solution = solve_published(views, GOALS, EXACT)
    assert solution.problem == "" and solution.unobservable == ""
    for k, pose in enumerate(SIX):
        estimate = solution.estimates[f"r{k}"].pose
        assert (estimate.x, estimate.y) == pytest.approx(pose[:2], abs=1e-3)
        assert wrapped(estimate.yaw - pose[2]) == pytest.approx(0.0, abs=1e-3)
        assert np.array_equal(solution.identities[f"r{k}"], truth[k])


def test_layout_without_landmarks_has_no_size() -> None:
    views, _ = team(TRIANGLE, noise=0.0, rough_sd=GOOD, landmarks={})
    solution = solve_published(views, {}, EXACT)
    assert not solution.estimates
    assert "size" in solution.unobservable
    assert set(solution.relative) == {"r0", "r1", "r2"}


def test_layout_without_any_own_pose_has_no_place() -> None:
    views, _ = team(TRIANGLE, noise=0.0, rough_sd=None)
    solution = solve_published(views, GOALS, EXACT)
    assert not solution.estimates
    assert "place and turn" in solution.unobservable


def test_size_is_found_along_the_base_robots_own_bearing() -> None:
    posts = {"left": np.array([[4.0, 2.0]]), "right": np.array([[4.0, -2.0]])}
    views, _ = team(TRIANGLE, noise=0.0, rough_sd=(1e-5, 1e-5, 1e-5), landmarks=posts)
    views[0] = replace(views[0], bearings=views[0].bearings - 0.02)
    config = TeamConfig(published=PublishedTeamConfig(angle_tolerance_rad=0.1))
    problem = make_problem(views, posts, config)
    *_, layout = grow(problem, 0.1)
    ratios = []
    for i in (1, 2):  # all three see both posts; r0 is the base
        pair = two_landmarks(problem, i)
        assert pair is not None
        along = float(np.arctan2(*(TRIANGLE[i] - TRIANGLE[0])[1::-1])) - 0.02
        far = circle_distance(TRIANGLE[0, :2], along, pair, TRIANGLE[i, :2])
        assert far is not None
        ratios.append(far / np.hypot(*(layout.places[i] - layout.places[0])))
    assert size_ratios(problem, layout, 0) == pytest.approx(ratios, rel=1e-4)
    hidden = np.where(np.arange(6) < 2, -1, layout.owner)  # as if r0 saw nobody
    assert not len(size_ratios(problem, replace(layout, owner=hidden), 0))


def test_sizes_that_scatter_are_refused() -> None:
    views, _ = team(SIX, noise=0.0, rough_sd=(0.5, 0.5, 0.5))
    exact, _ = team(SIX, noise=0.0, rough_sd=(1e-4, 1e-4, 1e-4))
    views[0] = exact[0]
    assert solve_published(views, GOALS, EXACT).estimates
    for i, off in ((1, 0.9), (3, -0.7), (4, 1.2)):
        marks = {**views[i].landmark_bearings}
        marks["blue"] = marks["blue"] + off
        views[i] = replace(views[i], landmark_bearings=marks)
    solution = solve_published(views, GOALS, EXACT)
    assert not solution.estimates and "size" in solution.unobservable
    assert len(solution.relative) == 6


def test_a_layout_that_contradicts_the_robots_own_poses_is_refused() -> None:
    views, _ = team(SIX, noise=0.0, rough_sd=(1e-3, 1e-3, 1e-3))
    tight = np.diag([1e-7, 1e-7, 1e-7])
    assert views[0].rough is not None
    turned = SE2(views[0].rough.pose.x, views[0].rough.pose.y, views[0].rough.pose.yaw + 0.03)
    views[0] = replace(views[0], rough=PoseEstimate(turned, tight))  # the base, and wrong
    solution = solve_published(views, GOALS, EXACT)
    assert not solution.estimates and "own poses" in solution.unobservable


def test_two_robots_make_no_triangle() -> None:
    views, _ = team(TRIANGLE[:2])
    assert "no triangle" in solve_published(views, GOALS).problem


def test_moving_everything_moves_the_published_answer() -> None:
    T = SE2(-2.0, 1.0, 1.1)
    poses = np.array([(T @ SE2(*pose)).as_array() for pose in TRIANGLE])
    here = solve_published(team(TRIANGLE, rough_sd=(1e-4, 1e-4, 1e-4))[0], GOALS)
    moved_goals = {kind: T @ places for kind, places in GOALS.items()}
    there_views = team(poses, rough_sd=(1e-4, 1e-4, 1e-4), landmarks=moved_goals)[0]
    there = solve_published(there_views, moved_goals)
    for name, estimate in here.estimates.items():
        expected = T @ estimate.pose
        assert there.estimates[name].pose.x == pytest.approx(expected.x, abs=5e-3)
        assert there.estimates[name].pose.y == pytest.approx(expected.y, abs=5e-3)


def test_builder_bearings_point_where_they_should() -> None:
    assert bearing(np.array([0.0, 0.0, pi / 2.0]), np.array([1.0, 0.0])) == pytest.approx(-pi / 2.0)
