"""Where the unseen begins, against a march along each line that asks the beams at every step."""

from __future__ import annotations

import numpy as np
import pytest

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.growth import grow, wedges_of
from sjmc_planner.planning import Obstacles
from sjmc_planner.unseen import unseen_table

N, RADIUS, FAR = 180, 0.3, 3.0
ALONG = np.arange(RADIUS, FAR, 2e-3)


def is_seen(scan: Scan, points: np.ndarray) -> np.ndarray:
    """Return whether a beam passed over each point (sensor's frame); gaps are not seen."""
    distance, bearing = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    off = np.remainder(bearing - scan.angle_min + 0.5 * scan.angle_increment, 2.0 * np.pi)
    beam = np.floor(off / scan.angle_increment).astype(int)
    ranges = np.append(scan.ranges, np.nan)[np.minimum(beam, len(scan.ranges))]
    return distance <= ranges  # False for NaN


def marched(scan: Scan, mount: SE2, bearing: float) -> float:
    """Return the first unseen place outside of the robot's circle along a bearing of the base."""
    points = ALONG[:, None] * (np.cos(bearing), np.sin(bearing))
    unseen = ~is_seen(scan, mount.inverse() @ points)
    return float(ALONG[unseen.argmax()]) if unseen.any() else np.inf


def random_scan(rng: np.random.Generator) -> tuple[Scan, SE2]:
    """Return things near and far, blind sectors, a fan that need not close, and a mount."""
    num = int(rng.integers(60, 200))
    ranges = np.where(rng.random(num) < 0.3, rng.uniform(0.6, 2.5, num), np.inf)
    for _ in range(3):
        first = int(rng.integers(num))
        ranges[first : first + 12] = rng.choice([np.nan, 0.8, np.inf])
    step = rng.uniform(0.6, 1.0) * 2.0 * np.pi / num
    mount = SE2(*rng.uniform(-0.28, 0.28, 2) * rng.integers(0, 2), rng.uniform(-3.0, 3.0))
    return Scan(ranges, rng.uniform(-3.0, 3.0), step, 0.05, 5.0), mount


@pytest.mark.parametrize("seed", range(25))
def test_the_unseen_begins_where_no_beam_passed(seed):
    scan, mount = random_scan(np.random.default_rng(seed))
    wedges = wedges_of(Obstacles(scan, mount), 0.0)
    table = unseen_table(wedges.start, wedges.width, wedges.ranges, mount, RADIUS, N)
    step = 2.0 * np.pi / N
    exact = [
        min(marched(scan, mount, (k + half) * step) for half in (-0.5, 0.0, 0.5)) for k in range(N)
    ]
    front = np.where(table + RADIUS < FAR - 0.01, table + RADIUS, np.inf)
    # A line that grazes a beam's side or tip may meet it or not by 1e-5 rad.
    is_same = np.isclose(front, exact, atol=4e-3)
    assert is_same.mean() > 0.97
    assert np.isfinite(front).any()


@pytest.mark.parametrize("seed", range(10))
def test_the_robot_never_gets_its_front_to_a_place_that_was_not_seen(seed):
    scan, mount = random_scan(np.random.default_rng(100 + seed))
    seen = grow(wedges_of(Obstacles(scan, mount), 0.0), RADIUS, N).known
    for k in range(N):
        bearing = 2.0 * np.pi * k / N
        swept = np.arange(RADIUS, seen[k] + RADIUS - 0.01, 5e-3) if seen[k] > 0.01 else []
        points = np.asarray(swept)[:, None] * (np.cos(bearing), np.sin(bearing))
        assert is_seen(scan, mount.inverse() @ points).all()


def test_a_laser_at_the_front_closes_more_than_its_own_blind_sector():
    """0.3 m ahead, 270 degrees: at 95 degrees of the base the circle's edge is not seen."""
    scan = Scan(np.full(271, np.inf), -np.radians(135), np.radians(1.0), 0.05, 10.0)
    space = grow(wedges_of(Obstacles(scan, SE2(0.3, 0.0, 0.0)), 0.1), 0.3, 360)
    assert (space.known[95:266] == 0.0).all()
    assert (space.known[:88] > 2.0).all() and (space.known[272:] > 2.0).all()


def test_the_shadow_of_a_thing_near_an_offset_sensor_is_closed():
    """A post 0.3 m left of a sensor at (0.4, 0): what lies beyond it was seen by no beam."""
    ranges = np.full(360, np.inf)
    ranges[265:276] = 0.3  # about 90 degrees
    scan = Scan(ranges, -np.pi, np.pi / 180.0, 0.05, 5.0)
    mount = SE2(0.4, 0.0, 0.0)
    space = grow(wedges_of(Obstacles(scan, mount), 0.1), 0.1, 360)
    bearing = round(np.degrees(np.arctan2(1.0, 0.4)))  # to (0.4, 1), 0.7 m behind the post
    assert space.known[bearing] < np.hypot(0.4, 1.0)
    reach = marched(scan, mount, np.radians(75))
    assert reach < 2.0 and space.known[75] <= reach - 0.1 + 0.01
    assert space.known[100] > 2.0


def test_a_sensor_in_the_middle_closes_just_what_it_does_not_look_at():
    ranges = np.full(360, np.inf)
    ranges[180:270] = np.nan
    scan = Scan(ranges, -np.pi, np.pi / 180.0, 0.05, 5.0)
    table = grow(wedges_of(Obstacles(scan, SE2.identity()), 0.1), 0.1, 360).seen
    assert (table[1:89] == 0.0).all() and np.isinf(table[92:358]).all()
