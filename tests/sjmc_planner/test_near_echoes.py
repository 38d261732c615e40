"""Echoes from close by: which are explained, which are sure, how long they count."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.known_config import KnownConfig
from sjmc_planner.near_echoes import NearEchoes, distance_heard, pane_of
from sjmc_planner.pane_direction import PaneLine
from sjmc_planner.planning import Obstacles

HERE = SE2(0.0, 0.0, 0.0)
OPENING = 0.35
NUM = 360
DT = 0.1


def echo(r: float, *, opening: float = OPENING) -> RangeReading:
    return RangeReading(r, opening, 0.15, 5.0)


def seen(r: float = np.inf, bearing: float = 0.0, width: float = 0.1) -> Obstacles:
    """Return a scan that shows something at one bearing."""
    step = 2.0 * np.pi / NUM
    ranges = np.full(NUM, np.inf)
    ranges[np.abs(-np.pi + step * np.arange(NUM) - bearing) <= width / 2.0] = r
    return Obstacles(Scan(ranges, -np.pi, step, 0.1, 8.0), HERE)


def pane(r: float, mount: SE2 = HERE, ends=(), opening: float = OPENING, line=PaneLine()):  # noqa: B008, frozen
    ends = np.array(ends, dtype=float).reshape(-1, 2)
    return pane_of(r, opening, mount, ends, 1.0, line, np.zeros(2))


def test_a_pane_lies_across_the_way_of_the_sound() -> None:
    points, is_heard = pane(1.0, SE2(0.2, 0.1, np.pi / 2.0))
    assert points[:, 1] == pytest.approx(1.1)
    assert points[:, 0].min() == pytest.approx(-0.3) and points[:, 0].max() == pytest.approx(0.7)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 0.05
    heard = points[is_heard, 0] - 0.2
    assert np.abs(heard).max() == pytest.approx(np.sin(OPENING / 2.0), abs=0.05)


def test_an_opening_that_is_not_said_is_twenty_degrees() -> None:
    points, is_heard = pane(1.0, opening=0.0)
    assert np.abs(points[is_heard, 1]).max() == pytest.approx(np.sin(np.deg2rad(10.0)), abs=0.05)


def test_a_pane_ends_at_the_next_post_that_the_scan_shows() -> None:
    points, _ = pane(1.0, ends=[(1.05, 0.3), (1.05, 0.34), (1.5, -0.35), (1.5, -0.39)])
    assert points[:, 1].max() == pytest.approx(0.3) and points[:, 1].min() == pytest.approx(-0.5)


def test_a_speck_of_dirt_on_a_pane_does_not_end_it() -> None:
    points, _ = pane(1.0, ends=[(1.05, 0.3), (1.0, -0.4), (1.0, 0.42)])
    assert points[:, 1].max() == pytest.approx(0.5) and points[:, 1].min() == pytest.approx(-0.5)


@pytest.mark.parametrize("num_others", [0, 1, 2, 9])
def test_what_shines_squarely_on_a_line_told_by_others_is_the_pane_itself(num_others: int) -> None:
    shine = [(1.0, -0.05), (1.0, 0.0), (1.0, 0.05), (1.0, 0.4), (1.0, 0.45)]
    points, _ = pane(1.0, ends=shine, line=PaneLine(0.0, num_others))
    assert (len(points) > 0) == (num_others >= 2)
    if len(points):  # it ends at the post beyond, not at its own shine
        assert points[:, 1].max() == pytest.approx(0.4)
        assert points[:, 1].min() == pytest.approx(-1.0)


def test_what_stands_before_a_line_told_by_others_explains_an_echo() -> None:
    points, _ = pane(1.0, ends=[(0.88, 0.0), (0.88, 0.04)], line=PaneLine(0.0, 9))
    assert len(points) == 0


def test_a_pane_is_laid_across_its_own_normal() -> None:
    points, _ = pane(1.0, line=PaneLine(0.3, 4))
    assert points @ [np.cos(0.3), np.sin(0.3)] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("x", "y", "explains"),
    [(1.05, 0.0, True), (1.0, 0.2, True), (1.3, 0.0, False), (0.7, 0.0, False), (0.9, 0.5, False)],
)
def test_what_the_scan_shows_there_explains_an_echo(x: float, y: float, explains: bool) -> None:
    assert (len(pane(1.0, ends=[(x, y)])[0]) == 0) == explains


@pytest.mark.parametrize(
    ("r", "distance"), [(0.8, 0.8), (-np.inf, 0.15), (np.inf, np.inf), (np.nan, np.inf)]
)
def test_too_near_to_measure_is_as_far_as_a_sonar_measures(r: float, distance: float) -> None:
    assert distance_heard(echo(r)) == distance


def test_one_echo_is_not_sure_and_a_second_from_there_makes_both_so() -> None:
    echoes = NearEchoes(KnownConfig())
    assert len(echoes.update([(echo(0.8), HERE)], seen(), HERE, DT)) == 0
    found = echoes.update([(echo(0.82), HERE)], seen(), HERE, DT)
    assert sorted(set(found[:, 0].round(6).tolist())) == pytest.approx([0.8, 0.82])


def test_echoes_of_different_places_do_not_agree() -> None:
    echoes = NearEchoes(KnownConfig())
    echoes.update([(echo(0.8), HERE)], seen(), HERE, DT)
    assert len(echoes.update([(echo(1.1), HERE)], seen(), HERE, DT)) == 0
    assert len(echoes.update([(echo(0.8), SE2(0.0, 0.0, 1.5))], seen(), HERE, DT)) == 0


def test_an_approach_keeps_a_pane_in_its_place() -> None:
    """At 0.6 m/s towards a pane at 1.1 m: each echo is nearer, the pane stays where it is."""
    echoes, step = NearEchoes(KnownConfig()), SE2(0.06, 0.0, 0.0)
    for k in range(8):
        found = echoes.update([(echo(1.1 - 0.06 * k), HERE)], seen(), step if k else HERE, DT)
        if k:
            ahead = found[np.abs(found[:, 1]) < 0.02]
            assert ahead[:, 0] == pytest.approx(1.1 - 0.06 * k, abs=0.01)


def test_echoes_are_forgotten_after_their_time() -> None:
    echoes = NearEchoes(KnownConfig(echo_hold_s=1.0))
    echoes.update([(echo(0.8), HERE), (echo(0.8), HERE)], seen(), HERE, DT)
    assert len(echoes.update([], seen(), HERE, 0.9)) > 0
    assert len(echoes.update([], seen(), HERE, 0.2)) == 0


@pytest.mark.parametrize("r", [np.nan, np.inf, 0.05, 1.5, 5.0])
def test_what_is_no_echo_from_close_by_is_nothing(r: float) -> None:
    echoes = NearEchoes(KnownConfig())
    for _ in range(3):
        assert len(echoes.update([(echo(r), HERE)], seen(), HERE, DT)) == 0


def test_what_the_scan_shows_before_a_pane_leaves_only_the_rest_of_it() -> None:
    echoes, before = NearEchoes(KnownConfig()), seen(0.4, bearing=0.15, width=0.1)
    for _ in range(2):
        found = echoes.update([(echo(1.0), HERE)], before, HERE, DT)
    bearings = np.arctan2(found[:, 1], found[:, 0])
    assert len(found) and not ((bearings > 0.11) & (bearings < 0.19)).any()


def test_where_the_laser_does_not_look_an_echo_counts() -> None:
    scan = seen().scan
    scan.ranges[:45] = np.nan  # behind, on one side
    echoes, back = NearEchoes(KnownConfig()), SE2(-0.3, 0.0, np.pi)
    for _ in range(2):
        found = echoes.update([(echo(0.5), back)], Obstacles(scan, HERE), HERE, DT)
    assert len(found) > 2 and found[:, 0].min() == pytest.approx(-0.8, abs=0.001)


def test_a_pane_heard_at_a_slant_reaches_before_a_robot_that_drives_past_and_shines() -> None:
    """A pane at 45 degrees before it; the laser soon sees it where it looks squarely at it.

    A sonar at 67 degrees hears it, 22 degrees off its normal, on a drive of 0.8 m; then one at 45.
    """
    echoes, normal = NearEchoes(KnownConfig()), np.array([1.0, 1.0]) / np.sqrt(2.0)
    wide, square = SE2(0.0, 0.28, 1.178), SE2(0.14, 0.28, 0.785)
    for k in range(10):
        off = 1.5 - normal[0] * 0.08 * k
        mount = wide if k < 8 else square
        r = off - float(normal @ [mount.x, mount.y])
        shines = seen() if k < 7 else seen(off, bearing=0.785, width=0.2)
        found = echoes.update([(echo(r), mount)], shines, SE2(0.08 if k else 0.0, 0.0, 0.0), DT)
    ahead = found[np.abs(found[:, 1]) < 0.28]
    assert len(ahead) > 3
    assert np.abs(ahead @ normal - off).max() < 0.1
