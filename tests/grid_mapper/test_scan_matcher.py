"""Scan-to-map ICP: finds known poses, keeps the laws, and leaves to odometry what it cannot see."""

import numpy as np
import pytest
from worlds import box, drive_around, moved_walls, scan_at, square_room

from floornav_common.se2 import SE2
from grid_mapper.config import ScanMatcherConfig
from grid_mapper.scan_matcher import ScanMatcher, starting_poses, without_leak
from grid_mapper.surface_points import surface_points

CONFIG = ScanMatcherConfig()
SHARP, VAGUE = np.diag([0.05, 0.05, 0.05]) ** 2, np.diag([0.3, 0.3, 0.3]) ** 2
TOL_M, TOL_RAD = 0.01, 0.003


def points_at(pose, walls, rng=None, num_beams=360):
    scan = scan_at(pose, walls, num_beams=num_beams, rng=rng)
    return surface_points(
        scan.points(), np.zeros(2), scan.angle_increment, CONFIG.range_sigma_m, 0.125
    )


def mapped(walls, poses):
    matcher = ScanMatcher(CONFIG)
    for pose in poses:
        matcher.insert(points_at(pose, walls), pose)
    return matcher


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.2, -0.2, 0.1), (-0.3, 0.25, -0.25)])
def test_a_known_pose_is_found_from_nearby(off):
    matcher = mapped(square_room(), drive_around()[::3])
    truth = SE2(-0.4, 0.3, 1.0)
    start = SE2(truth.x + off[0], truth.y + off[1], truth.yaw + off[2])
    fit = matcher.match(points_at(truth, square_room()), start, VAGUE)
    assert truth.between(fit.T_map_base).distance < TOL_M
    assert abs(truth.between(fit.T_map_base).yaw) < TOL_RAD
    assert fit.overlap > 0.9 and fit.agreement > 0.9


def test_moving_world_and_robot_together_changes_nothing():
    T, truth, start = SE2(13.0, -7.0, 0.0), SE2(-0.4, 0.3, 1.0), SE2(-0.3, 0.2, 1.1)
    room = moved_walls(SE2(0.07, 0.09, 0.0), square_room())
    here = mapped(room, drive_around()[::3])
    there = mapped(moved_walls(T, room), [T @ p for p in drive_around()[::3]])
    a = here.match(points_at(truth, room), start, VAGUE).T_map_base
    b = there.match(points_at(truth, room), T @ start, VAGUE).T_map_base
    assert (T @ a).between(b).distance < 1e-9


def test_the_two_faces_of_a_thin_wall_are_not_taken_for_each_other():
    """Mapped from the left, a wall 8 cm thick is then seen from the right alone."""
    left, right = np.array([[0.0, -3.0, 0.0, 3.0]]), np.array([[0.08, -3.0, 0.08, 3.0]])
    ends = np.array([[-2.0, 3.0, 2.0, 3.0], [-2.0, -3.0, 2.0, -3.0]])
    matcher = ScanMatcher(CONFIG)
    truth = SE2(1.0, 0.0, 0.0)
    matcher.insert(points_at(truth, ends), truth)
    matcher.insert(points_at(SE2(-1.0, 0.0, 0.0), np.vstack((left, ends))), SE2(-1.0, 0.0, 0.0))
    fit = matcher.match(points_at(truth, np.vstack((right, ends))), truth, SHARP)
    assert fit.T_map_base.x == pytest.approx(truth.x, abs=TOL_M)


def test_a_corridor_says_nothing_about_the_way_along_it():
    walls = np.array([[-50.0, -1.0, 50.0, -1.0], [-50.0, 1.0, 50.0, 1.0]])
    matcher = ScanMatcher(CONFIG)
    for x in np.arange(-3.0, 3.0, 0.2):
        matcher.insert(points_at(SE2(x, 0.0, 0.0), walls), SE2(x, 0.0, 0.0))
    fit = matcher.match(points_at(SE2(0.5, 0.0, 0.0), walls), SE2(0.4, 0.05, 0.05), SHARP)
    assert abs(fit.T_map_base.y) < TOL_M and abs(fit.T_map_base.yaw) < TOL_RAD
    assert fit.T_map_base.x == pytest.approx(0.4, abs=0.03)
    assert fit.information[1, 1] > 10.0 * fit.information[0, 0]


def test_information_is_the_curvature_of_the_error():
    """More beams know more, and less is known across a single wall's direction."""
    few = mapped(square_room(), drive_around()[::3])
    truth = SE2(0.0, 0.0, 0.0)
    a = few.match(points_at(truth, square_room(), num_beams=180), truth, SHARP).information
    b = few.match(points_at(truth, square_room(), num_beams=720), truth, SHARP).information
    assert (np.diag(b) > 2.0 * np.diag(a)).all()
    assert np.allclose(b, b.T) and (np.linalg.eigvalsh(b) > 0.0).all()


def test_a_scan_of_another_place_overlaps_little():
    matcher = mapped(square_room(), drive_around()[::3])
    fit = matcher.match(points_at(SE2.identity(), box(-9, -8, 9, 7)), SE2.identity(), SHARP)
    assert fit.overlap < 0.2


def test_noise_averages_out():
    rng = np.random.default_rng(0)
    matcher = mapped(square_room(), drive_around()[::3])
    errors = []
    for truth in drive_around()[1::3]:
        fit = matcher.match(points_at(truth, square_room(), rng), truth, SHARP)
        errors.append(truth.between(fit.T_map_base).distance)
    assert np.median(errors) < 0.005


def test_a_sharp_prediction_gives_one_start_and_a_vague_one_is_surrounded():
    pose = SE2(1.0, 2.0, 0.3)
    assert starting_poses(pose, SHARP) == [pose]
    starts = starting_poses(pose, VAGUE)
    assert starts[0] == pose
    assert max(s.yaw for s in starts) - pose.yaw == pytest.approx(0.3)
    assert min(s.x for s in starts) == pytest.approx(pose.x - 0.2)


@pytest.mark.parametrize(("weak", "kept"), [(1000.0, 990.0), (20.0, 10.0), (10.0, 0.0), (2.0, 0.0)])
def test_a_weak_direction_keeps_only_what_no_other_lent_it(weak, kept):
    """By hand: a hundredth of the strong direction's 1000 is taken off."""
    information = without_leak(np.diag([weak, 1000.0, 5.0]))
    assert np.diag(information) == pytest.approx([kept, 990.0, 5.0])
    assert (np.linalg.eigvalsh(information) >= -1e-9).all()
