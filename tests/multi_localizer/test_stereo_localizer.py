import numpy as np
import pytest
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState
from multi_localizer.stereo_view import StereoView

TOL_M, TOL_RAD = 0.02, 0.01
POSES = (SE2(1.6, 1.2, 0.4), SE2(2.3, 1.6, -2.2), SE2(1.3, 1.7, 2.9))
SMALL = {"panorama_columns": 64, "num_refined": 20, "max_hypotheses": 4}


@pytest.fixture(scope="module")
def voxels():
    return room()


@pytest.fixture(scope="module")
def localizer(voxels):
    return StereoLocalizer(voxels, CAMERAS, StereoLocalizerConfig(**SMALL))


@pytest.fixture(scope="module")
def twofold():
    return room(is_twofold=True)


def assert_at(found, pose, tol=TOL_M, tol_rad=TOL_RAD):
    off = difference(found.pose, pose)
    assert np.hypot(off[0], off[1]) < tol
    assert abs(off[2]) < tol_rad


def blind_views():
    shape = (8, 320)
    nothing = np.full(shape, np.nan, np.float32)
    color = np.full((*shape, 3), 10.0, np.float32)
    return [StereoView(color, nothing, nothing, np.zeros(shape, np.float32)) for _ in CAMERAS]


def turned(pose):
    """The pose that looks the same in the twofold room."""
    return SE2(3.2 - pose.x, 2.4 - pose.y, pose.yaw + np.pi)


@pytest.mark.parametrize("pose", POSES)
def test_ours_finds_the_pose_without_a_guess(localizer, voxels, pose):
    found = localizer.locate(views_at(voxels, pose, noise_px=0.5))
    assert found.state is StereoState.KNOWN
    assert_at(found, pose)
    assert found.reason == ""
    assert sum(h.share for h in found.hypotheses) == pytest.approx(1.0)


def test_the_covariance_holds_the_errors(localizer, voxels):
    errors = []
    for k, pose in enumerate(POSES):
        found = localizer.locate(views_at(voxels, pose, noise_px=0.5, seed=k))
        off = difference(found.pose, pose)
        errors.append(off @ np.linalg.solve(found.cov, off))
        assert np.sqrt(found.cov[0, 0]) < 0.05
    assert np.mean(errors) < 10.0


def test_one_pair_is_enough_where_its_view_is_its_own(localizer, voxels):
    front, rear = views_at(voxels, POSES[0])
    assert_at(localizer.locate([front, None]), POSES[0])
    assert_at(localizer.locate([None, rear]), POSES[0])


def test_wrong_matches_in_a_third_of_the_view_do_not_matter(localizer, voxels):
    views = views_at(voxels, POSES[1])
    for view in views:
        view.inverse[:, :100] = 1.7
        view.distance[:, :100] = 1.0 / 1.7
    assert_at(localizer.locate(views), POSES[1], 0.03)


@pytest.mark.parametrize(("method", "tol"), [("published", 0.04), ("color_only", 0.2)])
def test_the_published_search_comes_near_the_pose(voxels, method, tol):
    config = StereoLocalizerConfig(method=method, mesh_cells=16)
    localizer = StereoLocalizer(voxels, CAMERAS, config)
    views = views_at(voxels, POSES[0])
    assert_at(localizer.locate(views), POSES[0], tol, 0.1)


def test_places_that_look_alike_are_said_to_be_ambiguous(twofold):
    pose = POSES[1]
    found = StereoLocalizer(twofold, CAMERAS, StereoLocalizerConfig(**SMALL)).locate(
        views_at(twofold, pose)
    )
    assert found.state is StereoState.AMBIGUOUS
    assert "look alike" in found.reason
    for place in (pose, turned(pose)):
        off = [difference(h.estimate.pose, place) for h in found.hypotheses]
        assert min(np.hypot(x, y) + abs(yaw) for x, y, yaw in off) < 2 * TOL_M


