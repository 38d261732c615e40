"""Views, motion and what of them is given."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig, LandmarkTimeConfig, LandmarkTrackConfig
from multi_localizer.landmark_fit import Sighting
from multi_localizer.landmark_localizer import LandmarkLocalizer
from multi_localizer.landmark_locator import LandmarkLocator
from multi_localizer.landmark_views import LandmarkViews
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate, difference

PLACES = ((3.0, 1.0), (-3.0, 1.2), (-2.5, -1.5), (2.0, -1.8), (0.3, 2.4))
POSTS = {f"post{k}": (Landmark((place,)),) for k, place in enumerate(PLACES)}
POLES = {"pole": tuple(Landmark(((x, y),)) for x in (-2.0, 2.0) for y in (-2.0, 2.0))}
T_BASE_SENSOR, STEP = SE2(0.1, 0.0, 0.5), SE2(0.05, 0.0, 0.05)
TOL_M = 1e-3


def bearings_at(sensor, places):
    x, y = (sensor.inverse() @ np.array(places)).T
    return np.arctan2(y, x)


def views_from(base):
    bearings = bearings_at(base @ T_BASE_SENSOR, PLACES)
    return {kind: (np.array([b]), T_BASE_SENSOR) for kind, b in zip(POSTS, bearings, strict=True)}


def test_the_pose_of_base_link_comes_once_three_views_in_a_row_have_shown_it():
    localizer = LandmarkLocalizer(LandmarkViews(POSTS, LandmarkConfig()), LandmarkTrackConfig())
    base, odom, given = SE2(0.5, -0.3, 1.0), SE2(7.0, 1.0, 0.0), []
    for k in range(5):
        answer = localizer.take(k * 100_000_000, views_from(base), None, None, odom)
        given.append(answer.pose)
        assert bool(answer.why_not) == (answer.pose is None)
        if answer.pose is not None:
            assert np.abs(difference(answer.pose.pose, base)).max() < TOL_M
        base, odom = base @ STEP, odom @ STEP
    assert [pose is None for pose in given] == [True, True, False, False, False]
    assert answer.num_seen == dict.fromkeys(POSTS, 1)


def test_new_values_reach_views_and_track():
    localizer = LandmarkLocalizer(LandmarkViews(POSTS, LandmarkConfig()), LandmarkTrackConfig())
    localizer.reconfigure(LandmarkTimeConfig(track=LandmarkTrackConfig(settle_views=1)))
    localizer.reconfigure(LandmarkConfig(min_spare=3))
    refused = localizer.take(0, views_from(SE2(0.5, -0.3, 1.0)), None, None, None)
    assert "3 more to confirm" in refused.fix.problem
    localizer.reconfigure(LandmarkConfig())
    assert localizer.take(1, views_from(SE2(0.5, -0.3, 1.0)), None, None, None).pose is not None


def test_of_poses_that_fit_alike_the_expected_one_is_taken():
    """Four like poles at the corners of a square look the same from four poses."""
    config, pose = LandmarkConfig(), SE2(0.5, 0.2, 0.4)
    locator = LandmarkLocator(POLES, config)
    places = [mark.corners[0] for mark in POLES["pole"]]
    seen = [Sighting("pole", float(b), 0.01) for b in bearings_at(pose, places)]
    assert "ambiguous" in locator.locate(seen).problem
    near = PoseEstimate(SE2(0.55, 0.15, 0.45), np.diag([0.1, 0.1, 0.1]) ** 2)
    found = locator.locate(seen, near).estimate
    assert np.abs(difference(found.pose, pose)).max() < TOL_M
    turned = SE2(0.0, 0.0, math.pi / 2.0)
    mate = PoseEstimate(turned @ near.pose, near.cov)
    assert np.abs(difference(locator.locate(seen, mate).estimate.pose, turned @ pose)).max() < TOL_M
    nowhere = PoseEstimate(SE2(3.0, 3.0, 0.0), near.cov)
    assert "ambiguous" in locator.locate(seen, nowhere).problem
