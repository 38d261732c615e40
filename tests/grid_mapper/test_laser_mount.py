"""Where a laser sits: upright, head down, and tilted too far."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from worlds import scan_at, square_room

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.laser_mount import level_scan

PLACE = (0.2, -0.1, 0.5)


def mount(roll: float, pitch: float, yaw: float) -> Transform3:
    quat = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat()
    return Transform3.from_parts(PLACE, quat)


def test_an_upright_laser_keeps_its_beams_and_its_yaw():
    scan = Scan(np.array([1.0, 2.0]), 0.1, 0.2, 0.05, 10.0)
    leveled, pose = level_scan(scan, mount(0.0, 0.0, 0.7))
    assert (leveled.ranges == scan.ranges).all() and leveled.angle_increment == 0.2
    assert pose.as_array() == pytest.approx([0.2, -0.1, 0.7])


def test_a_laser_hung_head_down_sees_the_same_room():
    """Turned over about its x axis, the beams come in the other order: same points in the base."""
    robot, laser = SE2(0.3, 0.4, 0.5), SE2(PLACE[0], PLACE[1], 0.7)
    upright = scan_at(robot @ laser, square_room())
    hanging = Scan(upright.ranges[::-1], -upright.angles[-1], upright.angle_increment, 0.05, 30.0)
    a, pose_a = level_scan(upright, mount(0.0, 0.0, 0.7))
    b, pose_b = level_scan(hanging, mount(np.pi, 0.0, 0.7))
    points_a, points_b = pose_a @ a.points(), pose_b @ b.points()
    order_a, order_b = np.lexsort(points_a.T), np.lexsort(points_b.T)
    assert points_a[order_a] == pytest.approx(points_b[order_b], abs=1e-9)


@pytest.mark.parametrize(("roll", "pitch"), [(0.3, 0.0), (0.0, -0.4), (np.pi / 2.0, 0.0)])
def test_a_tilted_scan_plane_is_refused(roll, pitch):
    scan = Scan(np.array([1.0, 2.0]), 0.1, 0.2, 0.05, 10.0)
    with pytest.raises(ValueError, match="tilted by"):
        level_scan(scan, mount(roll, pitch, 0.0))
