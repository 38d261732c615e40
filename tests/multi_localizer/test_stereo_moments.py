"""Moments: which cameras a localizer is made for, and which motion it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer import stereo_moments
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_moments import StereoMoments
from multi_localizer.stereo_pose import StereoHypothesis, StereoPose, StereoState
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera

FRONT = ViewCamera(320, 240, 280.0, 0.1, 1.0)
REAR = ViewCamera(320, 240, 280.0, 0.1, 1.0, yaw=3.1)
SECOND = 1_000_000_000


class Localizer:
    """Notes what it is told."""

    made: list[Localizer] = []  # noqa: RUF012

    def __init__(self, voxels, cameras, config, num_threads=1):
        self.cameras, self.told, self.num_resets = cameras, [], 0
        self.tuning, self.near, self.pose = [], [], None
        self.made.append(self)

    def reset(self):
        self.num_resets += 1

    def reconfigure(self, config):
        self.tuning.append(config)

    def relocate(self, told):
        self.near.append(told)

    def track(self, views, motion, dt):
        self.told.append((views, motion, dt))
        if self.pose is None:
            return StereoPose(StereoState.LOST, (), "lost")
        estimate = PoseEstimate(self.pose, np.eye(3))
        return StereoPose(StereoState.KNOWN, (StereoHypothesis(estimate, 1.0, 0.1),))


@pytest.fixture
def moments(monkeypatch):
    monkeypatch.setattr(stereo_moments, "StereoLocalizer", Localizer)
    Localizer.made = []
    occupied = np.ones((1, 2, 2), dtype=bool)
    voxels = VoxelMap(np.zeros((1, 2, 2, 3), np.uint8), occupied, 1.0, 1.0)
    return StereoMoments(voxels, StereoLocalizerConfig(), ("front", "rear"), 2 * SECOND)


def test_both_pairs_at_once_begin_at_once(moments):
    found = moments.locate(0, {"rear": REAR, "front": FRONT}, {"front": 1, "rear": 2}, None)
    assert found is not None and Localizer.made[0].cameras == [FRONT, REAR]
    assert Localizer.made[0].told[0][0] == [1, 2]


def test_one_pair_waits_for_the_other_and_then_goes_on_alone(moments):
    assert moments.locate(0, {"front": FRONT}, {"front": 1}, None) is None
    assert moments.locate(SECOND, {"front": FRONT}, {"front": 1}, None) is None
    assert moments.locate(2 * SECOND, {"front": FRONT}, {"front": 1}, None) is not None
    assert Localizer.made[0].cameras == [FRONT]
    both = {"front": FRONT, "rear": REAR}
    assert moments.locate(3 * SECOND, both, {"front": 1, "rear": 2}, None) is not None
    assert [m.cameras for m in Localizer.made] == [[FRONT], [FRONT, REAR]]
    assert moments.locate(4 * SECOND, {"rear": REAR}, {"rear": 2}, None) is not None
    assert Localizer.made[1].told[1][0] == [None, 2] and len(Localizer.made) == 2


def test_a_camera_mounted_anew_begins_anew_and_a_hair_does_not(moments):
    both = {"front": FRONT, "rear": REAR}
    moments.locate(0, both, {"front": 1}, None)
    moments.locate(SECOND, {"front": replace(FRONT, x_m=1e-5)}, {"front": 1}, None)
    assert len(Localizer.made) == 1
    moments.locate(2 * SECOND, {"front": replace(FRONT, x_m=0.1)}, {"front": 1}, None)
    assert len(Localizer.made) == 2 and Localizer.made[1].told[0][1:] == (SE2.identity(), 0.0)


def test_the_motion_is_odometrys_between_the_moments(moments):
    both, views = {"front": FRONT, "rear": REAR}, {"front": 1}
    here, there = SE2(1.0, 2.0, 0.5), SE2(1.3, 2.1, 0.7)
    moments.locate(0, both, views, here)
    moments.locate(SECOND // 2, both, views, there)
    moments.locate(SECOND, both, views, None)
    told = Localizer.made[0].told
    assert told[0][1:] == (SE2.identity(), 0.0)
    expected = here.inverse() @ there
    assert (told[1][1].x, told[1][1].y, told[1][1].yaw) == pytest.approx(
        (expected.x, expected.y, expected.yaw)
    )
    assert told[1][2] == pytest.approx(0.5) and told[2][1:] == (None, 0.5)


def test_a_stamp_that_jumps_back_begins_anew_and_new_tuning_does_not(moments):
    both, views = {"front": FRONT, "rear": REAR}, {"front": 1}
    moments.locate(SECOND, both, views, SE2(0.0, 0.0, 0.0))
    moments.locate(0, both, views, SE2(9.0, 0.0, 0.0))
    assert Localizer.made[0].num_resets == 1 and Localizer.made[0].told[1][2] == 0.0
    tuned = StereoLocalizerConfig(num_kept=7)
    moments.reconfigure(tuned)
    moments.locate(SECOND, both, views, None)
    assert len(Localizer.made) == 1 and Localizer.made[0].tuning == [tuned]


def test_where_somebody_says_the_robot_is_waits_for_the_first_views(moments):
    told = PoseEstimate(SE2(1.0, 0.0, 0.0), np.eye(3))
    moments.relocate(told)
    moments.locate(0, {"front": FRONT, "rear": REAR}, {"front": 1}, None)
    moments.locate(SECOND, {"front": FRONT, "rear": REAR}, {"front": 1}, None)
    assert Localizer.made[0].near == [told]


def test_a_pose_that_does_not_follow_from_the_last_is_said_and_one_that_does_is_not(moments):
    both, views = {"front": FRONT, "rear": REAR}, {"front": 1}
    moments.locate(0, both, views, SE2.identity())
    for k, (odometry, pose) in enumerate(
        [(0.0, 5.0), (0.6, 5.6), (0.7, None), (1.6, 6.6)], start=1
    ):
        Localizer.made[0].pose = None if pose is None else SE2(pose, 0.0, 0.0)
        moments.locate(k * SECOND, both, views, SE2(odometry, 0.0, 0.0))
    assert moments.take_news() == ""
    Localizer.made[0].pose = SE2(6.6, 1.7, np.pi)
    moments.locate(9 * SECOND, both, views, SE2(1.6, 0.0, 0.0))
    assert moments.take_news().startswith("found again 1.70 m and 180 degrees from")
    assert moments.take_news() == ""
