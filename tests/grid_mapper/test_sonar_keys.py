"""How many readings are counted on a way, whatever the sonar's rate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.se2 import SE2
from grid_mapper.sonar_config import SonarKeyConfig
from grid_mapper.sonar_keys import SonarKeys

S = 1_000_000_000


def num_taken(poses, config, stamps=None):
    keys = SonarKeys()
    stamps = range(len(poses)) if stamps is None else stamps
    return sum(keys.take(t, pose, config) for t, pose in zip(stamps, poses, strict=True))


def along(xs):
    return [SE2(float(x), 0.0, 0.0) for x in xs]


def test_the_first_reading_counts_and_the_next_after_the_spacing():
    keys, config = SonarKeys(), SonarKeyConfig(distance_m=0.1, turn_rad=0.5)
    taken = [keys.take(0, SE2(x, 0.0, 0.0), config) for x in (0.0, 0.06, 0.12, 0.16, 0.20)]
    # 0.12 comes 0.02 late, so the next may come 0.02 early, at 0.20
    assert taken == [True, False, True, False, True]


def test_turning_and_time_count_as_moving_does():
    config = SonarKeyConfig(distance_m=1.0, turn_rad=0.5, period_s=2.0)
    turned = [SE2(0.0, 0.0, yaw) for yaw in (0.0, 0.3, 0.6)]
    assert num_taken(turned, config) == 2
    still = [SE2.identity()] * 4
    assert num_taken(still, config, [0, S, 2 * S, 3 * S]) == 2
    never = SonarKeyConfig(distance_m=1.0, turn_rad=0.5, period_s=0.0)
    assert num_taken(still, never, [0, S, 1000 * S, 2000 * S]) == 1


def test_a_spacing_of_zero_counts_every_reading():
    assert num_taken([SE2.identity()] * 5, SonarKeyConfig(distance_m=0.0)) == 5


@given(step=st.floats(0.002, 0.05), jitter=st.integers(0, 1000))
def test_the_count_on_a_way_does_not_depend_on_the_step_between_readings(step, jitter):
    rng = np.random.default_rng(jitter)
    xs = np.cumsum(rng.uniform(0.5, 1.0, round(4.0 / step)) * step)
    way = xs[-1] - xs[0]
    counted = num_taken(along(xs), SonarKeyConfig(distance_m=0.05))
    assert abs(counted - (1 + way / 0.05)) <= 2.0


@pytest.mark.parametrize("seed", range(3))
def test_a_trembling_pose_of_a_robot_that_stands_adds_one_reading_at_most(seed):
    rng = np.random.default_rng(seed)
    still = [SE2(*rng.normal(0.0, (0.003, 0.003, 0.005))) for _ in range(5000)]
    assert num_taken([SE2(-0.049, 0.0, 0.0), *still], SonarKeyConfig()) <= 3
