"""When a goal that was sent counts as reached."""

from __future__ import annotations

from sjmc_planner.goal_progress import GoalProgress


def test_reached_counts_after_the_robot_was_on_its_way() -> None:
    progress = GoalProgress()
    for state in ("idle", "driving", "braking", "driving"):
        progress.update(state, "")
        assert not progress.is_reached
    assert progress.update("reached", "") == "reached"
    assert progress.is_reached


def test_the_last_goal_reached_is_not_this_one_unless_it_is_said_for_three_seconds() -> None:
    progress = GoalProgress()
    for _ in range(5):
        assert progress.update("reached", "") == ""
        assert not progress.is_reached
    assert progress.update("reached", "") == "reached"
    assert progress.is_reached


def test_reached_that_is_cut_short_is_counted_anew() -> None:
    progress = GoalProgress()
    for state in ("reached",) * 5 + ("idle",) + ("reached",) * 5:
        progress.update(state, "")
    assert not progress.is_reached


def test_a_state_is_said_once_though_its_figures_change() -> None:
    progress = GoalProgress()
    assert progress.update("stopped", "scan is 0.6 s old") == "stopped: scan is 0.6 s old"
    assert progress.update("stopped", "scan is 0.7 s old") == ""
    assert progress.update("stopped", "no odom") == "stopped: no odom"
    assert progress.update("driving", "") == "driving"


def test_a_planner_without_a_goal_is_told_from_one_that_has_it() -> None:
    progress = GoalProgress()
    assert not progress.is_idle
    for state, is_idle in (("idle", True), ("driving", False), ("reached", False), ("idle", True)):
        progress.update(state, "no goal" if is_idle else "")
        assert progress.is_idle == is_idle
