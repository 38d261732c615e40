"""Transforms in space by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

TOL = 1e-12


def test_a_quarter_turn_moves_points_of_the_child_to_the_parent() -> None:
    quat = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    T_a_b = Transform3.from_parts((1.0, 2.0, 3.0), quat)
    assert np.allclose(T_a_b.apply(np.array([[1.0, 0.0, 0.0]])), [[1.0, 3.0, 3.0]], atol=TOL)
    assert T_a_b.to_se2().yaw == pytest.approx(math.pi / 2, abs=TOL)
    assert np.allclose(T_a_b.quat_xyzw, quat, atol=TOL)


def test_planar_part_survives_the_round_trip() -> None:
    pose = SE2(1.0, -2.0, 3.0)
    back = Transform3.from_se2(pose).to_se2()
    assert back.as_array() == pytest.approx(pose.as_array(), abs=TOL)


def test_planar_composition_agrees_with_se2() -> None:
    first, second = SE2(1.0, -2.0, 2.5), SE2(0.3, 0.1, -1.0)
    both = Transform3.from_se2(first) @ Transform3.from_se2(second)
    assert both.to_se2().as_array() == pytest.approx((first @ second).as_array(), abs=TOL)
    assert np.allclose((both @ both.inverse()).matrix(), np.eye(4), atol=TOL)


def test_a_laser_hung_from_above_is_told() -> None:
    assert Transform3.from_parts((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)).is_upside_down
    assert not Transform3.identity().is_upside_down
