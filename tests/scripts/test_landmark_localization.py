"""The landmark experiment: how it judges, and that its pictures show what stands there."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

import experiments.landmark_faults as faults
from experiments.landmark_localization import Tally, _published_2
from experiments.landmark_views_sim import FieldEye, measured_bearing_sd
from floornav_common.se2 import SE2
from multi_localizer.landmark_config import LandmarkConfig
from multi_localizer.landmark_fit import Sighting
from multi_localizer.landmark_locator import LandmarkFix
from multi_localizer.landmark_views import LandmarkViews
from multi_localizer.landmarks import load_landmarks, positions
from multi_localizer.pose_estimate import PoseEstimate, difference

FIELD = load_landmarks("middle_size_field")
POSE = SE2(1.0, -0.7, 0.6)


def test_errors_are_mean_absolute_ones_in_the_papers_units() -> None:
    tally = Tally("any", (284.0, 292.0, 15.0))
    cov = np.diag([0.1, 0.1, 0.1]) ** 2
    for x, yaw in ((0.1, 0.02), (-0.3, -0.04)):
        found = PoseEstimate(SE2(1.0 + x, 2.0, 0.5 + yaw), cov)
        tally.add_fix(SE2(1.0, 2.0, 0.5), LandmarkFix(found))
    tally.add_fix(SE2(1.0, 2.0, 0.5), LandmarkFix(None, "none"))
    figures = tally.figures()
    assert (figures["poses"], figures["refused"], figures["paper_y_mm"]) == (2, 1, 292.0)
    assert figures["mean_x_mm"] == pytest.approx(200.0)
    assert figures["rms_x_mm"] == pytest.approx(math.sqrt(0.5 * (100.0**2 + 300.0**2)))
    assert figures["mean_theta_deg"] == pytest.approx(math.degrees(0.03))
    assert figures["nees"] == pytest.approx(0.5 * (1.0 + 0.04 + 9.0 + 0.16))


def test_method_2_as_published_takes_the_nearer_goal() -> None:
    points = positions(FIELD)
    seen = []
    for kind, places in points.items():
        ((x, y),) = POSE.inverse() @ places
        wrong = 2.0 if kind.startswith("goal_blue") else 1.0  # the farther goal
        seen.append(Sighting(kind, math.atan2(y, x), 0.004, wrong * math.hypot(x, y), 0.1))
    near = _published_2(seen, points, 1)
    assert difference(near, POSE) == pytest.approx(np.zeros(3), abs=1e-9)
    assert abs(difference(_published_2(seen, points, 2), POSE)[0]) > 0.1


def test_a_view_shows_the_posts_where_they_are_and_gives_the_pose() -> None:
    eye = FieldEye(seed=0)
    view = eye.view(POSE, 1)
    place = np.array([POSE.x, POSE.y])
    for kind, (mark,) in FIELD.items():
        x, y = mark.point_seen(place) - place
        (bearing,) = view.bearings[kind]
        off = math.remainder(math.atan2(y, x) - POSE.yaw - bearing, 2.0 * math.pi)
        assert abs(off) < math.radians(1.5)
    for camera in (None, eye.camera):
        fix = LandmarkViews(FIELD, LandmarkConfig(), camera).locate(view.bearings, view.mask)
        assert fix.estimate is not None
        assert np.abs(difference(fix.estimate.pose, POSE)).max() < 0.2


def test_the_deviation_of_bearings_is_measured_and_small() -> None:
    """Half a pixel at the edge of the mirror's image is a little less than 0.01 rad."""
    sd = measured_bearing_sd(1000, num_views=5)
    assert 0.001 < sd < 0.01
    assert measured_bearing_sd(1001, num_views=5) != sd


def test_faults_tell_what_a_spare_bearing_is_good_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "VIEWS", 40)
    monkeypatch.setattr(faults, "CASES", ((3, 0), (3, 1), (4, 1)))
    none, refused, one = faults.fault_rows(0, LandmarkConfig())
    assert refused["sent_share"] == refused["false_sent_share"] == 0.0
    assert none["wrong_share"] > 0.3 and none["wrong_share"] > 2.0 * one["wrong_share"]
    assert one["sent_share"] > 0.9


def test_views_that_confirm_each_other_send_fewer_wrong_poses_than_each_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kinds = faults.KINDS
    monkeypatch.setattr(faults, "DRIVE_CASES", ((4, kinds[0]), (4, kinds[1])))
    none, false = faults.drive_rows(0, LandmarkConfig(), 8)
    settling = 2 / faults.VIEWS_A_DRIVE  # the first two views of a drive send no pose
    assert none["given_share"] == 1.0 and none["wrong_share"] == 0.0
    assert none["sent_share"] == pytest.approx(1.0 - settling, abs=0.05)
    assert false["alone_wrong_share"] > 0.05
    assert false["wrong_share"] < 0.2 * false["alone_wrong_share"]
