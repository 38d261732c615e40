"""T_j against hand-made times and against eq. 12 written out."""

from __future__ import annotations

import numpy as np
import pytest

from sjmc_planner.free_times import (
    _bearing,
    can_stop,
    first_stoppable,
    free_times,
    straight_free_times,
)
from sjmc_planner.limited_motion import limited_position, limited_velocity

N = 360
DT = 0.01


def wall_ahead(distance: float) -> np.ndarray:
    """Return the table of a wall across the way, grown already."""
    bearings = 2.0 * np.pi * np.arange(N) / N
    with np.errstate(divide="ignore"):
        r = distance / np.cos(bearings)
    return np.where(np.cos(bearings) > 1e-6, r, np.inf)


def test_straight_ahead_at_full_speed_takes_distance_over_speed():
    va = np.array([0.4, 0.0])
    (time,) = free_times(va, va[None], 0.3, 0.0, DT, 5.0, wall_ahead(1.0))
    assert time == pytest.approx(2.5, abs=DT)


def test_from_rest_the_acceleration_counts():
    """0.4 m/s at 0.3 m/s^2: 1.333 s and 0.267 m until full speed, then 0.733 m at 0.4 m/s."""
    times = free_times(np.zeros(2), np.array([[0.4, 0.0]]), 0.3, 0.0, DT, 5.0, wall_ahead(1.0))
    assert times[0] == pytest.approx(4.0 / 3.0 + (1.0 - 0.8 / 3.0) / 0.4, abs=DT)


def test_the_idle_time_costs_its_way():
    va = np.array([0.4, 0.0])
    (time,) = free_times(va, va[None], 0.3, 0.5, DT, 5.0, wall_ahead(1.0))
    assert time == pytest.approx(2.0, abs=DT)


def test_a_way_aside_still_runs_into_a_wall_that_is_near():
    """The point of knowing the velocity: 90 degrees aside is not free when it comes too late."""
    va, aside = np.array([0.4, 0.0]), np.array([[0.0, 0.4]])
    near = free_times(va, aside, 0.3, 0.0, DT, 5.0, wall_ahead(0.2))
    far = free_times(va, aside, 0.3, 0.0, DT, 5.0, wall_ahead(0.6))
    assert np.isfinite(near[0]) and np.isinf(far[0])


def test_every_time_is_the_first_step_outside_of_the_table():
    rng = np.random.default_rng(0)
    table = rng.uniform(0.3, 1.5, N)
    bearings = 2.0 * np.pi * np.arange(16) / 16
    vb = 0.4 * np.column_stack((np.cos(bearings), np.sin(bearings)))
    va = np.array([0.2, -0.1])
    times = free_times(va, vb, 0.3, 0.03, DT, 2.0, table)
    t = np.arange(0.0, 2.0 + DT / 2, DT)
    for j, way in enumerate(limited_position(va, vb, 0.3, 0.03, t)):
        entry = np.rint(np.arctan2(way[:, 1], way[:, 0]) * N / (2.0 * np.pi)).astype(int) % N
        outside = np.hypot(*way.T) >= table[entry]
        expected = t[outside.argmax()] if outside.any() else np.inf
        assert times[j] == pytest.approx(expected)


def test_without_velocity_it_is_distance_over_speed():
    bearings = np.array([0.0, np.pi / 3, np.pi])
    times = straight_free_times(bearings, 0.5, wall_ahead(1.0))
    assert times == pytest.approx([2.0, 4.0, np.inf])


def test_stopping_needs_its_way():
    """0.4 m/s at 0.3 m/s^2 needs 0.267 m, and 0.04 m more with 0.1 s until it brakes."""
    assert can_stop(0.0, 0.0, 0.4, 0.0, 0.3, 0.1, wall_ahead(0.31))
    assert not can_stop(0.0, 0.0, 0.4, 0.0, 0.3, 0.1, wall_ahead(0.30))
    assert can_stop(0.0, 0.0, 0.4, 0.0, 0.3, 0.0, wall_ahead(0.27))
    assert can_stop(0.0, 0.0, -0.4, 0.0, 0.3, 0.1, wall_ahead(0.01))


def test_a_closed_direction_ahead_does_not_close_the_others():
    """The place the robot stands at has no bearing; only ways that go ahead leave the table."""
    table = np.full(N, np.inf)
    table[np.r_[0:20, N - 20 : N]] = 0.0
    vb = 0.4 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    times = free_times(np.zeros(2), vb, 0.3, 0.03, DT, 2.0, table)
    assert times[0] == pytest.approx(DT) and np.isinf(times[1:]).all()


def test_who_stands_can_stop_anywhere():
    assert can_stop(0.0, 0.0, 0.0, 0.0, 0.3, 0.1, np.zeros(N))


@pytest.mark.parametrize("seed", range(20))
def test_the_first_stoppable_is_the_first_that_can_stop_a_cycle_later(seed):
    rng = np.random.default_rng(seed)
    table, va, t = rng.uniform(0.05, 0.6, N), rng.uniform(-0.4, 0.4, 2), rng.uniform(0.02, 1.5)
    bearings = 2.0 * np.pi * np.arange(24) / 24
    vb, order = 0.4 * np.column_stack((np.cos(bearings), np.sin(bearings))), rng.permutation(24)
    expected = -1
    for j in order:
        x, y = limited_position(va, vb[j], 0.3, 0.03, t)
        if can_stop(x, y, *limited_velocity(va, vb[j], 0.3, t), 0.3, 0.03, table):
            expected = j
            break
    assert first_stoppable(order, va, vb, 0.3, 0.03, t, table) == expected


def test_the_quick_bearing_is_right_in_every_quadrant():
    angles = np.linspace(-np.pi, np.pi, 2001)
    found = [_bearing(0.7 * np.sin(a), 0.7 * np.cos(a)) for a in angles[1:-1]]
    assert found == pytest.approx(angles[1:-1], abs=1.3e-5)
    assert _bearing(0.0, 0.0) == 0.0 and _bearing(0.0, -1.0) == pytest.approx(np.pi)
