from __future__ import annotations

from multi_localizer.team_lists import TeammateList, list_problem, strangers


def test_a_list_is_whom_a_robot_writes_to_and_itself():
    told = TeammateList("r2")
    for _ in range(2):
        told.take("r1")
        told.take("r3")
    assert told.known is None
    told.take("r1")
    assert told.known == {"r1", "r2", "r3"}


def test_a_robot_started_again_with_another_list_is_read_anew():
    told = TeammateList("r2")
    for reader in ["r1"] * 3 + ["r4"] * 3:
        told.take(reader)
    assert told.known == {"r2", "r4"}


def test_only_lists_that_differ_are_a_problem():
    assert list_problem("r2", None, ("r1", "r2")) == ""
    assert list_problem("r2", frozenset({"r2", "r1"}), ("r1", "r2")) == ""
    text = list_problem("r2", frozenset({"r2", "r7"}), ("r1", "r2"))
    assert text == "/r2 has the team [r2, r7], here it is [r1, r2]"


def test_strangers_are_those_that_see_robots_and_are_not_listed():
    topics = ["/r1/bearings/robots", "/fleet/r4/bearings/robots", "/r9/bearings/pole", "/odom"]
    assert strangers(topics, ("r1", "r2")) == ["fleet/r4"]
