"""From moments to poses of base_link: mounts, robots in motion, missing poses, liars."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate
from multi_localizer.robot_inbox import ROBOTS, Classes
from multi_localizer.team_answers import TeamAnswers
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_inbox import TeamInbox
from multi_localizer.team_node_config import TeamTimingConfig

S = 1_000_000_000
T = 100 * S
START = {
    "a": SE2(-2.0, 0.3, 0.1), "b": SE2(-0.9, -1.2, 0.7), "c": SE2(-0.6, 1.5, -0.5),
    "d": SE2(2.0, -0.4, 3.0),
}  # fmt: skip
MOTION = SE2(0.8, 0.0, 0.6)  # of each robot in a second
MOUNT = SE2(0.1, 0.05, 0.3)
POLES = np.array([[4.0, 2.0], [-4.0, 2.0], [0.5, -2.5]])
LANDMARKS = {"pole": tuple(Landmark((tuple(p),)) for p in POLES.tolist())}
SEEN_AFTER = {"a": 0.0, "b": 0.3, "c": -0.2, "d": 0.1}  # s, after the moment
TOL_M, TOL_RAD = 2e-3, 1e-3


def pose_at(name: str, t: float) -> SE2:
    """Drive along the body's axes by MOTION a second, in steps as the odometry reports them."""
    pose = START[name]
    for _ in range(round((t + 1.0) * 100)):
        pose = pose @ SE2(MOTION.x / 100, 0.0, MOTION.yaw / 100)
    return pose


def bearings(name: str, t: float, places: list[np.ndarray]) -> np.ndarray:
    camera = pose_at(name, t) @ MOUNT
    return np.array([math.atan2(y - camera.y, x - camera.x) - camera.yaw for x, y in places])


def full_inbox(without_pose: str = "", making_up: str = "") -> TeamInbox:
    rng = np.random.default_rng(0)
    inbox = TeamInbox(tuple(START), "a", TeamTimingConfig(), Classes(frozenset({"pole"})))
    for name, robot in inbox.robots.items():
        robot.mount = MOUNT
        for k in range(-60, 61):
            robot.take_odometry(T + k * S // 100, pose_at(name, k / 100), T)
        after = SEEN_AFTER[name]
        stamp = T + round(after * S)
        cameras = [pose_at(n, after) @ MOUNT for n in START if n != name]
        robots = [np.array([p.x, p.y]) for p in cameras]
        told = {ROBOTS: bearings(name, after, robots), "pole": bearings(name, after, list(POLES))}
        for kind, values in told.items():
            made_up = rng.uniform(-np.pi, np.pi, len(values))
            robot.take_bearings(kind, stamp, made_up if name == making_up else values, T)
        if name != without_pose:
            off = SE2(0.1, -0.1, 0.05)
            rough = PoseEstimate(pose_at(name, 0.0) @ off, np.diag([0.04, 0.04, 0.01]))
            robot.take_pose(T, rough, T)
        robot.heard_ns = T
    return inbox


@pytest.mark.parametrize("without_pose", ["", "c"])
def test_moving_robots_whose_images_are_half_a_second_apart_are_placed_exactly(
    without_pose: str,
) -> None:
    inbox = full_inbox(without_pose)
    answers = TeamAnswers(inbox, LANDMARKS, TeamConfig(bearing_sd_rad=0.01))
    answer = answers.solve(inbox.collect(T, T))
    assert set(answer.bases) == set(START)
    for name, found in answer.bases.items():
        off = pose_at(name, 0.0).between(found.pose)
        assert off.distance < TOL_M and abs(off.yaw) < TOL_RAD
    assert answer.most_change > 0.05


def test_a_robot_without_a_pose_begins_where_the_team_had_it() -> None:
    inbox = full_inbox()
    answers = TeamAnswers(inbox, LANDMARKS, TeamConfig(bearing_sd_rad=0.01))
    first = answers.solve(inbox.collect(T, T))
    view = inbox.collect(T, T).views[2]
    prepared = answers._prepared(
        type(view)(view.name, view.bearings, view.landmark_bearings), T + S // 10
    )
    assert prepared.rough is not None and prepared.rough_from_landmarks
    moved = first.bases["c"].pose.between(prepared.rough.pose @ MOUNT.inverse())
    assert moved.distance == pytest.approx(0.08, abs=0.01)
    assert prepared.rough.cov[0, 0] > 0.5**2  # else it would be counted again and again
    answers.forget()
    assert answers._prepared(type(view)(view.name, view.bearings), T).rough is None


@pytest.mark.parametrize("making_up", ["", "d"])
def test_a_suspect_is_placed_only_where_what_it_sees_fits(making_up: str) -> None:
    inbox = full_inbox("d", making_up)
    away = pose_at("d", 0.0) @ SE2(3.0, 0.0, 1.0)
    inbox.robots["d"].take_pose(T, PoseEstimate(away, np.diag([0.04, 0.04, 0.01])), T)
    answers = TeamAnswers(inbox, LANDMARKS, TeamConfig(bearing_sd_rad=0.01))
    answer = answers.solve(inbox.collect(T, T))
    assert answer.solution.suspects == ("d",)
    assert set(answer.bases) == ({"a", "b", "c"} if making_up else set(START))
    if not making_up:
        assert pose_at("d", 0.0).between(answer.bases["d"].pose).distance < TOL_M
