"""Open places where bearings cross, and who stands at which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from team_builders import GOALS, team

from floornav_common.se2 import SE2
from multi_localizer import team_reseat
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_fit import TeamFit
from multi_localizer.team_identify import place_first
from multi_localizer.team_places import crossing, known_robots, open_places
from multi_localizer.team_problem import make_problem
from multi_localizer.team_relocate import nearest_table
from multi_localizer.team_reseat import reseat
from multi_localizer.team_seats import look_around, pattern
from multi_localizer.team_yaws import CLUTTER

SD = 0.01
KNOWN = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, np.pi], [0.0, 3.0, -0.5 * np.pi]])
PLACE = np.array([2.0, 1.5])
RING = np.array([
    [0.0, 0.0, 0.3], [3.0, -0.4, 2.0], [4.4, 2.2, -1.2], [2.6, 4.1, 0.9], [-0.7, 3.2, -2.2],
    [1.2, 1.9, 1.6], [2.4, 1.4, -0.4],
])  # fmt: skip


def _known() -> np.ndarray:
    return known_robots(KNOWN, 1e-8 * np.eye(9), np.ones(3, dtype=bool))


def _seen(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return one bearing of each known robot to a place, and where each robot's begin."""
    arm = place - KNOWN[:, :2]
    bearings = np.arctan2(arm[:, 1], arm[:, 0]) - KNOWN[:, 2]
    return (bearings + np.pi) % (2.0 * np.pi) - np.pi, np.arange(4)


def _score(place: np.ndarray, *, is_open: bool) -> float:
    bearings, start = _seen(PLACE)
    table = nearest_table(start, bearings, np.ones(3, dtype=bool))
    return float(
        crossing(
            *place, 0.0, 0.0, 0.9, 0.3, _known(), bearings, np.full(3, SD**2),
            np.full(3, is_open), table,
        )
    )  # fmt: skip


def test_three_exact_bearings_that_cross_count_as_their_density_over_clutter() -> None:
    each = np.log(0.1 + 0.9 / (np.sqrt(2.0 * np.pi) * SD) / CLUTTER)
    assert _score(PLACE, is_open=True) == pytest.approx(3.0 * each, rel=1e-3)


def test_bearings_with_an_owner_say_nothing_where_they_cross() -> None:
    assert _score(PLACE, is_open=False) == pytest.approx(0.0, abs=1e-3)


def test_where_no_bearing_leads_each_robot_speaks_against_the_place() -> None:
    aside = PLACE + np.array([0.3, 0.9])
    assert _score(aside, is_open=True) == pytest.approx(3.0 * np.log(0.1), rel=1e-6)


def test_the_place_is_found_within_the_disk_and_nowhere_outside_of_it() -> None:
    bearings, start = _seen(PLACE)
    table = nearest_table(start, bearings, np.ones(3, dtype=bool))
    rest = (_known(), bearings, np.full(3, SD**2), np.ones(3, dtype=bool), table)
    low, high = np.array([-1.0, -1.0]), np.array([5.0, 4.0])
    places = open_places(
        low, high, 0.1, 0.2, 5, PLACE[None] + 0.3, np.array([1.0]), 0.0, 0.9, 0.3, *rest
    )
    assert np.hypot(*(places[0, :2] - PLACE)) < 0.03
    assert np.all(np.hypot(*(places[:, :2] - PLACE - 0.3).T) < 1.2)
    assert places[0, 2] == places[:, 2].max()


def test_a_known_robot_between_hides_the_one_behind() -> None:
    known = known_robots(
        np.array([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), 1e-8 * np.eye(6), np.ones(2, dtype=bool)
    )
    none = np.full((2, 256), -1)
    around = look_around(
        0.0, 0.0, 0.0, 0.0, 0.9, 0.3, known, np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool), none
    )
    assert around[0, 2] > 0.99
    assert around[1, 2] == pytest.approx(0.02)


