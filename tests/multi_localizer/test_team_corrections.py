"""Bearings brought to one moment, and to the middles of wide landmarks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2, wrap_angle
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.team_corrections import Now, believed, corrected_views, largest_change
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


def view(then_ns: int) -> RobotView:
    """`a` saw the others and a goal then; its bearings are turned on to now, no more."""
    moved = {n: p if then_ns == NOW else p @ WAYS[n] for n, p in NOW_POSES.items()}
    turn = wrap_angle(NOW_POSES["a"].yaw - moved["a"].yaw)
    at = np.array([moved["a"].x, moved["a"].y])
    seen = [bearing(moved["a"], moved[n]) - turn for n in ("b", "c")]
    goal = bearing(moved["a"], GOAL.point_seen(at)) - turn
    return RobotView("a", np.array([*seen, 2.5]), {"goal": np.array([goal])})


@pytest.mark.parametrize("then_ns", [NOW, THEN])
def test_all_is_as_if_seen_now_and_in_the_middle(then_ns: int) -> None:
    seen, now = view(then_ns), Now(NOW, {"a": then_ns}, motion)
    (found,) = corrected_views([seen], now, solution(**NOW_POSES), {"goal": (GOAL,)})
    wanted = [bearing(NOW_POSES["a"], NOW_POSES[n]) for n in ("b", "c")]
    assert found.bearings[:2] == pytest.approx(wanted, abs=1e-12)
    assert found.bearings[2] == 2.5
    goal = bearing(NOW_POSES["a"], GOAL.position)
    assert found.landmark_bearings["goal"] == pytest.approx([goal], abs=1e-12)
    changes = [*(found.bearings - seen.bearings)]
    changes += [*(found.landmark_bearings["goal"] - seen.landmark_bearings["goal"])]
    assert largest_change([seen], [found]) == max(np.abs(changes)) > 0.001


def test_what_is_not_known_is_left_as_it_is() -> None:
    nobody_moves = lambda name, from_ns, to_ns: None  # noqa: E731
    for poses in ({}, {"a": NOW_POSES["a"]}):
        seen, now = view(THEN), Now(NOW, {"a": THEN}, nobody_moves)
        (found,) = corrected_views([seen], now, solution(**poses), {})
        assert found.bearings.tolist() == seen.bearings.tolist()
        assert largest_change([seen], [found]) == 0.0


def test_own_poses_tell_which_landmark_is_seen_where() -> None:
    marks = {"pole": (Landmark(((5.0, 0.0),)), Landmark(((0.0, 5.0),)))}
    rough = PoseEstimate(SE2(0.3, -0.2, 0.2), np.eye(3))
    seen = RobotView("a", np.zeros(0), {"pole": np.array([math.pi / 2, 0.0, -0.1])}, rough=rough)
    nobody = RobotView("b", np.zeros(0), {"pole": np.array([0.0])})
    first = believed([seen, nobody], marks)
    assert first.landmark_identities["a"]["pole"].tolist() == [1, 0, 0]
    assert set(first.estimates) == {"a"} and not first.identities
    assert believed([seen], {}).landmark_identities["a"]["pole"].tolist() == [NOBODY] * 3
