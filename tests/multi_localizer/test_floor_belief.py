"""Shares of the poses that may be the robot's: known answers and laws."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.floor_belief import (
    Hypothesis,
    begun,
    drifted,
    fit_likelihoods,
    followed,
    ranked,
    why_open,
)
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.pose_estimate import PoseEstimate

CONFIG = FloorTrackConfig()
SD = 0.01
COV = np.diag([SD, SD, SD]) ** 2


def at(x: float, share: float = 1.0, num_masks: int = 1) -> Hypothesis:
    return Hypothesis(estimate(x), share, num_masks)


def estimate(x: float) -> PoseEstimate:
    return PoseEstimate(SE2(x, 0.0, 0.0), COV)


def follow(
    old: list[Hypothesis], *xs: float, likelihoods: object = None, is_sound: bool = True
) -> list[Hypothesis]:
    likely = np.ones(len(xs)) if likelihoods is None else np.array(likelihoods)
    sound = [is_sound] * len(xs)
    return followed(old, [estimate(x) for x in xs], likely, 1.0, CONFIG, sound)


@pytest.mark.parametrize("num", [2, 3, 12, 40])
def test_one_of_many_can_be_alone_whatever_their_number(num: int) -> None:
    best, *rest = ranked([at(k, 1.0 if k == 3 % num else 0.0) for k in range(num)], 0.002)
    assert best.share > 0.997 >= CONFIG.settle_share
    assert sum(h.share for h in rest) == pytest.approx(0.002, rel=0.01)


def test_ranked_is_ordered_and_sums_to_one() -> None:
    shares = [h.share for h in ranked([at(0, 1.0), at(1, 3.0), at(2, 2.0)], 0.002)]
    assert shares == pytest.approx([1 / 2, 1 / 3, 1 / 6])


def test_unseen_the_belief_evens_out_by_an_exponential() -> None:
    shares = [h.share for h in drifted([at(0, 0.9), at(1, 0.1)], 2.0, 0.5 * np.log(2.0))]
    assert shares == pytest.approx([0.7, 0.3])  # half of it has gone to 0.5 each


def test_two_times_unseen_are_one_as_long_as_both() -> None:
    start = [at(0, 0.8), at(1, 0.15), at(2, 0.05)]
    once = drifted(start, 3.0, 0.2)
    twice = drifted(drifted(start, 1.0, 0.2), 2.0, 0.2)
    assert [h.share for h in once] == pytest.approx([h.share for h in twice])
    assert [h.share for h in drifted(start, 0.0, 0.2)] == [h.share for h in start]


def test_what_fits_a_little_worse_fits_alike_and_much_worse_has_a_floor() -> None:
    alike = CONFIG.alike_share
    costs = (0.1, 0.1 + 0.9 * alike, 0.1 + alike + 0.1 / CONFIG.fit_weight, 0.9)
    likely = fit_likelihoods(costs, 4, 1.0, CONFIG)
    assert likely == pytest.approx([1.0, 1.0, np.exp(-0.1), CONFIG.worst_fit])
    assert fit_likelihoods(costs, 4, 0.5, CONFIG) == pytest.approx(np.sqrt(likely))
    assert (fit_likelihoods((), 3, 1.0, CONFIG) == 1.0).all()


def test_of_two_near_by_the_nearer_gets_more_as_the_deviations_say() -> None:
    near, far = follow([at(0.0)], 0.0, 2.0 * SD)
    assert near.share / far.share == pytest.approx(np.exp(0.5 * 2.0**2 / 2.0))


def test_shares_follow_their_poses_and_likelihoods_weigh_them() -> None:
    new = follow([at(0.0, 0.6), at(5.0, 0.4)], 5.0, 0.0, likelihoods=[1.0, 0.5])
    assert [h.share for h in new] == pytest.approx([0.4, 0.3])


def test_when_the_believed_one_has_no_follower_nothing_follows() -> None:
    assert follow([at(0.0, 0.95), at(5.0, 0.05)], 5.0) == []
    assert follow([], 5.0) == []


def test_of_equals_one_without_follower_fades() -> None:
    seen, gone = follow([at(0.0, 0.5), at(5.0, 0.5)], 5.0)
    assert (seen.estimate.pose.x, gone.estimate.pose.x) == (5.0, 0.0)
    assert gone.share == pytest.approx(0.5 * CONFIG.worst_fit)
    for _ in range(10):
        new = follow(ranked([seen, gone], CONFIG.least_share), 5.0)
        if len(new) == 1:
            break
        seen, gone = new
    assert len(new) == 1


def test_masks_are_counted_for_what_follows_only() -> None:
    new = follow([at(0.0, 0.5, 4), at(5.0, 0.5, 2)], 0.0, 9.0)
    assert {h.estimate.pose.x: h.num_masks for h in new} == {0.0: 5, 9.0: 1, 5.0: 2}


def test_what_is_open_is_said_with_what_would_tell() -> None:
    assert why_open([at(0.0, 1.0, 2)], ("blue",), 3) == "2 of 3 masks have shown it yet"
    both = [at(0.0), at(1.0)]
    assert "2 poses fit alike: no goal (blue or red)" in why_open(both, ("blue", "red"), 3)
    assert "initialpose" in why_open(both, (), 3)
    three, four = ([at(float(k)) for k in range(num)] for num in (3, 4))
    assert why_open(three, (), 3) == why_open(four, (), 3)  # how many changes from mask to mask


def test_masks_that_mostly_contradict_a_pose_count_only_after_one_that_does_not() -> None:
    (begun_badly,) = begun([estimate(0.0)], np.ones(1), [False])
    assert begun_badly.num_masks == 0 and "has not fitted" in why_open([begun_badly], (), 3)
    (still,) = follow([begun_badly], 0.0, is_sound=False)
    assert still.num_masks == 0
    (once,) = follow([still], 0.0)
    assert once.num_masks == 1
    (on,) = follow([once], 0.0, is_sound=False)
    assert on.num_masks == 2
