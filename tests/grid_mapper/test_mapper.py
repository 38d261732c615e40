"""The whole mapper on drives with bad odometry, few scans, no odometry, and scans to refuse."""

import numpy as np
import pytest
from worlds import drive_around, scan_at, square_room

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig, KeyScanConfig
from grid_mapper.mapper import GridMapper

T_BASE_LASER = SE2(0.1, 0.0, 0.2)
HALF_SECOND_NS = 500_000_000


def slipping(truth: list[SE2], slip: float) -> list[SE2]:
    """Return odometry that reports every motion and every turn too long by a share."""
    odom = [SE2.identity()]
    for a, b in zip(truth, truth[1:], strict=False):
        m = a.between(b)
        odom.append(odom[-1] @ SE2(m.x * (1 + slip), m.y * (1 + slip), m.yaw * (1 + slip)))
    return odom


def run(truth, odom, mapper=None, seed=0):
    mapper = mapper or GridMapper(GridMapperConfig(), T_map_start=truth[0])
    rng = np.random.default_rng(seed)
    results = [
        mapper.insert_scan(
            k * HALF_SECOND_NS, scan_at(pose @ T_BASE_LASER, square_room(), rng=rng),
            T_BASE_LASER, o,
        )
        for k, (pose, o) in enumerate(zip(truth, odom, strict=True))
    ]  # fmt: skip
    return mapper, results


def worst(truth, results):
    off = [a.between(r.T_map_base) for a, r in zip(truth, results, strict=True)]
    return max(o.distance for o in off), max(abs(o.yaw) for o in off)


@pytest.mark.parametrize("every", [1, 4])
def test_ten_percent_slip_is_undone_at_full_rate_and_at_sparse_key_scans(every):
    """Every fourth pose is 0.5 m and 20 degrees from the last."""
    truth = drive_around()[::every]
    _, results = run(truth, slipping(truth, 0.1))
    distance, turn = worst(truth, results)
    assert all(r.is_trusted for r in results)
    assert distance < 0.03 and turn < 0.01


def test_a_drive_without_odometry_is_followed():
    truth = drive_around()
    _, results = run(truth, [None] * len(truth))
    assert worst(truth, results)[0] < 0.03


def test_the_same_scans_give_the_same_result():
    truth = drive_around(20)
    (map_a, a), (map_b, b) = (run(truth, slipping(truth, 0.1)) for _ in range(2))
    assert [r.T_map_base for r in a] == [r.T_map_base for r in b]
    assert (map_a.occupancy().cells == map_b.occupancy().cells).all()


def test_memory_grows_with_the_area_seen_and_not_with_time():
    truth = drive_around(20)
    mapper, _ = run(truth, truth)
    before = mapper.num_bytes
    for _ in range(5):
        run(truth, truth, mapper)
    assert mapper.num_bytes == before


def test_a_scan_that_does_not_fit_is_refused_with_a_reason_and_not_mapped():
    truth = drive_around()
    mapper, _ = run(truth, truth)
    before = mapper.occupancy()
    rng = np.random.default_rng(0)
    clutter = Scan(rng.uniform(0.3, 1.0, 360), -np.pi, 2 * np.pi / 360, 0.05, 30.0)
    result = mapper.insert_scan(99 * HALF_SECOND_NS, clutter, T_BASE_LASER, truth[-1])
    assert not result.is_trusted and result.reason
    assert (mapper.occupancy().cells == before.cells).all()
    assert truth[-1].between(result.T_map_base).distance < 0.05


def test_covariance_grows_while_scans_are_refused_and_shrinks_after():
    truth = drive_around()
    mapper, results = run(truth, truth)
    blind = Scan(np.full(360, np.nan), -np.pi, 2 * np.pi / 360, 0.05, 30.0)
    sigma = [np.sqrt(np.trace(results[-1].cov[:2, :2]))]
    for k in range(5):
        r = mapper.insert_scan((100 + k) * HALF_SECOND_NS, blind, T_BASE_LASER, truth[-1])
        sigma.append(np.sqrt(np.trace(r.cov[:2, :2])))
    assert (np.diff(sigma) > 0.0).all()
    good = scan_at(truth[-1] @ T_BASE_LASER, square_room())
    after = mapper.insert_scan(110 * HALF_SECOND_NS, good, T_BASE_LASER, truth[-1])
    assert after.is_trusted and np.sqrt(np.trace(after.cov[:2, :2])) < sigma[1]


def test_a_first_scan_without_points_is_no_map():
    mapper = GridMapper(GridMapperConfig())
    blind = Scan(np.full(360, np.nan), -np.pi, 2 * np.pi / 360, 0.05, 30.0)
    result = mapper.insert_scan(0, blind, T_BASE_LASER, SE2.identity())
    assert not result.is_trusted
    assert mapper.occupancy().cells.size == 0


def test_a_pose_told_from_outside_is_settled_by_the_next_scan():
    truth = drive_around()
    mapper, _ = run(truth, truth)
    mapper.relocate(SE2(truth[0].x + 0.3, truth[0].y - 0.2, truth[0].yaw + 0.15))
    scan = scan_at(truth[0] @ T_BASE_LASER, square_room())
    result = mapper.insert_scan(200 * HALF_SECOND_NS, scan, T_BASE_LASER, SE2(9.0, 9.0, 1.0))
    assert result.is_trusted
    assert truth[0].between(result.T_map_base).distance < 0.02


