"""What the planner of ways says of a goal, and whether a planner that drives drives to it."""

from __future__ import annotations

import pytest

from sjmc_planner.goal_progress import GoalProgress, goal_name
from sjmc_planner.way_progress import WayProgress

S = 1_000_000_000
OURS, OLD = goal_name("map", 1.0, -0.0004), goal_name("map", 3.0, 0.0)


def test_a_goal_is_named_by_frame_and_place():
    assert OURS == "map (1.000, 0.000)"
    assert goal_name("/odom", -1.25, 2.0) == "odom (-1.250, 2.000)"


def test_reached_of_another_goal_never_counts_and_of_this_one_at_once():
    progress = GoalProgress()
    for state in ("driving", *("reached",) * 20):
        progress.update(state, "", is_this=False)
        assert not progress.is_reached
    assert progress.update("reached", "", is_this=True) == "reached"
    assert progress.is_reached


def test_driving_to_the_last_goal_is_not_on_its_way_to_this_one():
    progress = GoalProgress()
    progress.update("driving", "", is_this=False)
    progress.update("reached", "", is_this=None)
    assert not progress.is_reached


def test_only_the_end_of_this_goals_path_leads_to_it():
    way = WayProgress(OURS)
    assert way.leads(OURS) is True and way.leads(OLD) is None  # nobody plans ways, as far as known
    way.update("idle: no goal", OLD, OLD, 0)
    assert way.leads(OLD) is False
    way.update("waiting: frame 'nowhere' is unknown", OURS, "", 0)
    assert way.has_goal and way.leads(OLD) is False and way.leads(OURS) is False
    moved = goal_name("map", 1.1, 0.0)
    way.update("on its way: 2.0 m left", OURS, moved, 0)
    assert way.leads(moved) is True and way.leads(OLD) is False


def test_why_there_is_no_way_is_said_once_and_counted():
    way = WayProgress(OURS)
    assert way.update("no way: walled off", OLD, "", 0) == ""
    assert way.no_way_s(9 * S) == 0.0
    assert way.update("no way: walled off", OURS, "", S) == "no way: walled off"
    assert way.update("no way: walled off", OURS, "", 2 * S) == ""
    assert way.no_way_s(5 * S) == pytest.approx(4.0)
    assert way.update("on its way: 2.0 m left", OURS, OURS, 6 * S) == ""
    assert way.no_way_s(9 * S) == 0.0


def test_what_it_waits_for_is_said_again_only_with_other_words():
    way = WayProgress(OURS)
    assert way.update("waiting: pose: 'map' to 'base' is 1.1 s old", OURS, "", 0)
    assert not way.update("waiting: pose: 'map' to 'base' is 1.6 s old", OURS, "", 0)
    assert way.update("waiting: no map on /map yet", OURS, "", 0)
