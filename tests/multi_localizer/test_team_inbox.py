"""A team's messages, collected into moments: late, lost, doubled, silent and back again."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.robot_inbox import ROBOTS, Classes
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_inbox import Moment, TeamInbox
from multi_localizer.team_node_config import TeamNodeConfig, TeamTimingConfig

S = 1_000_000_000
MS = 1_000_000
T = 100 * S
TEAM = ("r1", "r2", "r3")


def team(own: str = "r1", **values: object) -> TeamInbox:
    inbox = TeamInbox(TEAM, own, TeamTimingConfig(**values), Classes())
    for robot in inbox.robots.values():
        robot.mount = SE2.identity()
    return inbox


def send(inbox: TeamInbox, name: str, stamp_ns: int, at_ns: int | None = None) -> None:
    """Bearings of a robot come; one clock serves for stamps and for silence."""
    at_ns = stamp_ns if at_ns is None else at_ns
    if inbox.robots[name].take_bearings(ROBOTS, stamp_ns, np.array([0.1, 0.2]), at_ns):
        inbox.note_bearings(name, at_ns)


def due(inbox: TeamInbox, at_ns: int) -> Moment:
    moment = inbox.take_due(at_ns)
    assert moment is not None
    return moment


def test_a_moment_is_due_once_all_who_are_present_have_told_of_it() -> None:
    inbox = team()
    for name in TEAM:
        send(inbox, name, T)
    moment = due(inbox, T)
    assert moment.stamp_ns == T and tuple(moment.sights) == TEAM and not moment.missing
    send(inbox, "r1", T + 100 * MS)
    send(inbox, "r2", T + 100 * MS)
    assert inbox.take_due(T + 110 * MS) is None
    send(inbox, "r3", T + 120 * MS)
    assert due(inbox, T + 120 * MS).sights["r3"].stamp_ns == T + 120 * MS


def test_a_late_teammate_is_waited_for_but_not_long() -> None:
    inbox = team(wait_s=0.15, max_skew_s=0.05)
    for name in TEAM:
        send(inbox, name, T)
    due(inbox, T)
    send(inbox, "r1", T + 100 * MS)
    send(inbox, "r2", T + 100 * MS)
    assert inbox.take_due(T + 240 * MS) is None
    moment = due(inbox, T + 250 * MS)
    assert tuple(moment.sights) == ("r1", "r2")
    assert moment.missing == {"r3": "its nearest bearings were taken 0.10 s before"}
    assert [r.counts["moments missed"] for r in inbox.robots.values()] == [0, 0, 1]


def test_a_moment_comes_once_and_never_before_an_older_one() -> None:
    inbox = team(wait_s=0.0)
    send(inbox, "r1", T)
    assert due(inbox, T).stamp_ns == T
    send(inbox, "r1", T)  # doubled
    assert inbox.take_due(T + MS) is None
    send(inbox, "r1", T - 50 * MS, T + 2 * MS)  # late
    assert inbox.take_due(T + 2 * MS) is None


def test_of_two_moments_due_the_newer_counts() -> None:
    inbox = team(wait_s=0.5)
    for stamp in (T, T + 100 * MS):
        for name in TEAM:
            send(inbox, name, stamp)
    assert due(inbox, T + 100 * MS).stamp_ns == T + 100 * MS
    assert inbox.take_due(T + S) is None


def test_a_silent_robot_is_not_waited_for_and_comes_back() -> None:
    inbox = team(robot_timeout_s=2.0, wait_s=10.0)
    for name in TEAM:
        send(inbox, name, T)
    due(inbox, T)
    for name in ("r1", "r2"):
        send(inbox, name, T + 3 * S)
    moment = due(inbox, T + 3 * S)
    assert moment.missing == {"r3": "silent for more than 2 s"}
    for name in TEAM:
        send(inbox, name, T + 4 * S)
    assert tuple(due(inbox, T + 4 * S).sights) == TEAM


def test_who_was_never_heard_is_said() -> None:
    inbox = team()
    send(inbox, "r1", T)
    assert due(inbox, T).missing == {"r2": "never heard", "r3": "never heard"}


def test_without_its_own_bearings_another_leads() -> None:
    inbox = team(own="r1")
    for name in ("r2", "r3"):
        send(inbox, name, T)
    assert inbox.leader(T) == "r2"
    assert tuple(due(inbox, T).sights) == ("r2", "r3")
    send(inbox, "r1", T + 100 * MS)
    assert inbox.leader(T + 100 * MS) == "r1"


def test_a_clock_ahead_is_named_where_it_keeps_robots_apart() -> None:
    inbox = team()
    inbox.robots["r2"].clock.take_stamp(T + 900 * MS, T)
    send(inbox, "r1", T)
    send(inbox, "r2", T + 900 * MS, T)
    missing = due(inbox, T + 200 * MS).missing["r2"]
    assert "0.90 s after" in missing and "its clock is at least 0.900 s ahead" in missing


def test_a_leader_whose_clock_is_set_back_leads_on() -> None:
    inbox = team(wait_s=0.0)
    send(inbox, "r1", T)
    due(inbox, T)
    for k in range(12):
        send(inbox, "r1", T - 60 * S + k * 100 * MS, T + (k + 1) * 100 * MS)
    assert due(inbox, T + 2 * S).stamp_ns == T - 60 * S + 1100 * MS


def test_after_a_clear_all_is_as_before_the_first_message() -> None:
    inbox = team()
    send(inbox, "r1", T)
    inbox.clear()
    assert inbox.take_due(T + S) is None and inbox.leader(T) == ""


def test_views_come_in_the_order_of_the_team() -> None:
    inbox = team(own="r3")
    for name in ("r3", "r1", "r2"):
        send(inbox, name, T)
    assert [view.name for view in due(inbox, T).views] == list(TEAM)


def test_a_team_names_each_robot_once_whatever_its_slashes() -> None:
    assert TeamNodeConfig(team=("/r1", "r2/")).team == ("r1", "r2")
    with pytest.raises(ValueError, match="'r1' twice"):
        TeamNodeConfig(team=("/r1", "r1"))
    with pytest.raises(ValueError, match="namespaces such as r1"):
        TeamNodeConfig(team=("r 1",))


def test_seeded_loss_delay_and_doubling_never_mix_times() -> None:
    """Whatever the line does: sights of a moment are within max_skew_s, and moments go on."""
    rng = np.random.default_rng(0)
    inbox = team(max_skew_s=0.04, wait_s=0.2)
    arrivals = []
    for k in range(200):
        for number, name in enumerate(TEAM):
            stamp = T + k * 100 * MS + number * 7 * MS
            if name != "r1" and rng.random() < 0.3:
                continue
            for _ in range(1 + (rng.random() < 0.3)):
                delay = 0.0 if name == "r1" else rng.exponential(0.1)
                arrivals.append((stamp + round(delay * S), name, stamp))
    moments = []
    for at_ns, name, stamp in sorted(arrivals):
        send(inbox, name, stamp, at_ns)
        moments += [m for m in [inbox.take_due(at_ns)] if m is not None]
    stamps = [m.stamp_ns for m in moments]
    assert stamps == sorted(set(stamps)) and len(stamps) > 150
    skews = [abs(s.stamp_ns - m.stamp_ns) for m in moments for s in m.sights.values()]
    assert max(skews) <= 40 * MS
    shares = [len(m.sights) for m in moments]
    assert shares.count(3) > 40 and min(shares) >= 1


@pytest.mark.parametrize("back_s", [2, 8])
def test_after_a_clock_set_back_no_moment_of_the_time_before_comes(back_s: int) -> None:
    inbox = team(wait_s=0.1)
    at, stamps = T, []
    for k in range(60):
        at = T + k * 100 * MS
        for name in TEAM:
            send(inbox, name, at - (back_s * S if k >= 30 else 0), at)
        stamps += [m.stamp_ns for m in [inbox.take_due(at)] if m is not None]
    back = [b - a for a, b in zip(stamps, stamps[1:], strict=False) if b <= a]
    assert len(back) == 1 and stamps[-1] == at - back_s * S
    assert len(stamps) >= 48


def test_a_pose_that_is_known_nowhere_is_refused_as_if_none_was_sent() -> None:
    inbox = team()
    inbox.solver = TeamConfig(far_sd_m=2.0)
    send(inbox, "r1", T)
    for sd, is_taken in ((1000.0, False), (2.1, False), (1.9, True)):
        pose = PoseEstimate(SE2(1.0, 2.0, 0.0), np.diag([0.1, sd**2, 0.1]))
        if is_taken:
            inbox.take_pose("r1", T, pose, T)
        else:
            with pytest.raises(ValueError, match="too uncertain"):
                inbox.take_pose("r1", T, pose, T)
        rough = inbox.collect(T, T).views[0].rough
        assert (rough is not None) == is_taken
