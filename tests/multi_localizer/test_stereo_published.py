import numpy as np
import pytest
from located import POSES, SMALL, assert_at, blind_views, turned
from voxel_rooms import CAMERAS, room, views_at

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState
from multi_localizer.stereo_published import judged_candidates
from multi_localizer.stereo_view import StereoView

CONFIG = StereoLocalizerConfig(method="published", alike_score=0.01, lost_score=0.25)
COLOR = StereoLocalizerConfig(method="color_only")
TWO = np.array([[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]])


def seen(part=1.0):
    plain = np.ones((8, 320), np.float32)
    return [StereoView(np.ones((8, 320, 3), np.float32), plain, plain, part * plain)]


def judged(scores, expected=None, config=CONFIG, poses=TWO, part=1.0):
    return judged_candidates(poses, np.array(scores), seen(part), expected, config)


def test_one_much_better_is_known_and_two_alike_are_not():
    assert judged([0.05, 0.07]).state is StereoState.KNOWN
    found = judged([0.05, 0.055])
    assert found.state is StereoState.AMBIGUOUS and found.reason == "2 poses look alike"
    assert [h.estimate.pose.x for h in found.hypotheses] == [1.0, 3.0]
    assert sum(h.share for h in found.hypotheses) == pytest.approx(1.0)


def test_of_two_alike_that_near_the_pose_before_is_taken_and_a_worse_one_is_not():
    before = SE2(3.2, 0.9, 0.1)
    alike = judged([0.05, 0.055], before)
    assert alike.state is StereoState.KNOWN and alike.pose.x == 3.0
    assert judged([0.05, 0.09], before).pose.x == 1.0


def test_what_fits_nowhere_or_shows_nothing_is_lost():
    assert "fit nowhere" in judged([0.3, 0.31]).reason
    assert judged([0.05, 0.07], part=0.05).reason == "the cameras see too little"
    assert judged([], poses=np.zeros((0, 3))).state is StereoState.LOST


def test_by_colors_alone_a_pose_is_followed_but_not_found():
    assert judged([0.05, 0.07], config=COLOR).state is StereoState.AMBIGUOUS
    found = judged([0.05, 0.07], SE2(1.1, 1.0, 0.0), COLOR)
    assert found.state is StereoState.KNOWN and found.cov[0, 0] > 0.05


@pytest.fixture(scope="module")
def localizer():
    return StereoLocalizer(
        room(), CAMERAS, StereoLocalizerConfig(method="published", mesh_cells=16)
    )


@pytest.mark.parametrize("motion", [SE2.identity(), None])
def test_covered_lenses_are_lost_also_after_a_known_pose(localizer, motion):
    localizer.reset()
    found = localizer.track(views_at(room(), POSES[0]), SE2.identity(), 0.0)
    assert found.state is StereoState.KNOWN
    assert_at(found, POSES[0], 0.04, 0.1)
    assert localizer.track(blind_views(), motion, 0.1).state is StereoState.LOST


def test_the_published_search_knows_that_places_look_alike_and_believes_who_tells():
    twofold, pose = room(is_twofold=True), POSES[1]
    config = StereoLocalizerConfig(method="published", mesh_cells=16, **SMALL)
    localizer = StereoLocalizer(twofold, CAMERAS, config)
    views = views_at(twofold, pose)
    assert localizer.track(views, SE2.identity(), 0.0).state is StereoState.AMBIGUOUS
    localizer.relocate(PoseEstimate(turned(pose), np.diag([0.25, 0.25, 0.07])))
    found = localizer.track(views, SE2.identity(), 0.1)
    assert found.state is StereoState.KNOWN
    assert_at(found, turned(pose), 0.06, 0.1)
