"""Grown obstacles against hand-made geometry and against a slow exact one; what is not seen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.growth import Wedges, grow, wedges_of
from sjmc_planner.planning import Obstacles

N = 720
STEP = 2.0 * np.pi / N


def round_scan(ranges: np.ndarray, **kwargs: float) -> Scan:
    """Return a scan once around whose beam j has its middle at -pi + 2 pi j / J."""
    num = len(ranges)
    limits = {"range_min": 0.1, "range_max": 5.0, **kwargs}
    return Scan(np.asarray(ranges, dtype=float), -np.pi, 2.0 * np.pi / num, **limits)


def grown(scan: Scan, radius: float = 0.2, mount: SE2 | None = None, gap: float = 0.1):
    mount = SE2.identity() if mount is None else mount
    return grow(wedges_of(Obstacles(scan, mount), gap), radius, N)


def at(table: np.ndarray, bearing: float) -> float:
    return float(table[round(bearing / STEP) % N])


def one_beam(r: float, num: int = 360) -> Scan:
    """Return a scan that hits one thing, straight ahead."""
    ranges = np.full(num, np.inf)
    ranges[num // 2] = r
    return round_scan(ranges)


def test_a_point_ahead_by_hand():
    """At 1 m, grown by 0.2: met at 0.8 m ahead, past asin(0.2) missed."""
    seen = grown(one_beam(1.0, 3600)).seen
    assert at(seen, 0.0) == pytest.approx(0.8, abs=1e-6)
    bearing = 0.1
    expected = np.cos(bearing) - np.sqrt(0.04 - np.sin(bearing) ** 2)
    assert at(seen, bearing) == pytest.approx(expected, abs=0.02)
    assert at(seen, bearing) <= expected
    assert at(seen, np.arcsin(0.2) + 2.0 * STEP) == np.inf
    assert at(seen, np.pi) == np.inf


def test_a_circular_wall_comes_nearer_by_the_radius():
    seen = grown(round_scan(np.full(90, 1.5))).seen
    assert seen == pytest.approx(np.full(N, 1.3), abs=1e-9)


@settings(max_examples=30)
@given(st.lists(st.floats(0.3, 3.0) | st.just(np.inf), min_size=12, max_size=12), st.integers(0))
def test_each_entry_is_the_least_of_the_exact_growth_over_its_width(ranges, salt):
    """Exact: the disk of radius R about a point touches a wedge; looked for on fine points."""
    radius, scan = 0.2, round_scan(np.array(ranges))
    seen = grown(scan, radius).seen
    k = salt % N
    bearings = (k + np.linspace(-0.5, 0.5, 5)) * STEP
    exact = min(first_touch(scan, b, radius) for b in bearings)
    assert at(seen, k * STEP) == pytest.approx(exact, abs=3e-3) or (exact == np.inf == seen[k])


def first_touch(scan: Scan, bearing: float, radius: float) -> float:
    """Walk outwards until some wedge is within the radius."""
    along = np.arange(0.0, 3.2, 1e-3)
    points = along[:, None] * (np.cos(bearing), np.sin(bearing))
    half, best = scan.angle_increment / 2.0, np.inf
    for angle, r in zip(scan.angles, scan.ranges, strict=True):
        if not np.isfinite(r):
            continue
        off = np.abs(np.remainder(bearing - angle + np.pi, 2 * np.pi) - np.pi)
        if off <= half:
            best = min(best, r - radius)
        for side in (angle - half, angle + half):
            corner = r * np.array([np.cos(side), np.sin(side)])
            hit = np.hypot(*(points - corner).T) <= radius
            best = min(best, along[hit.argmax()] if hit.any() else np.inf)
    return float(best)


@given(st.floats(-3.0, 3.0))
def test_turning_the_sensor_turns_the_table(turn):
    steps = round(turn / STEP)
    scan = one_beam(0.7)
    turned = grown(scan, mount=SE2(0.0, 0.0, steps * STEP)).seen
    assert turned == pytest.approx(np.roll(grown(scan).seen, steps), abs=1e-6)


def test_a_sensor_in_front_of_the_middle_sees_from_there():
    seen = grown(one_beam(1.0, 3600), mount=SE2(0.3, 0.0, 0.0)).seen
    assert at(seen, 0.0) == pytest.approx(1.1, abs=1e-3)
    beside = grown(one_beam(1.0, 3600), mount=SE2(0.0, 0.5, 0.0)).seen
    assert at(beside, np.arctan2(0.5, 1.0)) == pytest.approx(np.hypot(1.0, 0.5) - 0.2, abs=1e-3)


def test_what_is_nearer_than_the_radius_closes_half_of_all_directions():
    seen = grown(one_beam(0.15)).seen
    for bearing in (0.0, 1.0, -1.4):
        assert at(seen, bearing) < 2e-3
    for bearing in (1.7, -1.7, np.pi):
        assert at(seen, bearing) == np.inf


@pytest.mark.parametrize("near", [-np.inf, 0.05])
def test_a_beam_below_range_min_counts_as_touching(near):
    ranges = np.full(360, np.inf)
    ranges[180] = near
    assert grown(round_scan(ranges)).seen == pytest.approx(grown(one_beam(0.15)).seen)


def test_free_to_the_horizon_is_seen_as_open_but_known_only_so_far():
    space = grown(round_scan(np.full(36, np.inf), range_max=2.5))
    assert np.isinf(space.seen).all()
    assert space.known == pytest.approx(np.full(N, 2.3))


def test_from_a_sensor_ahead_less_is_known_behind():
    space = grown(round_scan(np.full(36, np.inf), range_max=2.5), mount=SE2(0.3, 0.0, 0.0))
    assert space.known == pytest.approx(np.full(N, 2.0))


@given(st.floats(0.3, 3.0), st.integers(0, 359), st.floats(-0.2, 0.2), st.floats(-3.0, 3.0))
def test_every_part_of_a_front_counts_wherever_the_sensor_is(r, beam, x, yaw):
    """Each point of the arc that a beam ended on keeps the robot's middle 0.2 m away."""
    ranges, mount = np.full(360, np.inf), SE2(x, 0.1, yaw)
    ranges[beam] = r
    scan = round_scan(ranges)
    seen = grown(scan, mount=mount).seen
    angles = scan.angles[beam] + scan.angle_increment * np.linspace(-0.5, 0.5, 9)
    points = mount @ (r * np.column_stack((np.cos(angles), np.sin(angles))))
    for x, y in points:
        assert at(seen, np.arctan2(y, x)) <= max(np.hypot(x, y) - 0.2, 1e-3) + 1e-3


