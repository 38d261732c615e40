import numpy as np
import pytest
from located import POSES, SMALL, assert_at, blind_views, turned
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate, difference
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState

TOL_M = 0.02


@pytest.fixture(scope="module")
def voxels():
    return room()


@pytest.fixture(scope="module")
def localizer(voxels):
    return StereoLocalizer(voxels, CAMERAS, StereoLocalizerConfig(**SMALL))


@pytest.fixture(scope="module")
def twofold():
    return room(is_twofold=True)


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


def test_a_pose_told_chooses_among_places_that_look_alike(twofold):
    localizer = StereoLocalizer(twofold, CAMERAS, StereoLocalizerConfig(**SMALL))
    pose = POSES[1]
    views = views_at(twofold, pose)
    assert localizer.track(views, SE2.identity(), 0.0).state is StereoState.AMBIGUOUS
    for place in (turned(pose), pose):
        told = SE2(place.x + 0.3, place.y - 0.2, place.yaw + 0.2)
        localizer.relocate(PoseEstimate(told, np.diag([0.25, 0.25, 0.07])))
        found = localizer.track(views, SE2.identity(), 0.1)
        assert found.state is StereoState.KNOWN
        assert_at(found, place, 2 * TOL_M)
        assert localizer.track(views, SE2.identity(), 0.1).state is StereoState.KNOWN
    assert localizer.take_refusal() == ""


def test_a_pose_told_where_nothing_fits_is_refused_and_the_old_one_stays(localizer, voxels):
    localizer.reset()
    views = views_at(voxels, POSES[0])
    localizer.track(views, SE2.identity(), 0.0)
    localizer.relocate(PoseEstimate(SE2(1.6, 1.2, -2.5), np.diag([0.01, 0.01, 0.01])))
    assert_at(localizer.track(views, SE2.identity(), 0.1), POSES[0])
    assert "nothing in the map fits there" in localizer.take_refusal()
    assert localizer.take_refusal() == ""


def test_tuning_keeps_the_pose_and_cannot_change_what_the_map_is_drawn_for(localizer, voxels):
    localizer.reset()
    views = views_at(voxels, POSES[0])
    localizer.track(views, SE2.identity(), 0.0)
    localizer.reconfigure(StereoLocalizerConfig(**SMALL, lost_cost=0.001))
    assert localizer.track(views, SE2.identity(), 0.1).state is StereoState.BRIDGED
    localizer.reconfigure(StereoLocalizerConfig(**SMALL))
    assert localizer.track(views, SE2.identity(), 0.1).state is StereoState.KNOWN
    with pytest.raises(ValueError, match="panorama_columns cannot be changed"):
        localizer.reconfigure(StereoLocalizerConfig(panorama_columns=32))


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
