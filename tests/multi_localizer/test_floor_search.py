"""Starts of the fit when nothing, or only the way along a wall, is unknown."""

from __future__ import annotations

import math

import numpy as np
from floor_masks import ell, mask_of, rectangle, small_camera

from floornav_common.se2 import SE2
from multi_localizer.floor_rays import BorderScanner
from multi_localizer.floor_search import MAX_PLACES, SPACING_M, places_of, search, slides

CAMERA = small_camera()


def walls_of(plan):
    return np.column_stack((plan.corners, plan.tangents, plan.normals, plan.offsets, plan.lengths))


def border_of(plan, pose):
    return BorderScanner(CAMERA, 1.02 * plan.reach).scan(mask_of(CAMERA, plan, pose)).values


def test_places_lie_on_the_floor_and_are_not_too_many():
    for plan in (ell(), rectangle(30.0, 20.0)):
        places = places_of(plan)
        assert all(plan.contains(x, y) for x, y in places)
        assert 10 < len(places) <= 1.2 * MAX_PLACES


def test_the_first_starts_lie_near_the_truth():
    plan, pose = ell(), SE2(-0.5, 0.3, 1.0)
    starts = search(border_of(plan, pose), walls_of(plan), places_of(plan))
    apart = [math.hypot(s[0] - pose.x, s[1] - pose.y) for s in starts]
    assert min(apart) < SPACING_M


def test_a_pose_slid_along_the_walls_finds_its_way_back():
    plan, pose = rectangle(2.74, 1.525), SE2(0.4, 0.2, 0.3)
    values = border_of(plan, pose)
    slid = pose.as_array() + (-0.7, 0.0, 0.0)
    starts = slides(values, walls_of(plan), slid, 0.0, plan.reach)
    assert min(math.hypot(s[0] - pose.x, s[1] - pose.y) for s in starts) < 0.06
