"""Goals seen: each counts with the mask of its moment, once, and for what is new of it."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.goal_evidence import GoalsSeen, goal_likelihood
from multi_localizer.goals_waiting import GoalsWaiting

MS = 1_000_000


def seen(ms: int, kind: str = "blue") -> GoalsSeen:
    return GoalsSeen(kind, ms * MS, np.array([0.0]), SE2.identity())


def test_those_of_the_moment_are_taken_in_order_and_older_ones_forgotten() -> None:
    waiting = GoalsWaiting()
    for ms in (130, 20, 90, 300):
        waiting.add(seen(ms))
    assert [s.stamp_ns // MS for s in waiting.take(100 * MS, 0.05)] == [90, 130]
    assert len(waiting) == 1
    assert waiting.take(140 * MS, 0.05) == []


def test_too_many_are_not_kept() -> None:
    waiting = GoalsWaiting()
    for ms in range(500):
        waiting.add(seen(ms))
    assert len(waiting) <= 50
    assert len(waiting.take(499 * MS, 0.0)) == 1 and len(waiting) == 0


def test_what_is_seen_again_soon_counts_in_proportion() -> None:
    waiting = GoalsWaiting()
    counts = [waiting.count(seen(ms), 0.1) for ms in (0, 25, 125, 525, 525, 500)]
    assert counts == pytest.approx([1.0, 0.25, 1.0, 1.0, 0.0, 0.0])
    assert waiting.count(seen(525, "red"), 0.1) == 1.0
    waiting.clear()
    assert waiting.count(seen(10), 0.1) == 1.0


def test_any_of_the_bearings_may_be_the_goal_and_their_order_says_nothing() -> None:
    config, here = FloorTrackConfig(), SE2.identity()
    likelihood = lambda *b: goal_likelihood(here, np.array(b), (2.0, 0.0), config)  # noqa: E731
    peak = 1.0 / (np.sqrt(2.0 * np.pi) * config.goal_sd_rad)
    clutter = config.false_goal_share / (2.0 * np.pi)
    assert likelihood(0.0) == pytest.approx(clutter + (1.0 - config.false_goal_share) * peak)
    assert likelihood(3.0) == pytest.approx(clutter)
    half = clutter + 0.5 * (1.0 - config.false_goal_share) * peak
    assert likelihood(3.0, 0.0) == likelihood(0.0, 3.0) == pytest.approx(half)
