"""Zones, and which course is taken."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjmc_planner.sjmc_course import courses, nearest_open, preferred
from sjmc_planner.sjmc_zones import CAUTION, DANGER, SAFETY, zone_of


def test_the_borders_of_the_zones_belong_to_the_inner_one() -> None:
    zones = [zone_of(d, 1.9, 4.0) for d in (0.0, 1.9, 1.91, 4.0, 4.01)]
    assert zones == [DANGER, DANGER, CAUTION, CAUTION, SAFETY]


def test_courses_begin_at_the_target_and_spread() -> None:
    found = courses(0.1, 0.2, 0.5)
    assert found == pytest.approx([0.1, 0.3, -0.1, 0.5, -0.3])
    assert np.abs(courses(3.0, 0.2, 0.5)).max() <= math.pi


def test_the_open_course_nearest_the_target_is_taken() -> None:
    assert nearest_open(np.array([5.0, 5.0, 5.0]), 1.9) == 0
    assert nearest_open(np.array([1.0, 1.0, 2.0, 9.0, 9.0]), 1.9) == 2
    assert nearest_open(np.array([1.0, 1.5, 1.0]), 1.9) == -1


def test_of_two_as_far_off_the_freer_is_taken() -> None:
    assert nearest_open(np.array([1.0, 2.0, 3.0]), 1.9) == 2
    assert nearest_open(np.array([1.0, 3.0, 2.0]), 1.9) == 1


def test_the_side_taken_before_is_kept_for_a_while() -> None:
    bearings = courses(0.0, 0.2, 0.8)
    free = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0])
    assert preferred(bearings, 0.0, free, 0)[:3].tolist() == [0, 2, 1]
    left_first = preferred(bearings, 0.0, free, 1)
    assert left_first[:3].tolist() == [0, 1, 3]
    is_left = left_first % 2 == 1
    assert np.argmax(~is_left[1:]) + 1 == 4  # 0.5 rad are two and a half steps


def test_mirrored_ways_are_taken_in_mirrored_order() -> None:
    rng = np.random.default_rng(0)
    bearings = courses(0.0, 0.1, 1.0)
    free = rng.uniform(0.0, 3.0, len(bearings))
    swap = np.concatenate(([0], np.arange(1, len(bearings)).reshape(-1, 2)[:, ::-1].ravel()))
    order = preferred(bearings, 0.0, free, 1)
    mirrored = preferred(bearings, 0.0, free[swap], -1)
    assert swap[mirrored].tolist() == order.tolist()
