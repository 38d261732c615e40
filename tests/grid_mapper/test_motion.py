"""Predictions: by hand, and how their doubt grows."""

import numpy as np
import pytest

from floornav_common.se2 import SE2
from grid_mapper.config import MotionConfig
from grid_mapper.motion import odometry_motion, rotated, steady_motion, updated_velocity

CONFIG = MotionConfig(
    slip=0.1, turn_slip=0.2, turn_per_m=0.05, base_m=0.01, base_rad=0.02, acceleration=1.0,
    turn_acceleration=2.0, stamp_jitter_s=0.1, smoothing_s=0.3,
)  # fmt: skip


def test_doubt_of_odometry_by_hand():
    sigma = np.sqrt(np.diag(odometry_motion(SE2(3.0, 4.0, -0.5), CONFIG)))
    assert sigma == pytest.approx([0.51, 0.51, 0.02 + 0.1 + 0.25])


def test_steady_motion_by_hand():
    moved, cov = steady_motion(np.array([0.6, 0.8, 0.5]), 0.2, CONFIG)
    assert moved.as_array() == pytest.approx([0.12, 0.16, 0.1])
    assert np.sqrt(np.diag(cov)) == pytest.approx([0.15, 0.15, 0.15])


def test_velocity_settles_on_a_steady_motion_whatever_the_stamps_jitter():
    rng, velocity, true_dt = np.random.default_rng(0), np.zeros(3), 0.2
    for _ in range(200):
        stamped_dt = true_dt + rng.uniform(-0.1, 0.1)
        velocity = updated_velocity(velocity, SE2(0.1, 0.0, 0.02), stamped_dt, CONFIG)
    assert velocity == pytest.approx([0.5, 0.0, 0.1], rel=0.15)


def test_a_covariance_turns_with_its_axes():
    turned = rotated(np.diag([4.0, 1.0, 0.5]), np.pi / 2.0)
    assert turned == pytest.approx(np.diag([1.0, 4.0, 0.5]))
