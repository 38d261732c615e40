import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.stereo_fusion import fused
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig

CONFIG = StereoLocalizerConfig(slip_sd=3.0, renewal_s=0.5)
SURE = np.diag([1e4, 1e4, 1e4])  # 1 cm and 0.01 rad


def before(sd=0.01):
    return PoseEstimate(SE2(1.0, 2.0, 0.5), np.eye(3) * sd**2)


def looked(estimate, wanted, new, dt, hessian=SURE, config=CONFIG):
    return fused(estimate, hessian @ np.array(wanted), hessian, new, dt, config)


def test_a_new_view_as_sure_as_what_is_known_is_met_half_way_and_halves_the_covariance():
    found = looked(before(), (0.01, 0.0, -0.02), 1.0, 0.0)
    assert found.estimate.pose.as_array() == pytest.approx([1.005, 2.0, 0.49], abs=1e-5)
    sd = np.sqrt(np.diag(found.estimate.cov))
    assert sd[:2] == pytest.approx(np.hypot(0.01 / np.sqrt(2.0), 0.003), rel=1e-3)
    assert not found.gap.any()


@given(st.integers(1, 60), st.integers(1, 100))
def test_looking_on_from_one_place_is_never_surer_than_one_look(hz, num):
    estimate = before(0.3)
    least = 0.5 * np.linalg.inv(SURE + np.eye(3))  # the look that began it may be another's
    for _ in range(num):
        estimate = looked(estimate, (0.0, 0.0, 0.0), 0.0, 1.0 / hz).estimate
        assert (np.linalg.eigvalsh(estimate.cov - 2.0 * least) > 0.0).all()


def test_a_standing_robot_comes_to_where_the_views_have_it_at_any_rate():
    left = []
    for hz in (10, 40):
        estimate = before()
        for _ in range(hz):
            off = (1.02 - estimate.pose.x, 0.0, 0.0)
            estimate = looked(estimate, off, 0.0, 1.0 / hz).estimate
        left.append(1.02 - estimate.pose.x)
    assert max(left) < 0.006
    assert left[0] == pytest.approx(left[1], abs=0.002)


def test_a_view_that_contradicts_the_motion_is_followed_and_the_covariance_grows():
    found = looked(before(0.002), (0.1, 0.0, 0.0), 0.0, 0.1)
    assert found.estimate.pose.x > 1.08
    assert 0.05 < np.sqrt(found.estimate.cov[0, 0]) < 0.15
    assert np.sqrt(found.estimate.cov[1, 1]) < 0.03
    assert np.sqrt(found.gap[0, 0]) == pytest.approx(0.1, rel=0.2)


def test_a_view_that_says_nothing_along_an_axis_leaves_it_to_the_motion():
    corridor = np.diag([0.0, 1e4, 1e4])
    found = looked(before(), (0.0, 0.01, 0.0), 1.0, 0.1, corridor)
    assert found.estimate.pose.x == pytest.approx(1.0)
    assert np.sqrt(found.estimate.cov[0, 0]) == pytest.approx(np.hypot(0.01, 0.003), rel=0.05)