def test_a_robot_that_stands_still_fills_the_map_no_faster_than_its_key_period():
    mapper = GridMapper(GridMapperConfig(map_key=KeyScanConfig(period_s=5.0)))
    scan, counts = scan_at(T_BASE_LASER, square_room()), []
    for k in range(31):
        mapper.insert_scan(k * HALF_SECOND_NS, scan, T_BASE_LASER, SE2.identity())
        counts.append(mapper.num_key_scans)
    assert [counts[k] for k in (0, 9, 10, 19, 20, 30)] == [1, 1, 2, 2, 3, 4]


def test_the_map_can_be_sparser_than_what_scans_are_matched_to():
    """The published map of few stops needs poses that do not suffer from them."""
    truth = drive_around()
    config = GridMapperConfig(map_key=KeyScanConfig(distance_m=1.0, turn_rad=9.0, period_s=0.0))
    mapper, results = run(truth, slipping(truth, 0.1), GridMapper(config, truth[0]))
    assert mapper.num_key_scans < 8
    assert worst(truth, results)[0] < 0.03


def test_a_bare_corridor_is_left_to_odometry():
    """Two endless walls say nothing of the way along them; 1 % of it may be lost to noise."""
    walls = np.array([[-60.0, -1.2, 60.0, -1.2], [-60.0, 1.2, 60.0, 1.2]])
    truth = [SE2(0.1 * k, 0.0, 0.0) for k in range(100)]
    mapper, rng = GridMapper(GridMapperConfig(), truth[0]), np.random.default_rng(0)
    for k, pose in enumerate(truth):
        scan = scan_at(pose, walls, rng=rng, range_max=12.0)
        result = mapper.insert_scan(k * HALF_SECOND_NS, scan, SE2.identity(), pose)
    assert result.T_map_base.x == pytest.approx(truth[-1].x, rel=0.01)
    assert result.cov[0, 0] > 4.0 * result.cov[1, 1]


def test_a_bag_played_twice_gives_the_map_of_one_time():
    """At the jump back the robot is where it began, far from where it was."""
    truth = drive_around()
    odom = slipping(truth, 0.1)
    mapper, _ = run(truth, odom)
    before = mapper.occupancy()
    mapper.break_motion()
    _, results = run(truth, odom, mapper, seed=1)
    found = next(k for k, r in enumerate(results) if r.is_trusted)
    assert truth[0].between(truth[found]).distance < 0.8
    assert all(r.is_trusted for r in results[found:])
    assert worst(truth[found:], results[found:])[0] < 0.03
    after = mapper.occupancy()
    assert (after.cells == 100).sum() < 1.1 * (before.cells == 100).sum()


def test_a_robot_carried_away_over_a_jump_stays_lost_and_maps_nothing_until_told():
    truth = drive_around()
    mapper, _ = run(truth[:30], truth[:30])
    num_keys, elsewhere = mapper.num_key_scans, SE2(2.8, 2.0, -2.5)
    mapper.break_motion()
    scan = scan_at(elsewhere @ T_BASE_LASER, square_room())
    for k in range(20):
        result = mapper.insert_scan((100 + k) * HALF_SECOND_NS, scan, T_BASE_LASER, truth[0])
        assert not result.is_trusted or elsewhere.between(result.T_map_base).distance < 0.03
    mapper.relocate(SE2(2.7, 2.1, -2.4))
    result = mapper.insert_scan(200 * HALF_SECOND_NS, scan, T_BASE_LASER, truth[0])
    assert result.is_trusted and elsewhere.between(result.T_map_base).distance < 0.03
    assert num_keys <= mapper.num_key_scans <= num_keys + 6


def test_odometry_that_was_set_anew_is_no_motion():
    truth = drive_around()
    mapper, _ = run(truth, truth)
    scan = scan_at(truth[-1] @ T_BASE_LASER, square_room())
    for k in range(50):
        odom = SE2(40.0, -3.0, 1.9)
        result = mapper.insert_scan((60 + k) * HALF_SECOND_NS, scan, T_BASE_LASER, odom)
    assert result.is_trusted
    assert truth[-1].between(result.T_map_base).distance < 0.03


def test_a_bare_corridor_without_odometry_is_refused_before_long_and_says_so():
    walls = np.array([[-60.0, -1.2, 60.0, -1.2], [-60.0, 1.2, 60.0, 1.2]])
    mapper, rng, reasons = GridMapper(GridMapperConfig()), np.random.default_rng(0), []
    for k in range(60):
        pose = SE2(0.1 * k, 0.0, 0.0)
        scan = scan_at(pose, walls, rng=rng, range_max=12.0)
        result = mapper.insert_scan(k * HALF_SECOND_NS, scan, SE2.identity(), None)
        reasons.append(result.reason)
    assert all("does not say where along" in reason for reason in reasons[10:])
    assert result.cov[0, 0] > 1.0
