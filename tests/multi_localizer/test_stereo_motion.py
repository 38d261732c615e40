import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_motion import NewView, motion_covariance

CONFIG = StereoLocalizerConfig(new_view_m=0.2, new_view_rad=0.3)


@pytest.mark.parametrize("parts", [2, 5, 20])
def test_errors_of_a_motion_do_not_depend_on_how_it_is_cut(parts):
    whole = motion_covariance(SE2(0.04, 0.0, 0.0), 0.1, CONFIG)
    part = motion_covariance(SE2(0.04 / parts, 0.0, 0.0), 0.1 / parts, CONFIG)
    assert np.diag(parts * part) == pytest.approx(np.diag(whole), rel=1e-3)


def test_a_standing_robot_drifts_as_much_at_any_rate():
    slow, fast = (motion_covariance(SE2.identity(), 1.0 / hz, CONFIG) * hz for hz in (10, 60))
    assert np.diag(fast) == pytest.approx(np.diag(slow), rel=1e-2)


def test_without_odometry_the_robot_may_have_gone_at_its_highest_speed():
    cov = motion_covariance(None, 0.2, StereoLocalizerConfig(free_speed_m_s=1.5))
    assert np.sqrt(np.diag(cov)) == pytest.approx([0.3, 0.3, 0.2], rel=1e-3)


def looked(new, motion):
    share = new.share(motion)
    new.look(share, motion)
    return share


@pytest.mark.parametrize("num", [2, 10, 40])
def test_a_way_makes_as_much_new_in_any_number_of_views(num):
    new = NewView(CONFIG)
    step = SE2(0.19 / num, 0.0, 0.0)
    assert sum(looked(new, step) for _ in range(num)) == pytest.approx(0.95)


def test_a_long_way_makes_many_new_views():
    new = NewView(CONFIG)
    assert sum(looked(new, SE2(0.04, 0.0, 0.0)) for _ in range(250)) == pytest.approx(50.0, rel=0.1)


def test_who_stands_goes_to_and_fro_or_trembles_sees_nothing_new():
    new = NewView(CONFIG)
    assert looked(new, SE2(0.1, 0.0, 0.0)) == pytest.approx(0.5)
    for _ in range(20):
        assert looked(new, SE2(-0.1, 0.0, 0.0)) == 0.0
        assert looked(new, SE2(0.1, 0.0, 0.0)) == pytest.approx(0.0)
    rng = np.random.default_rng(0)
    here, total = SE2.identity(), 0.0
    for x in rng.normal(0.0, 0.003, 500).tolist():
        there = SE2(x, 0.0, 0.0)
        total += looked(new, here.inverse() @ there)
        here = there
    assert total < 0.2


def test_what_is_passed_by_unseen_makes_the_next_view_new():
    new = NewView(CONFIG)
    new.pass_by(SE2(0.1, 0.0, 0.0))
    assert new.share(SE2(0.0, 0.0, 0.03)) == pytest.approx(0.6)
