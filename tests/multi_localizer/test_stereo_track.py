"""Following: odometry that is right, wrong or missing, places that look alike, covered views."""

import numpy as np
import pytest
from located import POSES, SMALL, assert_at, blind_views
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import normalized_error
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState

TOL_M = 0.03


@pytest.fixture(scope="module")
def voxels():
    return room()


@pytest.fixture(scope="module")
def localizer(voxels):
    return StereoLocalizer(voxels, CAMERAS, StereoLocalizerConfig(**SMALL))


@pytest.fixture(scope="module")
def marked():
    """A twofold room with a mark that is not seen from every pose."""
    twofold = room(is_twofold=True)
    color = twofold.color.copy()
    color[4:12, 100:120, -1] = (255, 0, 255)
    return type(twofold)(color, twofold.occupied, 0.02, 0.16, 0.0, 0.0, -0.16)


def drive(localizer, voxels, poses, odometry_scale=1.0, dt=0.1):
    """Track along poses; yields what is found with the true pose. Scale None: no odometry."""
    before = poses[0]
    for k, pose in enumerate(poses):
        motion = before.between(pose)
        told = None
        if odometry_scale is not None:
            told = SE2(odometry_scale * motion.x, motion.y, odometry_scale * motion.yaw)
        yield localizer.track(views_at(voxels, pose, noise_px=0.3, seed=k), told, dt), pose
        before = pose


def arc(start, num, step_m=0.05, turn=0.04):
    poses = [start]
    for _ in range(num - 1):
        poses.append(poses[-1] @ SE2(step_m, 0.0, turn))
    return poses


def test_tracking_follows_though_odometry_is_wrong_by_a_tenth(localizer, voxels):
    localizer.reset()
    for found, pose in drive(localizer, voxels, arc(SE2(1.5, 1.0, 0.3), 15), 0.9):
        assert found.state is StereoState.KNOWN
        assert_at(found, pose, 0.03, 0.02)


@pytest.mark.parametrize("scale", [0.0, 0.4, 1.6, None])
def test_wheels_that_slip_and_no_odometry_never_make_a_wrong_pose_known(localizer, voxels, scale):
    localizer.reset()
    num_known = 0
    for found, pose in drive(localizer, voxels, arc(SE2(1.2, 0.9, 0.2), 20), scale):
        if found.state is StereoState.KNOWN:
            num_known += 1
            assert_at(found, pose, TOL_M, 0.03)
            assert normalized_error(found.pose, pose, found.cov) < 30.0
    assert num_known >= 18


def test_slipping_wheels_are_told(localizer, voxels):
    localizer.reset()
    said = [f.reason for f, _ in drive(localizer, voxels, arc(SE2(1.2, 0.9, 0.2), 12, 0.08), 0.0)]
    assert any("the views contradict the motion" in reason for reason in said)


def test_tracking_settles_what_looks_alike_once_it_is_told_apart(marked):
    away = SE2(1.9, 1.2, np.pi / 2)
    localizer = StereoLocalizer(marked, CAMERAS, StereoLocalizerConfig(**SMALL))
    poses = [away @ SE2(0.0, 0.0, -0.1 * k) for k in range(14)]
    states, last = [], None
    for found, pose in drive(localizer, marked, poses):
        states.append(found.state)
        last = found, pose
    assert states[0] is StereoState.AMBIGUOUS
    assert states[-1] is StereoState.KNOWN
    assert_at(*last)


@pytest.mark.parametrize("hz", [5, 30])
@pytest.mark.parametrize("motion", [SE2.identity(), None])
def test_standing_settles_nothing_at_any_rate(marked, hz, motion):
    # Of two poses that look nearly alike, for a corner of the mark is seen, none is settled yet.
    pose = SE2(1.9, 1.2, np.pi / 2 - 0.4)
    localizer = StereoLocalizer(marked, CAMERAS, StereoLocalizerConfig(**SMALL))
    views = views_at(marked, pose)
    best = localizer.locate(views).hypotheses[0].share
    assert 0.6 < best < 0.9
    localizer.track(views, motion, 0.0)
    for _ in range(2 * hz):
        found = localizer.track(views, motion, 1.0 / hz)
    assert found.state is StereoState.AMBIGUOUS
    assert found.hypotheses[0].share == pytest.approx(best, abs=0.02)


def test_views_covered_for_a_moment_are_bridged_by_odometry_and_then_lost(localizer, voxels):
    localizer.reset()
    pose = POSES[0]
    localizer.track(views_at(voxels, pose), SE2.identity(), 0.1)
    step = SE2(0.05, 0.0, 0.0)
    found = localizer.track(blind_views(), step, 0.1)
    assert found.state is StereoState.BRIDGED
    assert "by odometry" in found.reason
    assert_at(found, pose @ step)
    seen = localizer.track(views_at(voxels, pose @ step), SE2.identity(), 0.1)
    assert seen.state is StereoState.KNOWN
    for _ in range(12):
        found = localizer.track(blind_views(), SE2.identity(), 0.1)
        assert found.state is not StereoState.KNOWN
    assert found.state is StereoState.LOST
    assert_at(localizer.track(views_at(voxels, POSES[1]), SE2.identity(), 1.0), POSES[1])


def test_a_robot_carried_away_is_found_again(localizer, voxels):
    localizer.reset()
    localizer.track(views_at(voxels, POSES[0]), SE2.identity(), 0.1)
    found = None
    for k in range(20):
        found = localizer.track(views_at(voxels, POSES[1], seed=k), SE2.identity(), 0.1)
        if found.state is StereoState.KNOWN:
            assert_at(found, POSES[1])
    assert found.state is StereoState.KNOWN
    assert_at(found, POSES[1])
