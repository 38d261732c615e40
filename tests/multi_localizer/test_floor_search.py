"""Starts of the fit when nothing, or only the way along a wall, is unknown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_masks import ell, mask_of, rectangle, small_camera

from floornav_common.se2 import SE2
from multi_localizer.floor_rays import BorderScanner
from multi_localizer.floor_search import (
    APART,
    MAX_PLACES,
    NUM_STARTS,
    SPACING_M,
    PlanSearch,
    places_of,
    slides,
)
from multi_localizer.floor_walls import walls_of
from multi_localizer.pose_estimate import difference

CAMERA = small_camera()


def border_of(plan, pose):
    return BorderScanner(CAMERA, 1.02 * plan.reach).scan(mask_of(CAMERA, plan, pose)).values


def test_places_lie_on_the_floor_and_are_not_too_many():
    for plan in (ell(), rectangle(30.0, 20.0)):
        places = places_of(plan)
        assert all(plan.contains(x, y) for x, y in places)
        assert 10 < len(places) <= 1.2 * MAX_PLACES


@pytest.mark.parametrize("plan", [ell(), rectangle(2.74, 1.525), rectangle(1.6, 1.6)])
def test_the_first_start_lies_near_the_truth_or_what_a_symmetry_makes_of_it(plan):
    rng = np.random.default_rng(0)
    for x, y, yaw in rng.uniform((-0.7, -0.5, -3.0), (-0.1, 0.1, 3.0), (6, 3)):
        pose = SE2(float(x), float(y), float(yaw))
        first = PlanSearch(plan).starts(border_of(plan, pose))[0]
        mates = [difference(s @ pose, SE2(*first)) for s in plan.symmetries]
        assert any(math.hypot(dx, dy) < SPACING_M and abs(dyaw) < 0.1 for dx, dy, dyaw in mates)


def test_starts_are_few_and_lie_apart_also_when_turned_by_a_symmetry():
    plan = rectangle(2.74, 1.525)
    starts = PlanSearch(plan).starts(border_of(plan, SE2(0.1, 0.0, 1.0)))
    assert 1 < len(starts) <= NUM_STARTS
    for k, start in enumerate(starts):
        for other in starts[:k]:
            for motion in plan.symmetries:
                x, y, yaw = difference(motion @ SE2(*start), SE2(*other))
                # A step of the grid of yaws may be cut off.
                assert math.hypot(x, y) >= APART[0] or abs(yaw) > APART[1] - 0.1


def test_without_border_there_is_no_start():
    assert PlanSearch(ell()).starts(np.empty((0, 7))).shape == (0, 3)


def test_a_pose_slid_along_the_walls_finds_its_way_back():
    plan, pose = rectangle(2.74, 1.525), SE2(0.4, 0.2, 0.3)
    values = border_of(plan, pose)
    slid = pose.as_array() + (-0.7, 0.0, 0.0)
    starts = slides(values, walls_of(plan), slid, 0.0, plan.reach)
    assert min(math.hypot(s[0] - pose.x, s[1] - pose.y) for s in starts) < 0.06
