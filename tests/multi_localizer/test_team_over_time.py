"""Moments joined over time: better than each alone, and honest when robots vanish or are moved."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from multi_localizer.landmarks import Landmark
from multi_localizer.pose_estimate import PoseEstimate, difference, normalized_error
from multi_localizer.robot_inbox import ROBOTS, Classes
from multi_localizer.team_answers import TeamAnswers
from multi_localizer.team_config import TeamConfig
from multi_localizer.team_filter_config import TeamFilterConfig
from multi_localizer.team_inbox import TeamInbox
from multi_localizer.team_node_config import TeamTimingConfig

S = 1_000_000_000
PERIOD_NS = S // 10
START = {
    "a": SE2(-2.0, 0.3, 0.1), "b": SE2(-0.9, -1.2, 0.7), "c": SE2(-0.6, 1.5, -0.5),
    "d": SE2(2.0, -0.4, 3.0),
}  # fmt: skip
POLES = np.array([[4.0, 2.0], [-4.0, 2.0], [0.5, -2.5]])
LANDMARKS = {"pole": tuple(Landmark((tuple(p),)) for p in POLES.tolist())}
SD, SLIP = 0.02, 0.05
ROUGH_SD = (0.3, 0.3, 0.2)


class Drive:
    """Four robots that go round in circles, and what their cameras and wheels say."""

    def __init__(
        self,
        *,
        is_followed: bool,
        has_odometry: bool = True,
        has_poles: bool = True,
        rough_sd: tuple[float, float, float] = ROUGH_SD,
        seed: int = 0,
    ) -> None:
        kinds, landmarks = (frozenset({"pole"}), LANDMARKS) if has_poles else (frozenset(), {})
        self.inbox = TeamInbox(tuple(START), "a", TeamTimingConfig(), Classes(kinds))
        for robot in self.inbox.robots.values():
            robot.mount = SE2.identity()
        over_time = TeamFilterConfig(bearing_sd_rad=SD, repeat_s=0.0) if is_followed else None
        self._answers = TeamAnswers(self.inbox, landmarks, TeamConfig(bearing_sd_rad=SD), over_time)
        self._answers.poses_use_landmarks = has_poles
        self._rough_sd = np.array(rough_sd)
        self._rng = np.random.default_rng(seed)
        self._has_odometry = has_odometry
        self._odometry = dict.fromkeys(START, SE2.identity())
        self.poses = dict(START)
        self._stamp_ns = 100 * S
        self.back_ns = 0  # how far the stamps are set back
        self.notes: tuple[str, ...] = ()

    def step(self, silent: str = "") -> dict[str, PoseEstimate]:
        """Go on by a tenth of a second; return where the robots are found."""
        self._stamp_ns += PERIOD_NS
        for name in START:
            way = SE2(0.03, 0.0, -0.05 if name == "c" else 0.05)
            self.poses[name] = self.poses[name] @ way
            slip = 1.0 + self._rng.normal(0.0, SLIP, 2)
            told = SE2(way.x * slip[0], 0.0, way.yaw * slip[1])
            self._odometry[name] = self._odometry[name] @ told
        for name in START:
            if name != silent:
                self._say(name)
        moment = self.inbox.collect(self._stamp_ns - self.back_ns, self._stamp_ns)
        answer = self._answers.solve(moment)
        self.notes = tuple(answer.solution.notes)
        return dict(answer.bases)

    def _say(self, name: str) -> None:
        now, robot = self._stamp_ns - self.back_ns, self.inbox.robots[name]
        if self._has_odometry:
            robot.take_odometry(now, self._odometry[name], now)
        others = np.array([[p.x, p.y] for n, p in self.poses.items() if n != name])
        for kind, places in ((ROBOTS, others), ("pole", POLES)):
            robot.take_bearings(kind, now, self._seen(self.poses[name], places), now)
        off = SE2(*self._rng.normal(0.0, self._rough_sd).tolist())
        rough = PoseEstimate(self.poses[name] @ off, np.diag(self._rough_sd**2))
        robot.take_pose(now, rough, now)
        robot.heard_ns = self._stamp_ns

    def _seen(self, pose: SE2, places: np.ndarray) -> np.ndarray:
        bearings = [math.atan2(y - pose.y, x - pose.x) - pose.yaw for x, y in places]
        return np.array(bearings) + self._rng.normal(0.0, SD, len(places))


def rms(drive: Drive, num: int, skip: int) -> tuple[float, float]:
    """Return RMS error of positions and mean NEES."""
    squares, nees = [], []
    for k in range(num):
        for name, found in drive.step().items():
            if k >= skip:
                e = difference(found.pose, drive.poses[name])
                squares.append(e[0] ** 2 + e[1] ** 2)
                nees.append(normalized_error(found.pose, drive.poses[name], found.cov))
    return math.sqrt(np.mean(squares)), float(np.mean(nees))


def test_moments_joined_are_much_better_than_each_alone_and_not_too_sure() -> None:
    alone, _ = rms(Drive(is_followed=False), 60, 20)
    joined, nees = rms(Drive(is_followed=True), 60, 20)
    assert joined < 0.5 * alone
    assert nees < 3.5


def test_without_odometry_each_moment_counts_alone() -> None:
    one, other = (Drive(is_followed=f, has_odometry=False) for f in (False, True))
    for _ in range(3):
        a, b = one.step(), other.step()
        for name in START:
            assert a[name].pose.as_array() == pytest.approx(b[name].pose.as_array())


def test_a_robot_that_was_carried_away_is_found_by_the_third_moment_and_never_sold_wrong() -> None:
    drive = Drive(is_followed=True)
    for _ in range(20):
        drive.step()
    drive.poses["b"] = SE2(1.5, 1.6, -2.0)
    for k in range(3):
        found = drive.step()["b"]
        assert normalized_error(found.pose, drive.poses["b"], found.cov) < 20.0
        assert ("b: this moment contradicts its track" in drive.notes) is (k < 2)
    assert drive.poses["b"].between(found.pose).distance < 0.4


def test_one_moment_that_is_all_wrong_does_not_end_a_good_track() -> None:
    drive = Drive(is_followed=True)
    for _ in range(30):
        before = drive.step()["b"]
    true = drive.poses["b"]
    drive.poses["b"] = SE2(1.5, 1.6, -2.0)
    wide = drive.step()["b"]
    assert normalized_error(wide.pose, true, wide.cov) < 20.0
    drive.poses["b"] = true
    found = drive.step()["b"]
    assert true.between(found.pose).distance < 0.15
    assert np.trace(found.cov[:2, :2]) < 2.0 * np.trace(before.cov[:2, :2])


def test_without_landmarks_covariances_stay_true() -> None:
    """What robots share, where the team is as a whole, counts once and not once for each."""
    nees = []
    for seed in range(5):
        _, mean = rms(Drive(is_followed=True, has_poles=False, seed=seed), 51, 10)
        nees.append(mean)
    assert 1.5 < np.mean(nees) < 3.9


def test_own_poses_that_rest_on_something_else_count_at_each_moment() -> None:
    sharp = (0.05, 0.05, 0.03)
    alone, joined = (
        rms(Drive(is_followed=f, has_poles=False, rough_sd=sharp), 40, 20)[0] for f in (False, True)
    )
    assert joined < 0.5 * alone


@pytest.mark.parametrize("back_s", [0.3, 2.0, 8.0])
def test_stamps_that_go_back_begin_all_anew(back_s: float) -> None:
    drive = Drive(is_followed=True)
    for _ in range(20):
        drive.step()
    drive.back_ns = round(back_s * S)
    for robot in drive.inbox.robots.values():
        robot.clear()
    for _ in range(20):
        found = drive.step()
    assert found.keys() == START.keys()
    for name, estimate in found.items():
        assert drive.poses[name].between(estimate.pose).distance < 0.15


@pytest.mark.parametrize("num_silent", [10, 70])
def test_a_robot_that_drove_on_in_silence_is_where_it_is_when_it_comes_back(
    num_silent: int,
) -> None:
    drive = Drive(is_followed=True)
    for _ in range(10):
        drive.step()
    for _ in range(num_silent):
        drive.step(silent="d")
    found = drive.step()["d"]
    assert drive.poses["d"].between(found.pose).distance < 0.3
    assert normalized_error(found.pose, drive.poses["d"], found.cov) < 20.0
