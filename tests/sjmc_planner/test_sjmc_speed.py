"""The speed models of SJMC, by hand and by the inequality that they come from."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sjmc_planner.sjmc_speed import (
    avoid_time,
    aware_time,
    simple_bound,
    stable_bound,
    unstable_bound,
)

lengths, times = st.floats(0.0, 10.0), st.floats(0.0, 10.0)
closings = st.floats(-2.0, 2.0)
TOL_M = 1e-6


def test_the_simple_model_by_hand() -> None:
    """4.15 m ahead, L_DANGER 1.9 m, C 2.7 s: 2.25 m / 2.7 s is the thesis's 3 km/h."""
    assert simple_bound(4.15, 1.9, 2.7) == pytest.approx(3.0 / 3.6, abs=1e-9)
    assert simple_bound(1.5, 1.9, 2.7) == 0.0


def test_the_stable_model_by_hand() -> None:
    assert stable_bound(3.0, 1.0, 0.0, 1.0, 3.0) == pytest.approx(0.5)
    assert stable_bound(3.0, 1.0, 0.2, 1.0, 3.0) == pytest.approx((2.0 - 0.6) / 4.0)


def test_the_unstable_model_by_hand() -> None:
    assert unstable_bound(3.0, 1.0, 0.0, 4.0) == pytest.approx(0.5)
    assert unstable_bound(3.0, 1.0, 0.3, 4.0) == pytest.approx(0.2)


def test_who_comes_nearer_makes_the_robot_slower_and_who_goes_away_faster() -> None:
    """The sign of v_oy, which in print would have it the other way round."""
    assert unstable_bound(3.0, 1.0, 0.2, 4.0) < unstable_bound(3.0, 1.0, 0.0, 4.0)
    assert unstable_bound(3.0, 1.0, -0.2, 4.0) > unstable_bound(3.0, 1.0, 0.0, 4.0)
    assert stable_bound(3.0, 1.0, 0.2, 1.0, 4.0) < stable_bound(3.0, 1.0, -0.2, 1.0, 4.0)


def test_who_does_not_leave_is_only_followed() -> None:
    assert unstable_bound(3.0, 1.0, -0.7, math.inf) == pytest.approx(0.7)
    assert unstable_bound(3.0, 1.0, 0.7, math.inf) == 0.0


def test_the_time_to_leave_is_way_over_speed() -> None:
    assert avoid_time(0.6, 0.3) == pytest.approx(2.0)
    assert avoid_time(0.6, 0.0) == math.inf and avoid_time(0.0, 0.0) == 0.0


def test_the_time_to_notice_shrinks_with_the_distance() -> None:
    assert [aware_time(d, 4.0, 1.2) for d in (8.0, 4.0, 2.0, 0.0)] == [1.2, 1.2, 0.6, 0.0]


@given(distance=lengths, danger=lengths, closing=closings, t_avoid=st.floats(0.01, 10.0))
def test_at_the_unstable_bound_both_come_no_nearer_than_danger(
    distance: float, danger: float, closing: float, t_avoid: float
) -> None:
    v = unstable_bound(distance, danger, closing, t_avoid)
    assert v >= 0.0
    if v > 0.0:  # eq. 3.6
        assert (v + closing) * t_avoid <= distance - danger + TOL_M


@given(distance=lengths, danger=lengths, closing=closings, t_aware=times, t_avoid=times)
def test_at_the_stable_bound_both_come_no_nearer_than_danger(
    distance: float, danger: float, closing: float, t_aware: float, t_avoid: float
) -> None:
    v = stable_bound(distance, danger, closing, t_aware, t_avoid)
    assert v >= 0.0
    if 0.0 < v < math.inf and t_aware + t_avoid > 1e-3:  # eq. 3.4
        assert v * (t_aware + t_avoid) + closing * t_avoid <= distance - danger + TOL_M


@given(near=lengths, more=lengths, danger=lengths, response=st.floats(0.1, 10.0))
def test_farther_is_never_slower(near: float, more: float, danger: float, response: float) -> None:
    assert simple_bound(near + more, danger, response) >= simple_bound(near, danger, response)
