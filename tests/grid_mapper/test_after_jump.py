"""After a jump: one scan that fits says little, scans that go on to fit say where the robot is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from worlds import scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper.after_jump import Guess, looked_at, settled
from grid_mapper.config import GridMapperConfig
from grid_mapper.dead_reckoning import OdometryWatch
from grid_mapper.mapper import GridMapper
from grid_mapper.scan_matcher import MatchResult

CONFIG = GridMapperConfig()
HERE = SE2.identity()
AHEAD = SE2(0.3, 0.0, 0.0)
NS = 1_000_000_000
T_BASE_LASER = SE2(0.1, 0.0, 0.05)


def fit_at(pose, overlap=0.95):
    return MatchResult(pose, 1e4 * np.eye(3), overlap, 0.95, 100, 1.0)


def after(poses, moved=AHEAD, has_odom=True):
    guess = Guess(SE2.identity())
    for pose in poses:
        guess = looked_at(guess, fit_at(pose), moved, has_odom, CONFIG)
    return guess


def test_a_guess_is_right_once_scans_fit_along_half_a_meter():
    ways = {n: after([SE2(0.3 * k, 0.0, 0.0) for k in range(1, n + 1)]) for n in (1, 2, 3)}
    assert [settled([ways[n]]) for n in (1, 2, 3)] == [None, None, 0]
    assert ways[3].fits_since == AHEAD and ways[3].pose.x == pytest.approx(0.9)


def test_a_scan_that_does_not_fit_begins_it_anew():
    guess = after([SE2(0.3 * k, 0.0, 0.0) for k in range(1, 4)])
    guess = looked_at(guess, fit_at(guess.pose, overlap=0.5), AHEAD, True, CONFIG)
    assert guess == Guess(SE2(0.3 * 3, 0.0, 0.0) @ AHEAD) and settled([guess]) is None


def test_fits_that_odometry_does_not_expect_do_not_add_up():
    jumping = [SE2(0.3 * k, 0.25 * (k % 2), 0.0) for k in range(1, 6)]
    assert settled([after(jumping)]) is None
    assert settled([after(jumping, has_odom=False)]) == 0


def test_while_another_guess_fits_too_neither_is_right():
    here = after([SE2(0.3 * k, 0.0, 0.0) for k in range(1, 4)])
    there = replace(here, pose=SE2(5.0, 5.0, 0.0), fits_since=SE2(5.0, 5.0, 0.0))
    assert settled([here, there]) is None and settled([there, here]) is None
    assert settled([here, Guess(SE2(5.0, 5.0, 0.0))]) == 0
    assert settled([here, here]) == 0
    assert settled([Guess(SE2.identity())]) is None


def insert(mapper, k, truth, odom):
    scan = scan_at(truth @ T_BASE_LASER, square_room(), rng=np.random.default_rng(abs(k)))
    return mapper.insert_scan(k * NS // 4, scan, T_BASE_LASER, odom)


def test_a_jump_of_odometry_finds_no_robot_that_is_lost():
    mapper = GridMapper(CONFIG)
    way = [SE2(0.1 * k, 0.0, 0.0) for k in range(12)]
    for k, pose in enumerate(way):
        insert(mapper, k, pose, pose)
    mapper.lose()
    jumped = SE2(30.0, 0.0, 0.0)
    results = [insert(mapper, 20 + k, pose, jumped @ pose) for k, pose in enumerate(way)]
    assert not any(r.is_trusted for r in results)
    mapper.relocate(way[-1])
    assert insert(mapper, 40, way[-1], jumped @ way[-1]).is_trusted


def test_after_a_jump_of_time_it_goes_on_after_half_a_meter_and_not_before():
    mapper = GridMapper(CONFIG)
    way = [SE2(0.1 * k, 0.0, 0.0) for k in range(14)]
    for k, pose in enumerate(way[:3]):
        insert(mapper, k, pose, pose)
    mapper.break_motion()
    results = [
        insert(mapper, 3 + k, pose, SE2(30.0, 0.0, 1.0) @ pose) for k, pose in enumerate(way[3:])
    ]
    assert [r.is_trusted for r in results[:4]] == [False] * 4
    assert all(r.is_trusted for r in results[7:])
    T_map_world = way[0].inverse()
    assert (T_map_world @ way[-1]).between(results[-1].T_map_base).distance < 0.03


def standing_after_a_jump_of_time(jumped):
    """Drive 0.3 m, let time jump, and stand; odometry is set off by `jumped`."""
    mapper = GridMapper(CONFIG)
    way = [SE2(0.1 * k, 0.0, 0.0) for k in range(4)]
    for k, pose in enumerate(way):
        insert(mapper, k, pose, pose)
    mapper.break_motion()
    mapper.break_motion()  # transforms and the clock tell of it, one after the other
    here = way[-1] @ SE2(0.2, 0.05, 0.1)
    results = [insert(mapper, -20 + k, here, jumped @ here) for k in range(5)]
    return results, way[0].inverse() @ here


def test_a_robot_that_stands_is_where_odometry_says_after_a_jump_of_time_alone():
    results, truth = standing_after_a_jump_of_time(SE2.identity())
    assert all(r.is_trusted for r in results)
    assert truth.between(results[0].T_map_base).distance < 0.03


def test_a_robot_that_stands_is_not_found_after_a_jump_of_time_and_odometry():
    results, _ = standing_after_a_jump_of_time(SE2(2.0, 0.0, 0.0))
    assert not any(r.is_trusted for r in results)


@pytest.mark.parametrize("odoms", [[0.2], [None, 0.2], [0.5, 0.7]])
def test_odometry_goes_on_over_a_jump_of_time(odoms):
    watch = OdometryWatch()
    assert not watch.take(0, HERE, CONFIG.motion)
    watch.break_time()
    for odom in odoms:
        pose = None if odom is None else SE2(odom, 0.0, 0.0)
        assert not watch.take(-100 * NS, pose, CONFIG.motion)


@pytest.mark.parametrize("odom", [SE2(0.6, 0.0, 0.0), SE2(0.0, 0.0, 3.0)])
def test_odometry_that_is_elsewhere_after_a_jump_of_time_has_jumped(odom):
    watch = OdometryWatch()
    watch.take(0, HERE, CONFIG.motion)
    watch.break_time()
    assert not watch.take(-100 * NS, None, CONFIG.motion)
    assert watch.take(-100 * NS, odom, CONFIG.motion)
    assert not watch.take(-99 * NS, odom, CONFIG.motion)


def test_time_that_jumps_before_there_is_odometry_leaves_the_robot_anywhere():
    watch = OdometryWatch()
    watch.break_time()
    assert watch.take(0, HERE, CONFIG.motion)
