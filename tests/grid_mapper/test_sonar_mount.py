"""Where a sonar looks in the plane, and which do not look along it."""

import math

import pytest

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.sonar_mount import MAX_TILT_RAD, level_sonar


def rotated(pitch=0.0, roll=0.0, yaw=0.0):
    """Return a pose at (0.2, -0.1, 0.3) turned by roll, then pitch, then yaw."""
    turn = Transform3.identity()
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        quat = [0.0, 0.0, 0.0, math.cos(angle / 2.0)]
        quat[axis] = math.sin(angle / 2.0)
        turn = turn @ Transform3.from_parts((0.0, 0.0, 0.0), tuple(quat))
    return Transform3.from_parts((0.2, -0.1, 0.3), (0.0, 0.0, 0.0, 1.0)) @ turn


def test_a_level_sonar_keeps_its_place_and_yaw():
    pose = level_sonar(rotated(yaw=0.7))
    assert pose.between(SE2(0.2, -0.1, 0.7)).distance < 1e-12
    assert pose.yaw == pytest.approx(0.7)


def test_a_sonar_mounted_on_its_side_or_head_down_looks_the_same_way():
    for roll in (math.pi / 2.0, math.pi):
        assert level_sonar(rotated(yaw=0.7, roll=roll)).yaw == pytest.approx(0.7)


@pytest.mark.parametrize("pitch", [0.5, -0.5, math.pi / 2.0])
def test_a_sonar_that_looks_at_floor_or_ceiling_is_refused(pitch):
    assert level_sonar(rotated(pitch=math.copysign(MAX_TILT_RAD - 0.01, pitch)))
    with pytest.raises(ValueError, match="looks up or down"):
        level_sonar(rotated(pitch=pitch))
