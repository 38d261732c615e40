"""The drive: delay, time-out, limits, refusal."""

import math

import pytest

from sim_bridge.config import DriveConfig
from sim_bridge.drive import DriveState, Velocity, drive_step, refusal

DT = 0.01


def _run(config: DriveConfig, command: Velocity, num_steps: int, every: int = 1) -> list[Velocity]:
    state, speeds = DriveState(), []
    for k in range(num_steps):
        state = drive_step(config, state, command if k % every == 0 else None, DT)
        speeds.append(state.velocity)
    return speeds


def test_acceleration_is_the_limit_by_hand() -> None:
    config = DriveConfig(command_delay_s=0.0, max_accel_m_s2=0.5)
    speeds = _run(config, Velocity(1.0, 0.0), 100)
    assert speeds[99].speed == pytest.approx(0.5, abs=1e-9)
    assert speeds[9].speed == pytest.approx(0.05, abs=1e-9)


def test_speed_is_clipped_to_the_limit() -> None:
    config = DriveConfig(command_delay_s=0.0)
    assert _run(config, Velocity(3.0, -9.0), 500)[-1] == Velocity(1.667, -1.5)


def test_a_command_acts_after_its_delay() -> None:
    config = DriveConfig(command_delay_s=0.05)
    speeds = _run(config, Velocity(1.0, 0.0), 10)
    assert [v.speed > 0.0 for v in speeds] == [False] * 5 + [True] * 5


def test_silence_stops_the_robot_after_the_timeout() -> None:
    config = DriveConfig(command_delay_s=0.0, command_timeout_s=0.3)
    speeds = _run(config, Velocity(0.1, 0.0), 60, every=1000)
    assert speeds[29].speed == pytest.approx(0.1)
    assert speeds[-1].speed == 0.0


@pytest.mark.parametrize(
    ("command", "word"),
    [
        (Velocity(math.nan, 0.0), "linear.x"),
        (Velocity(0.0, -math.inf), "angular.z"),
        (Velocity(100.0, 0.0), "more than"),
    ],
)
def test_refusal_names_what_is_wrong(command: Velocity, word: str) -> None:
    assert word in refusal(DriveConfig(), command)


def test_a_command_somewhat_over_the_limit_is_not_refused() -> None:
    assert refusal(DriveConfig(), Velocity(3.0, 2.0)) == ""
