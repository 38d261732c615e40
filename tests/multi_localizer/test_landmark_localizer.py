"""Views, motion and what of them is given."""

from __future__ import annotations

import math

import numpy as np
import pytest

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
GOAL = (3.0, 0.0)
FIELD = POLES | {"goal": (Landmark((GOAL,)),)}
QUARTER = SE2(0.0, 0.0, math.pi / 2.0)


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


class Field:
    """Four like poles, which look the same from four poses, and a goal that may be hidden."""

    def __init__(self) -> None:
        views = LandmarkViews(FIELD, LandmarkConfig())
        self.localizer = LandmarkLocalizer(views, LandmarkTrackConfig())
        self.pose, self.odom, self.num = SE2(0.5, 0.2, 0.3), SE2(7.0, 1.0, 0.0), 0

    def pass_by(self, num: int) -> None:
        """Let views pass in which nothing is seen at all."""
        self.num += num

    def look(self, has_goal: bool) -> str:
        """Take a view; return what is right about the pose given: "right", "wrong" or "none"."""
        self.num += 1
        poles = bearings_at(self.pose, [mark.corners[0] for mark in POLES["pole"]])
        goal = bearings_at(self.pose, [GOAL]) if has_goal else np.zeros(0)
        seen = {"pole": (poles, SE2.identity()), "goal": (goal, SE2.identity())}
        answer = self.localizer.take(self.num * 100_000_000, seen, None, None, self.odom)
        if answer.pose is None:
            return "none"
        off = np.abs(difference(answer.pose.pose, self.pose)).max()
        return "right" if off < TOL_M else "wrong"

    def drive(self, num: int, has_goal: bool) -> list[str]:
        """Drive as odometry says."""
        said = []
        for _ in range(num):
            said.append(self.look(has_goal))
            self.pose, self.odom = self.pose @ STEP, self.odom @ STEP
        return said


def test_once_a_goal_has_told_like_poses_apart_the_motion_does():
    field = Field()
    assert field.drive(4, has_goal=False) == ["none"] * 4
    assert field.drive(5, has_goal=True)[2:] == ["right"] * 3
    assert field.drive(12, has_goal=False) == ["right"] * 12


@pytest.mark.parametrize("turn", [QUARTER, QUARTER @ QUARTER])
@pytest.mark.parametrize("num_covered", [6, 30])
def test_covered_and_set_down_at_a_pose_that_fits_alike_gives_none_before_a_goal(turn, num_covered):
    field = Field()
    field.drive(5, has_goal=True)
    field.pass_by(num_covered)
    field.pose = turn @ field.pose
    assert field.drive(12, has_goal=False) == ["none"] * 12
    assert field.drive(8, has_goal=True)[-1] == "right"
    assert field.drive(4, has_goal=False) == ["right"] * 4


@pytest.mark.parametrize("num_steps", [4, 10])
def test_pushed_round_in_view_to_a_pose_that_fits_alike_gives_none_before_a_goal(num_steps):
    field = Field()
    field.drive(5, has_goal=True)
    before = field.pose
    for k in range(num_steps):
        turn = SE2(0.0, 0.0, (k + 1) / num_steps * math.pi / 2.0)
        field.pose = turn @ before
        assert field.look(has_goal=False) != "wrong"
    assert field.drive(12, has_goal=False) == ["none"] * 12
    assert field.drive(8, has_goal=True)[-1] == "right"


def test_one_view_of_another_pose_leaves_the_motion_its_word():
    field = Field()
    field.drive(5, has_goal=True)
    pose, field.pose = field.pose, field.pose @ SE2(0.5, 0.0, 0.5)
    assert field.look(has_goal=False) == "none"
    field.pose = pose
    assert field.look(has_goal=False) == "right"