def test_too_near_for_a_sensor_ahead_closes_what_is_there_and_not_its_bearing():
    """Left of a sensor at the circle's front edge: that is ahead of the robot's middle."""
    ranges = np.full(360, np.inf)
    ranges[270] = -np.inf  # 90 degrees
    seen = grown(round_scan(ranges, range_min=0.05), mount=SE2(0.2, 0.0, 0.0)).seen
    assert at(seen, 0.1) < 2e-3 and at(seen, 1.2) < 2e-3
    assert at(seen, 1.9) == np.inf


def test_too_near_for_a_sensor_ahead_reaches_out_to_its_range_min():
    """One at (0.1, 0) that is blind for 0.5 m: ahead, anything from the circle's edge on."""
    ranges = np.full(360, np.inf)
    ranges[270] = -np.inf
    seen = grown(round_scan(ranges, range_min=0.5), mount=SE2(0.1, 0.0, 0.0)).seen
    for bearing in (1.0, 1.3, 1.4):
        assert at(seen, bearing) < 2e-3


def test_a_range_beyond_range_max_is_free():
    assert np.isinf(grown(round_scan(np.full(36, 9.0))).seen).all()


def test_a_narrow_gap_takes_the_nearer_range_beside_it():
    ranges = np.full(360, 2.0)
    ranges[178:183] = 1.0, np.nan, np.nan, np.nan, 1.5
    filled = ranges.copy()
    filled[179:182] = 1.0
    assert grown(round_scan(ranges)).seen == pytest.approx(grown(round_scan(filled)).seen)


def test_a_narrow_gap_across_the_seam_is_closed_like_any_other():
    ranges = np.full(360, 2.0)
    ranges[[0, 1, 358, 359]] = np.nan
    assert grown(round_scan(ranges)).seen == pytest.approx(np.full(N, 1.8))


def test_a_wide_gap_is_closed_and_not_grown():
    ranges = np.full(360, np.inf)
    ranges[180:270] = np.nan  # from straight ahead to the left
    seen = grown(round_scan(ranges)).seen
    assert at(seen, 0.5) == at(seen, 1.5) == 0.0
    assert at(seen, -0.05) == at(seen, 1.65) == np.inf


def test_nothing_seen_at_all_is_closed_all_round():
    assert (grown(round_scan(np.full(180, np.nan))).seen == 0.0).all()


def test_bearings_that_no_beam_covers_are_closed():
    scan = Scan(np.full(181, 2.0), -np.pi / 2, np.pi / 180, 0.1, 5.0)
    seen = grown(scan).seen
    assert at(seen, 0.0) == pytest.approx(1.8) and at(seen, np.pi) == at(seen, 2.0) == 0.0


def test_a_scan_that_turns_the_other_way_gives_the_same_table():
    rng = np.random.default_rng(0)
    ranges = rng.uniform(0.5, 3.0, 360)
    scan = round_scan(ranges)
    mirrored = Scan(ranges[::-1], float(scan.angles[-1]), -scan.angle_increment, 0.1, 5.0)
    assert grown(mirrored).seen == pytest.approx(grown(scan).seen)


def test_an_obstacle_narrower_than_an_entry_is_not_missed():
    wedges = Wedges(np.array([0.4 * STEP]), np.array([1e-4]), np.array([4.0]), 5.0)
    assert np.isfinite(grow(wedges, 1e-3, 16).seen[0])
