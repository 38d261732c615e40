"""A scan on its robot: upright, head down, tilted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from floornav_common.scan import Scan
from floornav_common.transform3 import Transform3
from sjmc_planner.scan_mount import mounted

SCAN = Scan(np.array([1.0, 2.0, 3.0]), -0.1, 0.1, 0.05, 5.0)


def mount(roll: float, pitch: float = 0.0) -> Transform3:
    return Transform3.from_parts(
        (0.3, 0.1, 0.5), Rotation.from_euler("xyz", (roll, pitch, 0.4)).as_quat()
    )


def test_an_upright_scan_stays():
    seen = mounted(SCAN, mount(0.0))
    assert seen.scan is SCAN
    assert seen.T_base_sensor.as_array() == pytest.approx([0.3, 0.1, 0.4])


def test_one_that_hangs_head_down_is_turned_over():
    T, seen = mount(np.pi), mounted(SCAN, mount(np.pi))
    true = T.apply(np.column_stack((SCAN.points(), np.zeros(3))))[:, :2]
    assert seen.T_base_sensor @ seen.scan.points() == pytest.approx(true)


def test_a_tilted_one_is_refused():
    with pytest.raises(ValueError, match="tilted by 0.30 rad"):
        mounted(SCAN, mount(0.0, 0.3))
