from dataclasses import replace

import numpy as np
import pytest
from loop_builders import drifted, largest_error, ring, round_the_ring
from worlds import scan_at

from floornav_common.grid import OCCUPIED
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig, ScanMatcherConfig
from grid_mapper.frame_thinning import emptied
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import KnownPose, LoopClosingLocalizer
from grid_mapper.map_rebuild import MapRebuild
from grid_mapper.recent_scans import RecentScanMatcher
from grid_mapper.surface_points import surface_points

STEP_NS = 300_000_000
HERE = SE2.identity()
CONFIG = GridMapperConfig()


def follow(localizer, truth, odometry, first=0):
    rng = np.random.default_rng(1)
    for k, (pose, odom) in enumerate(zip(truth, odometry, strict=True)):
        scan = scan_at(pose, ring(), rng=rng)
        localizer.insert_scan((first + k) * STEP_NS, scan, HERE, odom)


@pytest.fixture(scope="module")
def lap():
    truth = round_the_ring(130, 1.2)
    localizer = LoopClosingLocalizer(CONFIG)
    follow(localizer, truth, drifted(truth, 0.0, 1.05))
    localizer.closer.finish()
    return truth, localizer


def test_every_scan_has_a_pose_in_one_map(lap):
    truth, localizer = lap
    known = localizer.known_poses()
    T_map_world = known[0].T_map_base @ truth[0].inverse()
    assert len(known) == len(truth) and all(pose.is_trusted for pose in known)
    assert localizer.closer.num_loops > 0
    assert largest_error([p.T_map_base for p in known], [T_map_world @ p for p in truth]) < 0.08


def test_a_recording_that_starts_again_is_found_where_it_began():
    truth = round_the_ring(60, 0.6)
    localizer = LoopClosingLocalizer(replace(CONFIG, loop=replace(CONFIG.loop, recent_scans=5)))
    follow(localizer, truth, truth)
    localizer.break_motion()
    follow(localizer, truth[:12], truth[:12])
    again = localizer.known_poses()[60:]
    expected = [truth[0].between(pose) for pose in truth[:12]]
    assert all(pose.is_trusted for pose in again[2:])
    assert largest_error([p.T_map_base for p in again[2:]], expected[2:]) < 0.15


def test_where_it_began_is_told_by_later_scans_when_the_first_are_gone(monkeypatch):
    truth = round_the_ring(110, 1.2)
    localizer = LoopClosingLocalizer(CONFIG)
    follow(localizer, truth, truth)
    frames = localizer.closer.frames
    frames[:8] = [emptied(frame) for frame in frames[:8]]
    told = []
    monkeypatch.setattr(localizer._front, "see", lambda places: told.extend(places))
    localizer.break_motion()
    T_local_first = frames[-1].T_local_base @ localizer.closer.poses[-1].inverse()
    assert len(told) == CONFIG.loop.submap_nodes + 1
    for points, pose in told:
        assert len(points) and T_local_first.between(pose).distance < 2.0


def test_what_is_not_recent_is_forgotten():
    matcher = RecentScanMatcher(ScanMatcherConfig(), num_recent=3)
    scan = scan_at(HERE, ring())
    points = surface_points(scan.points(), np.zeros(2), scan.angle_increment, 0.02, 0.1)
    for k in range(6):
        matcher.insert(points, SE2(100.0 * k, 0.0, 0.0))
    old, new = (
        matcher.match(points, SE2(100.0 * k, 0.0, 0.0), np.diag([0.1, 0.1, 0.05]) ** 2).overlap
        for k in (1, 5)
    )
    assert old == 0.0 and new == 1.0


def test_grids_are_made_at_the_poses_that_are_known():
    poses = [SE2(0.1 * k, 4.0, 0.0) for k in range(8)]
    mapper = LayeredMapper(CONFIG)
    rebuild = MapRebuild(mapper, [KnownPose(pose, True, "") for pose in poses])
    other = LayeredMapper(CONFIG)
    for k, pose in enumerate(poses):
        scan = scan_at(pose, ring())
        rebuild.insert_scan(k * STEP_NS, scan, HERE, SE2(9.0, 9.0, 1.0))
        other.follow_scan(k * STEP_NS, scan, HERE, pose)
    assert np.array_equal(mapper.occupancy().cells, other.occupancy().cells)
    assert (mapper.occupancy().cells == OCCUPIED).any()


def test_a_scan_not_trusted_is_not_mapped():
    mapper = LayeredMapper(CONFIG)
    rebuild = MapRebuild(mapper, [KnownPose(HERE, False, "no")])
    known = rebuild.insert_scan(0, scan_at(HERE, ring()), HERE, None)
    assert not known.is_trusted and mapper.occupancy().cells.size == 0


def test_a_reading_is_placed_between_the_corrected_poses_of_its_scans():
    poses = [SE2(0.0, 4.0, 0.0), SE2(1.0, 4.0, 0.0)]
    mapper = LayeredMapper(replace(CONFIG, fusion="overlay"))
    rebuild = MapRebuild(mapper, [KnownPose(pose, True, "") for pose in poses])
    rebuild.insert_scan(0, scan_at(poses[0], ring()), HERE, HERE)
    rebuild.insert_range(STEP_NS // 2, RangeReading(0.6, 0.3, 0.02, 4.0), HERE, "front")
    rebuild.insert_scan(STEP_NS, scan_at(poses[1], ring()), HERE, HERE)
    points, origin = mapper.sonar_points()
    row, col = np.argwhere(points > 0).mean(axis=0)
    assert mapper.sonar_counts.placed == 1
    assert origin.x + 0.05 * (col + 0.5) == pytest.approx(0.5 + 0.6, abs=0.06)
    assert origin.y + 0.05 * (row + 0.5) == pytest.approx(4.0, abs=0.06)
