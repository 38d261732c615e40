"""What goes nearer than the sensor sees stays known, as long as that is sure."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.growth import wedges_of
from sjmc_planner.near_memory import NearMemory
from sjmc_planner.planning import Obstacles

BLIND = 0.2
NUM = 180
AHEAD = slice(85, 96)
STILL = SE2.identity()


def wedges(ahead: float, mount: SE2 = STILL):
    """Return the wedges of a scan that shows something ahead, 22 degrees wide."""
    ranges = np.full(NUM, np.inf)
    ranges[AHEAD] = ahead
    scan = Scan(ranges, -np.pi, 2.0 * np.pi / NUM, BLIND, 3.0)
    return wedges_of(Obstacles(scan, mount), 0.1)


def test_what_comes_too_near_keeps_its_place():
    """Seen 0.25 m ahead; after 0.1 m towards it, it is 0.15 m ahead."""
    memory = NearMemory()
    memory.update(wedges(0.25), STILL)
    seen = memory.update(wedges(-np.inf), SE2(0.1, 0.0, 0.0))
    assert seen.ranges[90] == pytest.approx(0.15, abs=1e-3)
    again = memory.update(wedges(-np.inf), SE2(0.03, 0.0, 0.0))
    assert again.ranges[90] == pytest.approx(0.12, abs=1e-3)


def test_what_was_never_seen_farther_away_counts_as_touching():
    seen = NearMemory().update(wedges(-np.inf), STILL)
    assert (seen.ranges[AHEAD] == 0.0).all()


def test_a_turn_of_the_robot_turns_what_is_remembered():
    memory = NearMemory()
    memory.update(wedges(0.25), STILL)
    seen = memory.update(wedges(-np.inf), SE2(0.0, 0.0, np.pi / 2))
    assert (seen.ranges[AHEAD] == 0.0).all()  # that was at the right hand now


def test_what_is_seen_again_counts_and_the_memory_goes():
    memory = NearMemory()
    memory.update(wedges(0.25), STILL)
    assert memory.update(wedges(0.4), STILL).ranges[90] == 0.4
    seen = memory.update(wedges(-np.inf), SE2(0.3, 0.0, 0.0))
    assert seen.ranges[90] == pytest.approx(0.1)


def test_a_wall_farther_than_the_sensor_is_blind_does_not_stand_for_what_came_before_it():
    memory = NearMemory()
    memory.update(wedges(0.4), STILL)
    for _ in range(2):
        assert (memory.update(wedges(-np.inf), STILL).ranges[AHEAD] == 0.0).all()


def test_a_little_noise_does_not_make_it_forget_and_no_beam_is_taken_for_longer_than_blind():
    memory = NearMemory()
    memory.update(wedges(0.22), STILL)
    assert (memory.update(wedges(-np.inf), STILL).ranges[AHEAD] == BLIND).all()


def test_a_sensor_that_is_not_in_the_middle_remembers_by_its_own_bearings():
    """Seen 0.25 m left of a sensor at (0.3, 0) that looks left; the robot goes 0.1 m that way."""
    memory, mount = NearMemory(), SE2(0.3, 0.0, np.pi / 2)
    memory.update(wedges(0.25, mount), STILL)
    seen = memory.update(wedges(-np.inf, mount), SE2(0.0, 0.1, 0.0))
    assert seen.ranges[90] == pytest.approx(0.15, abs=1e-3)
    ahead = memory.update(wedges(-np.inf, mount), SE2(0.1, 0.0, 0.0))
    assert (ahead.ranges[AHEAD] == 0.0).all()  # past it: that is another thing


def test_one_long_way_is_too_far_to_be_sure_at_once():
    """Seen 0.35 m ahead; 0.52 m on and turned about, it would be 0.17 m ahead."""
    memory = NearMemory()
    memory.update(wedges(0.35), STILL)
    seen = memory.update(wedges(-np.inf), SE2(0.52, 0.0, np.pi))
    assert (seen.ranges[AHEAD] == 0.0).all()


def test_what_is_seen_through_is_forgotten():
    memory = NearMemory()
    memory.update(wedges(0.25), STILL)
    memory.update(wedges(np.inf), STILL)
    assert (memory.update(wedges(-np.inf), STILL).ranges[AHEAD] == 0.0).all()


def test_after_half_a_meter_nothing_is_sure_any_more():
    memory = NearMemory()
    memory.update(wedges(0.25), STILL)
    for step in range(12):
        seen = memory.update(wedges(-np.inf), SE2(0.05 * (-1) ** step, 0.0, 0.0))
    assert (seen.ranges[AHEAD] == 0.0).all()


def test_what_is_far_away_is_not_kept():
    memory = NearMemory()
    memory.update(wedges(1.0), STILL)
    assert (memory.update(wedges(-np.inf), STILL).ranges[AHEAD] == 0.0).all()
