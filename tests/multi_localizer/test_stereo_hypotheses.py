import numpy as np
import pytest

from multi_localizer.stereo_hypotheses import covariance, hypotheses_of, judged
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.stereo_pose import StereoState

CONFIG = StereoLocalizerConfig()
COV = np.eye(3) * 1e-4


def made(poses, shares, costs=None, config=CONFIG):
    poses = np.array(poses, dtype=float)
    costs = np.full(len(poses), 0.1) if costs is None else np.array(costs)
    return hypotheses_of(poses, [COV] * len(poses), costs, np.log(shares), config)


def test_shares_sum_to_one_and_the_likeliest_is_first():
    found = made([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [1.0, 6.0, 3.0])
    assert [h.estimate.pose.x for h in found] == [1.0, 2.0, 0.0]
    assert [h.share for h in found] == pytest.approx([0.6, 0.3, 0.1])


def test_the_same_pose_counts_once():
    found = made([(0, 0, 3.1), (0.1, 0, -3.1), (0, 0, 0), (1, 1, 0)], [4.0, 9.0, 9.0, 2.0])
    assert [h.share for h in found] == pytest.approx([0.45, 0.45, 0.1])
    assert len(found) == 3


def test_what_is_hardly_likely_is_dropped():
    found = made([(0, 0, 0), (1, 0, 0)], [1.0, 1e-9])
    assert [h.share for h in found] == [1.0]


def test_no_more_stay_than_allowed():
    few = StereoLocalizerConfig(max_hypotheses=2)
    assert len(made([(k, 0, 0) for k in range(5)], [1.0] * 5, config=few)) == 2


def test_one_far_likelier_is_known_and_two_alike_are_ambiguous():
    assert judged(made([(0, 0, 0), (1, 0, 0)], [0.97, 0.03]), 1.0, CONFIG).state is (
        StereoState.KNOWN
    )
    alike = judged(made([(0, 0, 0), (1, 0, 0)], [0.6, 0.4]), 1.0, CONFIG)
    assert alike.state is StereoState.AMBIGUOUS
    assert alike.reason == "2 poses look alike"


def test_what_fits_nowhere_is_lost_and_known_pixels_decide_it():
    config = StereoLocalizerConfig(lost_cost=0.4, judge_color=0.5)
    found = made([(0, 0, 0)], [1.0], costs=[0.25])
    assert judged(found, 1.0, config).state is StereoState.KNOWN
    lost = judged(found, 0.2, config)  # 0.25 of at most 0.6
    assert lost.state is StereoState.LOST
    assert lost.reason == "the views fit nowhere: 42% of them is wrong at the best pose"
    assert judged(found, 0.05, config).reason == "the cameras see too little"
    assert judged((), 1.0, config).state is StereoState.LOST


def test_the_covariance_is_the_inverse_information_above_its_floor():
    config = StereoLocalizerConfig(least_error_m=0.003, least_error_rad=0.002)
    sd = np.array([0.02, 0.05, 0.01])
    cov = covariance(np.diag(1.0 / sd**2), config)
    assert np.sqrt(np.diag(cov)) == pytest.approx([0.0202, 0.0500, 0.0102], rel=0.01)
    nothing = covariance(np.zeros((3, 3)), config)
    assert np.sqrt(np.diag(nothing)) == pytest.approx([1.0, 1.0, 1.0], rel=0.01)
    exact = covariance(np.eye(3) * 1e12, config)
    assert np.sqrt(np.diag(exact)) == pytest.approx([0.003, 0.003, 0.002], rel=0.01)