def drive(localizer, voxels, poses, odometry_scale=1.0, dt=0.1):
    """Track along poses; yields what is found with the true pose."""
    before = poses[0]
    for k, pose in enumerate(poses):
        motion = before.between(pose)
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


def test_tracking_settles_what_looks_alike_once_it_is_told_apart(twofold):
    # A mark that is not seen from the first poses, but from later ones.
    color = twofold.color.copy()
    color[4:12, 100:120, -1] = (255, 0, 255)
    one = type(twofold)(color, twofold.occupied, 0.02, 0.16, 0.0, 0.0, -0.16)
    away = SE2(1.9, 1.2, np.pi / 2)
    localizer = StereoLocalizer(one, CAMERAS, StereoLocalizerConfig(**SMALL))
    poses = [away @ SE2(0.0, 0.0, -0.1 * k) for k in range(14)]
    states, last = [], None
    for found, pose in drive(localizer, one, poses):
        states.append(found.state)
        last = found, pose
    assert states[0] is StereoState.AMBIGUOUS
    assert states[-1] is StereoState.KNOWN
    assert_at(*last)


def test_views_covered_for_a_moment_are_bridged_by_odometry_and_then_lost(localizer, voxels):
    localizer.reset()
    pose = POSES[0]
    localizer.track(views_at(voxels, pose), SE2.identity(), 0.1)
    step = SE2(0.05, 0.0, 0.0)
    found = localizer.track(blind_views(), step, 0.1)
    assert found.state is StereoState.KNOWN
    assert "by odometry" in found.reason
    assert_at(found, pose @ step)
    for _ in range(12):
        found = localizer.track(blind_views(), SE2.identity(), 0.1)
    assert found.state is StereoState.LOST
    assert_at(localizer.track(views_at(voxels, POSES[1]), SE2.identity(), 1.0), POSES[1])


def test_a_robot_carried_away_is_found_again(localizer, voxels):
    localizer.reset()
    localizer.track(views_at(voxels, POSES[0]), SE2.identity(), 0.1)
    found = None
    for k in range(20):
        found = localizer.track(views_at(voxels, POSES[1], seed=k), SE2.identity(), 0.1)
    assert found.state is StereoState.KNOWN
    assert_at(found, POSES[1])


def test_views_of_another_room_fit_nowhere(localizer):
    other = room(3.2, 3.2, seed=9)
    found = localizer.locate(views_at(other, SE2(1.0, 2.6, 1.0)))
    assert found.state is StereoState.LOST
    assert "fit nowhere" in found.reason


def test_cameras_that_see_nothing_are_lost(localizer):
    assert localizer.locate(blind_views()).state is StereoState.LOST


def test_threads_change_nothing(voxels, localizer):
    views = views_at(voxels, POSES[2])
    two = StereoLocalizer(voxels, CAMERAS, StereoLocalizerConfig(**SMALL), num_threads=2)
    assert two.locate(views).pose == localizer.locate(views).pose


def test_bad_input_is_refused(localizer, voxels):
    views = views_at(voxels, POSES[0])
    with pytest.raises(ValueError, match="views must be 2"):
        localizer.locate(views[:1])
    with pytest.raises(ValueError, match="at least one"):
        localizer.locate([None, None])
    with pytest.raises(ValueError, match="dt must be"):
        localizer.track(views, SE2.identity(), -0.1)
    with pytest.raises(ValueError, match="cameras"):
        StereoLocalizer(voxels, [])


def test_stages_that_do_not_fit_the_views_are_refused():
    with pytest.raises(ValueError, match="of one length"):
        StereoLocalizerConfig(view_columns=(1, 2))
    with pytest.raises(ValueError, match="view_columns must divide"):
        StereoLocalizerConfig(view_columns=(1, 3), view_rows=(1, 1))
    with pytest.raises(ValueError, match="view_rows must divide"):
        StereoLocalizerConfig(view_columns=(1, 4), view_rows=(1, 3))
