"""Waiting for answers, in hand-made time."""

from sim_bridge.pacing import Audience, Pace

S = 1_000_000_000


def test_nobody_is_waited_for_before_its_first_message() -> None:
    assert Pace(["pose"], 0.2, 5.0).late(100 * S) == []


def test_one_that_is_known_to_listen_is_waited_for_from_the_start_and_after_each_restart() -> None:
    pace = Pace(["pose", "cmd_vel"], 0.2, 5.0, from_start=["pose"])
    assert pace.late(S // 10) == []
    assert pace.late(S // 5) == ["pose"]
    pace.heard("pose", 7 * S)
    assert pace.late(7 * S) == []
    pace.restart()
    assert pace.late(S // 10) == []
    assert pace.late(S // 5) == ["pose"]
    assert pace.give_up(S, 0.0) == []
    assert pace.give_up(S, 5.0) == ["pose"]
    assert pace.late(9 * S) == []


def test_time_waits_until_the_late_one_answers() -> None:
    pace = Pace(["pose", "cmd_vel"], 0.2, 5.0)
    pace.heard("pose", S)
    pace.heard("cmd_vel", S)
    assert pace.late(S + S // 10) == []
    pace.heard("cmd_vel", S + S // 5)
    assert pace.late(S + S // 5) == ["pose"]
    pace.heard("pose", S + S // 5)
    assert pace.late(S + S // 5) == []


def test_waiting_is_bounded_and_the_late_one_may_come_back() -> None:
    pace = Pace(["pose"], 0.2, 5.0)
    pace.heard("pose", 0)
    assert pace.give_up(S, 10.0) == []
    assert pace.give_up(S, 14.9) == []
    assert pace.give_up(S, 15.0) == ["pose"]
    assert pace.late(S) == []
    assert pace.heard("pose", 2 * S)
    assert not pace.heard("pose", 2 * S)
    assert pace.late(3 * S) == ["pose"]


def test_a_wait_that_ended_does_not_count_for_the_next() -> None:
    pace = Pace(["pose"], 0.2, 5.0)
    pace.heard("pose", 0)
    assert pace.give_up(S, 0.0) == []
    pace.heard("pose", S)
    assert pace.give_up(S, 4.0) == []
    assert pace.give_up(2 * S, 6.0) == []
    assert pace.late(2 * S) == ["pose"]


def test_time_starts_once_all_listen_are_matched_and_no_more_come_for_a_moment() -> None:
    audience = Audience(["/mapper", "/recorder"], settle_s=1.0)
    assert audience.missing == ["/mapper", "/recorder"]
    assert not audience.is_there(0.0, ["/mapper"], 2, 2)
    assert audience.missing == ["/recorder"]
    assert not audience.is_there(5.0, ["/mapper", "/recorder"], 4, 3)
    assert not audience.is_there(7.0, ["/mapper", "/recorder"], 4, 4)
    assert not audience.is_there(7.5, ["/mapper", "/recorder"], 5, 5)
    assert not audience.is_there(8.4, ["/mapper", "/recorder"], 5, 5)
    assert audience.is_there(8.5, ["/mapper", "/recorder"], 5, 5)
