"""When plan or camera are in doubt, and when not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from floor_masks import mask_of, rectangle, small_camera

from floornav_common.se2 import SE2
from multi_localizer.floor_fitter import FloorFit, FloorShapeFitter
from multi_localizer.floor_misfit import FloorMisfit, oddness
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.pose_estimate import PoseEstimate

GOOD = FloorFit((PoseEstimate(SE2.identity(), np.eye(3)),), 300, 0.35, 0.2, "", 0.6, (0.2,))
SCATTERED, BESIDE = replace(GOOD, residual_px=0.8), replace(GOOD, offset_px=-2.5)
HIDDEN, BEHIND = replace(GOOD, costs=(0.62,)), replace(GOOD, costs=(0.1,), first_cost=0.25)
NONE = FloorFit((), 40, 1.4, 0.8, "80% of the directions show no wall of the plan")
COVERED = FloorFit((), 0, float("nan"), 1.0, "only 0 pixels of the floor's border are seen")


def after(fits, period_s=0.1):
    misfit = FloorMisfit()
    for k, fit in enumerate(fits):
        misfit.note(int(k * period_s * 1e9), fit)
    return misfit.reason


@pytest.mark.parametrize(
    ("odd", "words"),
    [
        (SCATTERED, "scattered"),
        (BESIDE, "beside"),
        (HIDDEN, "little of"),
        (NONE, "no pose"),
        (BEHIND, "behind the plan's walls"),
    ],
)
def test_five_seconds_of_odd_masks_are_said_with_what_may_be_wrong(odd, words):
    assert after([odd] * 49) == ""
    reason = after([odd] * 52)
    assert words in reason and "`plan`" in reason and "camera_model" in reason


def test_good_masks_and_covered_ones_raise_no_doubt():
    assert after([GOOD] * 100) == ""
    assert after([COVERED] * 100) == ""
    assert after([GOOD, SCATTERED] * 50) == ""
    assert after([SCATTERED] * 6, period_s=1.0) == ""  # too few to say


def test_doubt_ends_when_half_of_the_masks_fit_again_not_before():
    assert after([BESIDE] * 60 + [GOOD] * 20) != ""
    assert after([BESIDE] * 60 + [GOOD] * 30) == ""


def test_a_clock_that_jumps_back_begins_anew():
    misfit = FloorMisfit()
    for k in range(60):
        misfit.note(10**10 + k * 10**8, BESIDE)
    assert misfit.reason
    misfit.note(10**8, GOOD)
    assert misfit.reason == ""


def test_masks_of_the_right_floor_are_not_odd_and_those_of_another_camera_are():
    camera, plan, pose = small_camera(), rectangle(2.74, 1.525), SE2(0.3, 0.1, 0.5)
    mask = mask_of(camera, plan, pose)
    assert oddness(FloorShapeFitter(camera, plan).fit(mask)) == ""
    higher = replace(camera, height_m=1.3 * camera.height_m)
    assert oddness(FloorShapeFitter(higher, plan).fit(mask))
    assert oddness(FloorShapeFitter(camera, rectangle(3.4, 1.9)).fit(mask))


def test_floor_where_the_plan_has_a_corner_less_is_odd():
    camera, whole = small_camera(), rectangle(2.74, 1.525)
    x, y = 1.37, 0.7625
    less = FloorPlan(np.array([[x, -y], [x, 0.3], [0.9, 0.3], [0.9, y], [-x, y], [-x, -y]]))
    for pose in (SE2(0.0, -0.2, 0.4), SE2(0.4, -0.5, 1.4), SE2(-0.5, 0.2, 3.0)):
        assert "behind" in oddness(FloorShapeFitter(camera, less).fit(mask_of(camera, whole, pose)))
        assert oddness(FloorShapeFitter(camera, less).fit(mask_of(camera, less, pose))) == ""
