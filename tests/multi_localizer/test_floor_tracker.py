"""Which of the poses that fit is the robot's: settled, open, lost, carried away."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.floor_node_config import FloorTrackConfig
from multi_localizer.floor_tracker import FloorTracker, TrackState
from multi_localizer.goal_evidence import GoalsSeen
from multi_localizer.pose_estimate import PoseEstimate, difference

GOALS = {"goal_yellow": (1.55, 0.0), "goal_blue": (-1.55, 0.0)}
COV = np.diag([0.01, 0.01, 0.01]) ** 2
FRAME_NS = 100_000_000
CAMERA = SE2(0.0, 0.0, 0.0)
TURN = SE2(0.0, 0.0, math.pi)
STEP, STAY = SE2(0.03, 0.0, 0.05), SE2(0.0, 0.0, 0.0)
TOLD_COV = np.diag([0.2, 0.2, 0.3]) ** 2
TOL_M = 1e-9


def is_at(tracker: FloorTracker, pose: SE2) -> bool:
    known = tracker.estimate
    return known is not None and np.abs(difference(known.pose, pose)).max() < TOL_M


def both(pose: SE2) -> tuple[PoseEstimate, ...]:
    """Return a pose and its mate on a floor that looks the same turned round, the mate first."""
    return PoseEstimate(TURN @ pose, COV), PoseEstimate(pose, COV)


def goal_from(pose: SE2, kind: str, stamp_ns: int, off: float = 0.0) -> GoalsSeen:
    ((x, y),) = pose.inverse() @ np.array([GOALS[kind]])
    return GoalsSeen(kind, stamp_ns, np.array([math.atan2(y, x) + off]), CAMERA)


def drive(
    tracker: FloorTracker, start: SE2, num: int, *, first: int = 0, goals: tuple[str, ...] = (),
    odometry: SE2 | None = None, step: SE2 = STEP,
) -> SE2:  # fmt: skip
    """Move on by a step a mask; return where it ends."""
    pose = start
    for k in range(first, first + num):
        T_odom = None if odometry is None else odometry @ pose
        tracker.update(k * FRAME_NS, both(pose), "", T_odom)
        for kind in goals:
            tracker.see_goals(goal_from(pose, kind, k * FRAME_NS))
        pose = pose @ step
    return pose @ step.inverse()


@pytest.fixture
def tracker() -> FloorTracker:
    return FloorTracker(GOALS, FloorTrackConfig())


def test_without_goals_two_poses_stay_open_and_that_is_said(tracker: FloorTracker) -> None:
    drive(tracker, SE2(0.5, 0.2, 0.3), 30, odometry=SE2(3.0, 1.0, 2.0))
    assert tracker.state is TrackState.OPEN and tracker.estimate is None
    assert "2 poses fit alike" in tracker.reason and "goal_yellow" in tracker.reason


@pytest.mark.parametrize("kind", list(GOALS))
@pytest.mark.parametrize("odometry", [None, SE2(3.0, 1.0, 2.0)], ids=["no odom", "odom"])
def test_one_goal_settles_it_in_a_few_masks(
    tracker: FloorTracker, kind: str, odometry: SE2 | None
) -> None:
    end = drive(tracker, SE2(0.5, 0.2, 0.3), 4, goals=(kind,), odometry=odometry)
    assert tracker.state is TrackState.KNOWN and tracker.reason == ""
    assert is_at(tracker, end)


def test_what_was_settled_stays_so_without_goals(tracker: FloorTracker) -> None:
    pose = drive(tracker, SE2(0.5, 0.2, 0.3), 5, goals=("goal_blue",))
    end = drive(tracker, pose, 50, first=5)
    assert is_at(tracker, end)


def test_the_order_of_mask_and_goal_does_not_matter(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    for k in range(5):
        tracker.see_goals(goal_from(pose, "goal_blue", k * FRAME_NS))
        tracker.update(k * FRAME_NS, both(pose), "", None)
    other = FloorTracker(GOALS, FloorTrackConfig())
    drive(other, pose, 5, goals=("goal_blue",), step=STAY)
    assert tracker.hypotheses[0].share == pytest.approx(other.hypotheses[0].share)
    assert is_at(tracker, pose) and is_at(other, pose)


def test_a_goal_that_comes_twice_counts_once(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    tracker.update(0, both(pose), "", None)
    tracker.see_goals(goal_from(pose, "goal_blue", 0))
    share = tracker.hypotheses[0].share
    for _ in range(20):
        tracker.see_goals(goal_from(pose, "goal_blue", 0))
    assert tracker.hypotheses[0].share == share


def test_a_goal_of_another_moment_does_not_count(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    tracker.see_goals(goal_from(pose, "goal_blue", 0))
    tracker.update(5 * FRAME_NS, both(pose), "", None)
    tracker.see_goals(goal_from(pose, "goal_blue", FRAME_NS))
    assert tracker.hypotheses[0].share == 0.5


@pytest.mark.parametrize("bad", [np.array([]), np.array([math.nan]), np.array([math.inf])])
def test_goals_that_say_nothing_change_nothing(tracker: FloorTracker, bad: np.ndarray) -> None:
    tracker.update(0, both(SE2(0.5, 0.2, 0.3)), "", None)
    tracker.see_goals(GoalsSeen("goal_blue", 0, bad, CAMERA))
    tracker.see_goals(GoalsSeen("moon", 0, np.array([0.0]), CAMERA))
    assert tracker.hypotheses[0].share == 0.5


def test_false_goals_now_and_then_do_not_turn_it_over(tracker: FloorTracker) -> None:
    pose = drive(tracker, SE2(0.5, 0.2, 0.3), 5, goals=("goal_blue",), step=STAY)
    for k in range(5, 60):
        tracker.update(k * FRAME_NS, both(pose), "", None)
        off = math.pi if k % 5 == 0 else 0.0
        tracker.see_goals(goal_from(pose, "goal_blue", k * FRAME_NS, off))
        assert tracker.hypotheses[0].estimate.pose == pose


def test_goals_turn_a_wrong_pose_over_within_a_second(tracker: FloorTracker) -> None:
    wrong = SE2(0.5, 0.2, 0.3)
    drive(tracker, wrong, 20, goals=tuple(GOALS), step=STAY)
    drive(tracker, TURN @ wrong, 10, first=20, goals=("goal_blue",), step=STAY)
    assert is_at(tracker, TURN @ wrong)


@pytest.mark.parametrize("odometry", [None, SE2(3.0, 1.0, 2.0)], ids=["no odom", "odom"])
def test_carried_away_it_is_found_again_within_a_second(
    tracker: FloorTracker, odometry: SE2 | None
) -> None:
    drive(tracker, SE2(0.5, 0.2, 0.3), 10, goals=("goal_blue",), odometry=odometry)
    there = SE2(-0.9, -0.4, 2.5)
    back = None if odometry is None else odometry @ SE2(0.5, 0.2, 0.3) @ there.inverse()
    drive(tracker, there, 2, first=10, goals=("goal_blue",), odometry=back, step=STAY)
    assert tracker.estimate is None and "does not follow" in tracker.reason
    drive(tracker, there, 8, first=12, goals=("goal_blue",), odometry=back, step=STAY)
    assert tracker.num_carried == 1 and is_at(tracker, there)


@pytest.mark.parametrize("rate_hz", [5, 30, 60])
def test_how_many_images_a_second_there_are_does_not_matter_for_it(
    tracker: FloorTracker, rate_hz: int
) -> None:
    pose, there, odom = SE2(0.5, 0.2, 0.3), SE2(-0.9, -0.4, 2.5), SE2(3.0, 1.0, 2.0)
    for k in range(2 * rate_hz + 1):
        at = pose if k < rate_hz else there
        stamp_ns = k * 1_000_000_000 // rate_hz
        tracker.update(stamp_ns, both(at), "", odom @ pose)
        tracker.see_goals(goal_from(at, "goal_blue", stamp_ns))
        assert tracker.estimate is None or is_at(tracker, at)
    assert is_at(tracker, there) and tracker.num_carried == 1


def test_carried_away_without_goals_it_is_open_again(tracker: FloorTracker) -> None:
    drive(tracker, SE2(0.5, 0.2, 0.3), 10, goals=("goal_blue",))
    drive(tracker, SE2(-0.9, -0.4, 2.5), 10, first=10)
    assert tracker.state is TrackState.OPEN


def test_one_wrong_fit_gives_no_pose_and_is_forgotten(tracker: FloorTracker) -> None:
    pose = drive(tracker, SE2(0.5, 0.2, 0.3), 10, goals=("goal_blue",), step=STAY)
    tracker.update(10 * FRAME_NS, both(SE2(-0.5, 0.4, 2.0)), "", None)
    assert tracker.estimate is None
    drive(tracker, pose, 1, first=11, step=STAY)
    assert is_at(tracker, pose) and tracker.num_carried == 0


def test_without_odometry_a_long_gap_is_not_bridged(tracker: FloorTracker) -> None:
    pose = drive(tracker, SE2(0.5, 0.2, 0.3), 10, goals=("goal_blue",), step=STAY)
    for k in range(10, 15):
        tracker.update(k * FRAME_NS, (), "nothing but hands", None)
    drive(tracker, TURN @ pose, 1, first=15, step=STAY)
    assert tracker.state is TrackState.OPEN


def test_masks_without_a_pose_are_bridged_by_odometry(tracker: FloorTracker) -> None:
    odom = SE2(3.0, 1.0, 2.0)
    pose = drive(tracker, SE2(-0.9, 0.2, 0.3), 10, goals=("goal_blue",), odometry=odom)
    for k in range(10, 20):
        pose = pose @ SE2(0.05, 0.0, 0.1)
        tracker.update(k * FRAME_NS, (), "nothing but hands", odom @ pose)
        assert tracker.state is TrackState.LOST and tracker.reason == "nothing but hands"
    drive(tracker, pose @ SE2(0.05, 0.0, 0.1), 1, first=20, odometry=odom)
    assert is_at(tracker, pose @ SE2(0.05, 0.0, 0.1))


def test_somebody_who_says_where_it_is_settles_it(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    drive(tracker, pose, 3, step=STAY)
    tracker.relocate(PoseEstimate(SE2(0.4, 0.3, 0.5), TOLD_COV))
    assert is_at(tracker, pose) and tracker.take_refusal() == ""


def test_somebody_who_says_it_before_the_first_mask_is_remembered(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    tracker.relocate(PoseEstimate(SE2(0.4, 0.3, 0.5), TOLD_COV))
    tracker.update(0, (), "nothing but hands", SE2.identity())
    driven = pose @ SE2(0.2, 0.1, math.pi)  # by odometry; its mate is as far off as it can be
    odometry = pose.between(driven) @ driven.inverse()
    drive(tracker, driven, 3, first=1, step=STAY, odometry=odometry)
    assert is_at(tracker, driven)


def test_somebody_who_says_what_fits_nowhere_is_not_believed(tracker: FloorTracker) -> None:
    pose, far = SE2(0.5, 0.2, 0.3), PoseEstimate(SE2(50.0, 0.0, 0.3), TOLD_COV)
    tracker.relocate(far)
    drive(tracker, pose, 1, step=STAY)
    assert "49.50 m" in tracker.take_refusal() and tracker.take_refusal() == ""
    drive(tracker, pose, 3, first=1, step=STAY)
    tracker.relocate(far)
    assert "none of the 2 poses" in tracker.take_refusal()
    assert tracker.state is TrackState.OPEN and tracker.hypotheses[0].share == 0.5


def test_a_plan_of_one_pose_needs_no_goal_but_three_masks() -> None:
    tracker = FloorTracker({}, FloorTrackConfig())
    pose = PoseEstimate(SE2(0.5, 0.2, 0.3), COV)
    for k in range(2):
        tracker.update(k * FRAME_NS, (pose,), "", None)
        assert tracker.state is TrackState.OPEN and f"{k + 1} of 3 masks" in tracker.reason
    tracker.update(2 * FRAME_NS, (pose,), "", None)
    assert tracker.estimate is pose


def test_masks_that_contradict_each_other_settle_nothing() -> None:
    tracker = FloorTracker({}, FloorTrackConfig())
    for k in range(30):
        pose = SE2(0.5 if k % 2 else -0.5, 0.2, 0.3 * k)
        tracker.update(k * FRAME_NS, (PoseEstimate(pose, COV),), "", None)
        assert tracker.estimate is None


@pytest.mark.parametrize("cover_s", [2.0, 10.0])
@pytest.mark.parametrize("has_masks", [True, False], ids=["covered", "no masks"])
def test_turned_by_hand_unseen_the_mate_is_not_taken_for_it(
    tracker: FloorTracker, cover_s: float, has_masks: bool
) -> None:
    """Odometry sees nothing of it: the robot hangs in the air."""
    pose, odom = SE2(0.5, 0.2, 0.3), SE2(3.0, 1.0, 2.0)
    drive(tracker, pose, 30, goals=("goal_blue",), step=STAY, odometry=odom)
    assert tracker.state is TrackState.KNOWN
    first = 30 + round(10 * cover_s)
    if has_masks:
        for k in range(30, first):
            tracker.update(k * FRAME_NS, (), "nothing but hands", odom @ pose)
    turned = TURN @ pose
    back = odom @ pose @ turned.inverse()
    drive(tracker, turned, 30, first=first, step=STAY, odometry=back)
    assert tracker.state is TrackState.OPEN and tracker.estimate is None
    drive(tracker, turned, 8, first=first + 30, goals=("goal_blue",), step=STAY, odometry=back)
    assert is_at(tracker, turned)


def test_where_the_believed_pose_fits_no_more_the_mate_does_not_take_its_place(
    tracker: FloorTracker,
) -> None:
    pose, odom = SE2(0.5, 0.2, 0.3), SE2.identity()
    drive(tracker, pose, 10, goals=("goal_blue",), step=STAY, odometry=odom)
    mate = PoseEstimate(TURN @ pose, COV)
    tracker.update(10 * FRAME_NS, (mate,), "", odom @ pose)
    assert tracker.state is TrackState.LOST


def test_a_rival_that_one_mask_does_not_show_is_not_forgotten() -> None:
    tracker = FloorTracker({}, FloorTrackConfig())
    here, rival = (PoseEstimate(SE2(x, 0.2, 0.3), COV) for x in (0.5, -0.7))
    for k in range(5):
        tracker.update(k * FRAME_NS, (here, rival), "", SE2.identity())
    tracker.update(5 * FRAME_NS, (here,), "", SE2.identity())
    assert tracker.state is TrackState.OPEN
    for k in range(6, 12):
        tracker.update(k * FRAME_NS, (here,), "", SE2.identity())
    assert tracker.estimate is here


@pytest.mark.parametrize(("cost", "state"), [(0.12, TrackState.OPEN), (0.3, TrackState.KNOWN)])
def test_how_well_poses_fit_tells_them_apart_in_time(cost: float, state: TrackState) -> None:
    tracker = FloorTracker({}, FloorTrackConfig())
    here, rival = (PoseEstimate(SE2(x, 0.2, 0.3), COV) for x in (0.5, -0.7))
    for k in range(10):
        tracker.update(k * FRAME_NS, (rival, here), "", SE2.identity(), (cost, 0.1))
        assert k > 1 or tracker.state is TrackState.OPEN
    assert tracker.state is state
    assert state is TrackState.OPEN or tracker.estimate is here


def test_of_twelve_poses_goals_choose_the_right_one(tracker: FloorTracker) -> None:
    places = [SE2(-1.0 + 0.18 * k, 0.4 * math.sin(k), 0.5 * k) for k in range(12)]
    for k in range(10):
        tracker.update(k * FRAME_NS, [PoseEstimate(p, COV) for p in places], "", SE2.identity())
        for kind in GOALS:
            tracker.see_goals(goal_from(places[7], kind, k * FRAME_NS))
    assert is_at(tracker, places[7])


def test_more_images_a_second_tell_no_more(tracker: FloorTracker) -> None:
    pose, other = SE2(0.5, 0.2, 0.3), FloorTracker(GOALS, FloorTrackConfig())
    for t, num in ((tracker, 2), (other, 11)):
        for k in range(num):
            stamp_ns = k * FRAME_NS // (num - 1)
            t.update(stamp_ns, both(pose), "", SE2.identity())
            t.see_goals(goal_from(pose, "goal_blue", stamp_ns, 0.5))
    assert tracker.hypotheses[0].share == pytest.approx(other.hypotheses[0].share)
    assert tracker.hypotheses[0].share < 0.98


def test_more_images_a_second_do_not_tell_poses_apart_sooner() -> None:
    shares = []
    for num in (2, 11):
        tracker = FloorTracker({}, FloorTrackConfig())
        for k in range(num):
            fits = [PoseEstimate(SE2(x, 0.2, 0.3), COV) for x in (0.5, -0.7)]
            tracker.update(k * FRAME_NS // (num - 1), fits, "", SE2.identity(), (0.1, 0.2))
        shares.append(tracker.hypotheses[0].share)
    assert shares[0] == pytest.approx(shares[1]) and 0.5 < shares[0] < 0.98


def test_a_larger_thing_of_the_goals_color_does_not_hide_the_goal(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    for k in range(6):
        tracker.update(k * FRAME_NS, both(pose), "", SE2.identity())
        goal = goal_from(pose, "goal_blue", k * FRAME_NS)
        bearings = np.array([goal.bearings[0] + math.pi / 2, goal.bearings[0]])
        tracker.see_goals(replace(goal, bearings=bearings))
    assert is_at(tracker, pose)


def test_goals_of_the_time_before_a_jump_back_do_not_come_again(tracker: FloorTracker) -> None:
    pose, wrong = SE2(0.5, 0.2, 0.3), TURN @ SE2(0.5, 0.2, 0.3)
    drive(tracker, pose, 1, first=1000, step=STAY)
    for k in range(1001, 1004):
        tracker.see_goals(goal_from(wrong, "goal_blue", k * FRAME_NS))
    drive(tracker, pose, 10, step=STAY)
    drive(tracker, pose, 10, first=1000, step=STAY)
    assert tracker.hypotheses[0].share == pytest.approx(0.5)


def test_goals_count_after_a_jump_back(tracker: FloorTracker) -> None:
    pose = SE2(0.5, 0.2, 0.3)
    drive(tracker, pose, 5, first=1000, goals=("goal_blue",), step=STAY)
    drive(tracker, TURN @ pose, 5, goals=("goal_blue",), step=STAY)
    assert is_at(tracker, TURN @ pose)


def test_a_plan_without_goals_says_what_would_help() -> None:
    tracker = FloorTracker({}, FloorTrackConfig())
    tracker.update(0, both(SE2(0.5, 0.2, 0.3)), "", None)
    assert "initialpose" in tracker.reason


def test_turning_the_world_round_turns_the_answer_round() -> None:
    turned = {kind: (-x, -y) for kind, (x, y) in GOALS.items()}
    tracker, other = (FloorTracker(g, FloorTrackConfig()) for g in (GOALS, turned))
    pose = SE2(0.5, 0.2, 0.3)
    for k in range(5):
        seen = goal_from(pose, "goal_blue", k * FRAME_NS)
        for t in (tracker, other):
            t.update(k * FRAME_NS, both(pose), "", None)
            t.see_goals(seen)
    assert is_at(tracker, pose) and is_at(other, TURN @ pose)


def test_its_settings_may_change_while_it_runs(tracker: FloorTracker) -> None:
    drive(tracker, SE2(0.5, 0.2, 0.3), 1, goals=("goal_blue",))
    assert tracker.state is TrackState.OPEN
    tracker.config = replace(tracker.config, settle_share=0.6, settle_masks=1)
    assert tracker.state is TrackState.KNOWN