def test_a_pattern_fits_best_at_the_yaw_it_was_seen_at() -> None:
    around = np.array([[0.2, 0.0, 1.0, 1.0], [1.7, 0.0, 1.0, 1.0], [-2.0, 0.0, 1.0, 1.0]])
    yaw, bearings = 0.6, np.array([0.2, 1.7, -2.0]) - 0.6
    table = nearest_table(np.array([0, 3]), bearings, np.ones(3, dtype=bool))
    turns = np.arange(-3.0, 3.0, 0.03)
    scores = [pattern(0, t, 0.03, around, 0.9, bearings, np.full(3, SD**2), table) for t in turns]
    assert turns[int(np.argmax(scores))] == pytest.approx(yaw, abs=0.03)


def test_two_robots_in_each_others_place_are_put_right_at_once() -> None:
    views, truth = team(RING, seed=2, noise=SD, landmarks=GOALS, rough_sd=(0.8, 0.8, 0.3))
    config = TeamConfig(body_radius_m=0.0)
    problem = make_problem(views, GOALS, config)
    first = place_first(problem, problem.has_prior.astype(float), config)
    poses = RING.copy()
    poses[[5, 6]] = RING[[6, 5]]
    owner = np.concatenate(truth)
    wrong = np.where(owner == 5, 6, np.where(owner == 6, 5, owner))
    swapped = replace(
        first, owner=wrong, seen=wrong, belief=np.ones(len(owner)),
        fit=TeamFit(poses, 1e-4 * np.eye(21), 0.0),
    )  # fmt: skip
    lost = np.isin(np.arange(7), (5, 6))
    found, moved = reseat(problem, swapped, lost, config)
    assert list(np.flatnonzero(moved)) == [5, 6]
    assert np.all(np.hypot(*(found.fit.poses - RING)[:, :2].T) < 0.1)
    assert np.all(np.abs((found.fit.poses - RING)[:, 2]) < 0.1)


def test_nobody_lost_moves_nobody() -> None:
    views, _ = team(RING, seed=2, noise=SD, landmarks=GOALS)
    config = TeamConfig()
    problem = make_problem(views, GOALS, config)
    first = place_first(problem, problem.has_prior.astype(float), config)
    found, moved = reseat(problem, first, np.zeros(7, dtype=bool), config)
    assert not moved.any()
    assert found is first


@pytest.mark.parametrize("sd", [1.0, 5.0])
@pytest.mark.parametrize("off", [0.0, 1e6])
def test_the_area_that_is_searched_is_bounded_whatever_rough_poses_say(
    sd: float, off: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells: list[float] = []

    def counted(low: np.ndarray, high: np.ndarray, step: float, *rest: object) -> np.ndarray:
        cells.append(float(np.prod((high - low) / step + 1.0)))
        return open_places(low, high, step, *rest)

    monkeypatch.setattr(team_reseat, "open_places", counted)
    views, _ = team(RING, seed=2, noise=SD, landmarks=GOALS)
    rough = PoseEstimate(SE2(off, -off, 0.0), np.diag([sd**2, sd**2, 1.0]))
    views[5] = replace(views[5], rough=rough)
    config = TeamConfig(body_radius_m=0.0)
    problem = make_problem(views, GOALS, config)
    first = place_first(problem, problem.has_prior.astype(float), config)
    found, _ = reseat(problem, first, np.arange(7) == 5, config)
    assert len(cells) == 1 and cells[0] < 210_000
    assert np.isfinite(found.fit.poses).all()


def test_a_robot_thrown_far_away_leaves_the_search_for_others_as_it_is() -> None:
    views, truth = team(RING, seed=2, noise=SD, landmarks=GOALS)
    config = TeamConfig(body_radius_m=0.0)
    problem = make_problem(views, GOALS, config)
    lost = np.isin(np.arange(7), 5)
    info = np.where(lost[:, None, None], 0.0, problem.prior_info)
    problem = replace(problem, prior_info=info)
    first = place_first(problem, problem.has_prior.astype(float), config)
    poses = RING.copy()
    poses[0] = (1e7, -1e7, 0.0)
    poses[5] = (0.0, 0.3, 0.0)
    owner = np.concatenate(truth)
    thrown = replace(
        first, owner=owner, seen=owner, belief=np.ones(len(owner)),
        fit=TeamFit(poses, 1e-4 * np.eye(21), 0.0),
    )  # fmt: skip
    found, _ = reseat(problem, thrown, lost, config)
    assert np.hypot(*(found.fit.poses[5] - RING[5])[:2]) < 0.1
