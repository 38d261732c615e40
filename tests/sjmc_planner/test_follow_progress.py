"""When a path is given up, and as what."""

from __future__ import annotations

import pytest

from floornav_common.se2 import SE2
from sjmc_planner.follow_config import FollowConfig
from sjmc_planner.follow_progress import FollowProgress, Outcome
from sjmc_planner.planning import BLOCKED, DRIVING, REACHED, WAITING

DT = 0.25  # a power of two: sums are exact
STILL = SE2(0.0, 0.0, 0.0)
CONFIG = FollowConfig(failure_tolerance_s=1.0, patience_s=2.0, progress_m=0.3, progress_s=4.0)


def ended_after(states, moved=STILL) -> tuple[int, Outcome] | None:
    """Return after how many calls it ended and how; None if it goes on."""
    progress = FollowProgress(CONFIG)
    for i, (state, reason) in enumerate(states):
        outcome = progress.update(state, reason, moved, DT)
        if outcome is not None:
            return i + 1, outcome
    return None


def test_at_the_goal_it_is_there():
    assert ended_after([(DRIVING, "")] * 3 + [(REACHED, "")]) == (4, Outcome("NONE"))


@pytest.mark.parametrize(
    ("reason", "code"), [("pose: old", "TF_ERROR"), ("/scan: late", "CONTROLLER_TIMED_OUT")]
)
def test_a_missing_input_ends_it_once_the_tolerance_is_over(reason, code):
    """More than 1 s: the fifth call."""
    assert ended_after([("stopped", reason)] * 9) == (5, Outcome(code, reason))


def test_an_input_that_comes_back_in_time_is_forgotten():
    states = ([("stopped", "pose: old")] * 4 + [(DRIVING, "")]) * 3
    assert ended_after(states, moved=SE2(0.1, 0.0, 0.0)) is None


@pytest.mark.parametrize("state", [BLOCKED, WAITING])
def test_standing_ends_it_once_patience_is_over(state):
    assert ended_after([(state, "why")] * 20) == (9, Outcome("PATIENCE_EXCEEDED", "why"))


def test_going_on_the_spot_is_no_progress():
    """0.3 m are never reached by turning."""
    ended = ended_after([(DRIVING, "")] * 40, moved=SE2(0.0, 0.0, 0.5))
    assert ended is not None and ended[0] == 17 and ended[1].code == "FAILED_TO_MAKE_PROGRESS"


def test_to_and_fro_is_no_progress_and_going_on_is():
    progress = FollowProgress(CONFIG)
    steps = [SE2(0.1, 0.0, 0.0), SE2(-0.1, 0.0, 0.0)]
    codes = [progress.update(DRIVING, "", steps[i % 2], DT) for i in range(20)]
    assert codes[15] is None and codes[16] is not None
    assert ended_after([(DRIVING, "")] * 100, moved=SE2(0.02, 0.0, 0.0)) is None
