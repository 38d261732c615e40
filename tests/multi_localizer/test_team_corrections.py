"""Bearings brought to one moment, and to the middles of wide landmarks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.robot_inbox import Sight
from multi_localizer.team_corrections import corrected_views
from multi_localizer.team_inbox import Moment
from multi_localizer.team_views import NOBODY, RobotView, TeamSolution

S = 1_000_000_000
NOW, THEN = 100 * S, 100 * S - S // 5
NAMES = ("a", "b", "c")
NOW_POSES = {"a": SE2(0.0, 0.0, 0.3), "b": SE2(3.0, 1.0, -2.0), "c": SE2(-1.0, 2.0, 1.0)}
WAYS = {"a": SE2(-0.2, 0.05, -0.1), "b": SE2(0.1, 0.1, 0.2), "c": SE2(0.0, 0.0, 0.0)}
GOAL = Landmark(((4.0, 0.5), (5.0, 0.5), (5.0, 2.5), (4.0, 2.5)))


def bearing(place: SE2, to: np.ndarray | SE2) -> float:
    x, y = (to.x, to.y) if isinstance(to, SE2) else to
    return wrap_angle(math.atan2(y - place.y, x - place.x) - place.yaw)


def motion(name: str, from_ns: int, to_ns: int) -> SE2:
    """Odometry between now and then."""
    if from_ns == to_ns:
        return SE2.identity()
    return WAYS[name] if (from_ns, to_ns) == (NOW, THEN) else WAYS[name].inverse()


def solution(**poses: SE2) -> TeamSolution:
    return TeamSolution(
        NAMES,
        estimates={n: PoseEstimate(p, np.eye(3)) for n, p in poses.items()},
        identities={"a": np.array([1, 2, NOBODY])},
        landmark_identities={"a": {"goal": np.array([0])}},
    )


def moment(then_ns: int) -> Moment:
    """`a` saw the others and a goal then; its bearings are turned on to now, no more."""
    moved = {n: p if then_ns == NOW else p @ WAYS[n] for n, p in NOW_POSES.items()}
    turn = wrap_angle(NOW_POSES["a"].yaw - moved["a"].yaw)
    at = np.array([moved["a"].x, moved["a"].y])
    seen = [bearing(moved["a"], moved[n]) - turn for n in ("b", "c")]
    goal = bearing(moved["a"], GOAL.point_seen(at)) - turn
    view = RobotView("a", np.array([*seen, 2.5]), {"goal": np.array([goal])})
    return Moment(NOW, {"a": Sight(view, then_ns)})


@pytest.mark.parametrize("then_ns", [NOW, THEN])
def test_all_is_as_if_seen_now_and_in_the_middle(then_ns: int) -> None:
    (view,), most = corrected_views(
        moment(then_ns), solution(**NOW_POSES), {"goal": (GOAL,)}, motion
    )
    wanted = [bearing(NOW_POSES["a"], NOW_POSES[n]) for n in ("b", "c")]
    assert view.bearings[:2] == pytest.approx(wanted, abs=1e-12)
    assert view.bearings[2] == 2.5
    goal = bearing(NOW_POSES["a"], GOAL.position)
    assert view.landmark_bearings["goal"] == pytest.approx([goal], abs=1e-12)
    assert most > (0.02 if then_ns == THEN else 0.0)


def test_what_is_not_known_is_left_as_it_is() -> None:
    nobody_moves = lambda name, from_ns, to_ns: None  # noqa: E731
    for poses in ({}, {"a": NOW_POSES["a"]}):
        (view,), most = corrected_views(moment(THEN), solution(**poses), {}, nobody_moves)
        assert view.bearings.tolist() == moment(THEN).sights["a"].view.bearings.tolist()
        assert most == 0.0
