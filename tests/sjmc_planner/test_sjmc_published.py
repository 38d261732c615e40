"""SJMC as the thesis ran it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sjmc_scenes import CONFIG, ROBOT, goal_at, watched

from sjmc_planner.methods import make_method
from sjmc_planner.planning import DRIVING, TURNING
from sjmc_planner.sjmc_config import SjmcConfig

C, DANGER = 2.7, 1.9
RULE = SjmcConfig(published_response_s=C, published_danger_m=DANGER, published_end_m_s=0.15)
FAR = goal_at(12.0, 0.0)
TOL = 0.02  # m/s: a disk between two beams


def published(**changes):
    return make_method(replace(CONFIG, method="sjmc_published", sjmc=replace(RULE, **changes)))


@settings(max_examples=40)
@given(gap=st.floats(0.4, 5.0), y=st.floats(-0.3, 0.3), radius=st.floats(0.15, 0.5))
def test_it_is_never_faster_than_eq_4_5(gap: float, y: float, radius: float) -> None:
    x = gap + radius
    command = watched(published(), [(x, y, radius)], FAR, num=2).command
    bound = max((gap - DANGER) / C, 0.0)
    assert command.x <= min(bound + radius / C, ROBOT.speed_m_s) + TOL
    if y == 0.0:
        assert command.x <= bound + TOL


def test_the_speed_by_hand() -> None:
    """A post of 0.2 m at 3.2 m: (3.0 - 1.9) m / 2.7 s, straight on."""
    decision = watched(published(), [(3.2, 0.0, 0.2)], FAR, num=1)
    assert decision.state == DRIVING
    assert decision.command.x == pytest.approx(1.1 / 2.7, abs=TOL)
    assert decision.command.yaw_rate == pytest.approx(0.0, abs=1e-9)


def test_it_turns_from_what_is_in_the_danger_zone_to_the_nearer_side() -> None:
    decision = watched(published(), [(1.6, 0.1, 0.2)], FAR, num=1)
    assert decision.state == TURNING and decision.command.yaw_rate < 0.0
    assert decision.command.x == 0.0  # the heading's own strip is not free yet


def test_waiting_ends_where_the_rule_leaves_no_speed() -> None:
    """2.2 m ahead it would go 0.11 m/s: less than 0.15, so what stands there does not yield."""
    post = [(2.4, 0.1, 0.2)]
    assert watched(published(), post, FAR, num=1).state == TURNING
    patient = watched(published(published_end_m_s=0.05), post, FAR, num=1)
    assert patient.state == DRIVING and 0.05 < patient.command.x < 0.15


def test_what_is_behind_the_target_is_not_in_the_way() -> None:
    assert watched(published(), [(1.6, 0.0, 0.2)], goal_at(0.9, 0.0), num=1).state == DRIVING
