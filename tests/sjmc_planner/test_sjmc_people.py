"""Who sets the speed along a course, and how long they are waited for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sjmc_scenes import people_scene

from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_people import Patience, bystander_in_reach, people_in_the_way
from sjmc_planner.sjmc_scene import Scene

FRONT, HALF = 0.2, 0.35
CONFIG = SjmcConfig(danger_m=1.0, caution_m=4.0, aware_s=1.0, side_speed_m_s=0.5)


def in_the_way(scene: Scene, course: float = 0.0, judged: tuple[int, ...] = ()):
    is_judged = np.isin(np.arange(len(scene.people)), judged)
    return people_in_the_way(course, scene, is_judged, FRONT, HALF, CONFIG)


def test_who_stands_in_the_way_sets_the_speed_by_eq_3_5() -> None:
    """2.45 m ahead: 2 m from front to body; t_aware 0.5 s, 0.6 m to the edge at 0.5 m/s."""
    ahead = in_the_way(people_scene((2.45, 0.0, 0.0, 0.0)))
    assert (ahead.who, ahead.is_stable) == (0, True)
    assert ahead.distance == pytest.approx(2.0)
    assert ahead.bound == pytest.approx(1.0 / (0.5 + 1.2))


def test_who_walks_out_of_the_way_sets_the_speed_by_eq_3_7() -> None:
    """0.1 m left of the middle, to the left at 0.5 m/s: 0.5 m to the edge, 1 s; 0.3 m/s nearer."""
    ahead = in_the_way(people_scene((2.45, 0.1, -0.3, 0.5)))
    assert (ahead.who, ahead.is_stable) == (0, False)
    assert ahead.bound == pytest.approx(1.0 / 1.0 - 0.3)


def test_who_walks_across_has_the_whole_way_to_go() -> None:
    ahead = in_the_way(people_scene((2.45, 0.1, 0.0, -0.5)))
    assert ahead.bound == pytest.approx(1.0 / (0.7 / 0.5))


def test_nobody_in_the_strip_is_nobody_in_the_way() -> None:
    scene = people_scene((2.0, 0.61, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0), (4.6, 0.0, 0.0, 0.0))
    assert in_the_way(scene).who == -1 and in_the_way(scene).bound == math.inf
    assert in_the_way(scene, course=math.atan2(0.61, 2.0)).who == 0


def test_of_several_the_one_that_allows_least_counts() -> None:
    ahead = in_the_way(people_scene((3.5, 0.0, 0.0, 0.0), (2.0, 0.1, 0.0, 0.0)))
    assert ahead.who == 1


def test_who_is_judged_stands_for_a_thing_until_they_walk() -> None:
    assert in_the_way(people_scene((2.0, 0.0, 0.0, 0.0)), judged=(0,)).who == -1
    assert in_the_way(people_scene((2.0, 0.0, 0.0, 0.5)), judged=(0,)).who == 0


def test_a_mirrored_person_allows_the_same() -> None:
    left = in_the_way(people_scene((2.2, 0.2, -0.3, 0.4)), course=0.1)
    right = in_the_way(people_scene((2.2, -0.2, -0.3, -0.4)), course=-0.1)
    assert left == right


def test_a_bystander_is_come_up_to_slowly_and_others_are_not_minded() -> None:
    """By hand, in corners of 3, 4, 5: 1.2 m ahead of the front and 0.9 m beside the strip, less
    the body of 0.25 m are 1.25 m; (1.25 - 1) m in 1.4 s. Slowest at the line.
    """
    known = np.zeros(1, bool)
    args = known, FRONT, HALF, CONFIG
    there = (FRONT + 1.2, HALF + 0.9, 0.0, 0.0)
    speed, who = bystander_in_reach(0.0, people_scene(there), *args)
    assert (speed, who) == (pytest.approx(0.25 / 1.4), 0)
    for person in ((2.45, 0.0, 0.0, 0.0), (2.45, 1.6, 0.0, 0.0), (2.45, 0.8, 0.5, 0.0)):
        assert bystander_in_reach(0.0, people_scene(person), *args) == (math.inf, -1)
    at_line = bystander_in_reach(0.0, people_scene((FRONT + 1.0, HALF + 0.7, 0.0, 0.0)), *args)
    assert at_line == (CONFIG.bystander_end_m_s, 0)
    close = bystander_in_reach(0.0, people_scene((0.6, 0.8, 0.0, 0.0)), *args)
    assert close == (CONFIG.bystander_pass_m_s, 0)


@given(angle=st.floats(0.4, 1.0), off=st.floats(1.0, 1.4))
def test_a_bystander_as_far_off_allows_the_same_wherever_ahead(angle: float, off: float) -> None:
    """The line lies around the front: not along the way alone, which drifts."""
    known = np.zeros(1, bool)
    x, y = FRONT + off * math.cos(angle), HALF + off * math.sin(angle)
    bound, who = bystander_in_reach(
        0.0, people_scene((x, y, 0.0, 0.0)), known, FRONT, HALF, replace(CONFIG, bystander_m=3.0)
    )
    room = off - 0.25 - CONFIG.bystander_line_m
    slowest = CONFIG.bystander_end_m_s if room > -0.17 else CONFIG.bystander_pass_m_s
    assert who == 0 and bound == pytest.approx(max(room / CONFIG.bystander_s, slowest))


@given(x=st.floats(0.8, 4.0), y=st.floats(0.62, 1.4))
def test_without_patience_it_comes_faster_to_the_line_and_is_as_slow_there(
    x: float, y: float
) -> None:
    args = people_scene((x, y, 0.0, 0.0)), np.zeros(1, bool), FRONT, HALF, CONFIG
    bound, who = bystander_in_reach(0.0, *args)
    spent, _ = bystander_in_reach(0.0, *args, True)
    assert spent >= bound
    gap = math.hypot(max(x - FRONT, 0.0), max(y - HALF, 0.0)) - 0.25
    if who >= 0 and gap < CONFIG.bystander_line_m:
        assert spent == bound <= CONFIG.bystander_pass_m_s


def test_patience_with_one_ends_and_is_whole_again_after_a_rest() -> None:
    patience, scene = Patience(SjmcConfig(patience_s=0.3), 0.1), people_scene((2.0, 0.0, 0.0, 0.0))
    waited = []
    for _ in range(3):
        patience.begin(scene, 0.0)
        waited.append(patience.wait(7))
    assert waited == pytest.approx([0.1, 0.2, 0.3])
    assert patience.is_out(waited[-1]) and not patience.is_out(waited[-2])
    for _ in range(12):
        patience.begin(scene, 0.0)
    assert patience.wait(7) == pytest.approx(0.1)


def test_a_judgment_holds_until_the_person_walks_or_is_gone() -> None:
    patience = Patience(CONFIG, 0.1)
    standing, walking = people_scene((2.0, 0.0, 0.0, 0.0)), people_scene((2.0, 0.0, 0.0, 0.6))
    patience.begin(standing, 0.0)
    patience.judge(7)
    assert patience.begin(standing, 0.0).tolist() == [True]
    assert patience.begin(walking, 0.0).tolist() == [False]
    assert patience.begin(standing, 0.0).tolist() == [False]


def test_who_left_the_way_is_no_bystander_and_who_comes_back_is() -> None:
    patience = Patience(CONFIG, 0.1)
    patience.begin(people_scene((2.0, 0.8, 0.0, 0.6)), 0.0)
    beside = people_scene((2.0, 0.9, 0.0, 0.0))
    patience.begin(beside, 0.0)
    assert patience.known(beside).tolist() == [True]
    patience.begin(people_scene((2.0, 0.9, 0.0, -0.6)), 0.0)
    assert patience.known(beside).tolist() == [False]


def test_patience_with_bystanders_has_an_end_for_all_of_them() -> None:
    patience = Patience(SjmcConfig(bystander_patience_s=0.3), 0.1)
    for _ in range(3):
        assert not patience.is_spent
        patience.mind(True)
    assert patience.is_spent
    for _ in range(5):
        patience.mind(False)
    assert not patience.is_spent
