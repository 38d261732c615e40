"""The drive: delay, time-out, limits, refusal."""

import math

import numpy as np
import pytest

from sim_bridge.config import DriveConfig
from sim_bridge.drive import DriveState, Velocity, drive_step, refusal
from sim_bridge.robot_model import load_robot
from sim_bridge.world import RobotPlacement

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


SOCCER = DriveConfig(
    is_omnidirectional=True, max_speed_m_s=0.4, max_accel_m_s2=0.3, command_delay_s=0.0
)


def test_acceleration_vector_is_limited_as_in_equation_10() -> None:
    """Eq. 10 by hand: from (0.4, 0) to (0, 0.3) is |dv| = 0.5 m/s, so t_a = 0.5 / 0.3 s."""
    state = DriveState(Velocity(0.4, 0.0))
    state = drive_step(SOCCER, state, Velocity(0.0, 0.0, 0.3), DT)
    first = state.velocity
    assert (first.speed - 0.4, first.side_speed) == pytest.approx((-0.0024, 0.0018))
    for _ in range(165):
        state = drive_step(SOCCER, state, Velocity(0.0, 0.0, 0.3), DT)
    assert math.hypot(state.velocity.speed, state.velocity.side_speed - 0.3) == pytest.approx(0.002)
    state = drive_step(SOCCER, state, Velocity(0.0, 0.0, 0.3), DT)
    assert (state.velocity.speed, state.velocity.side_speed) == pytest.approx((0.0, 0.3))


@pytest.mark.parametrize("yaw_rate", [-3.0, 0.7, 3.0])
def test_equation_10_holds_over_the_floor_while_the_base_turns(yaw_rate: float) -> None:
    state, yaw, before, most = DriveState(), 0.0, np.zeros(2), 0.0
    for k in range(600):
        command = Velocity(0.4, yaw_rate) if k < 400 else Velocity(-0.2, yaw_rate, 0.3)
        state = drive_step(SOCCER, state, command, DT)
        v = state.velocity
        middle = yaw + v.yaw_rate * DT / 2.0
        c, s = math.cos(middle), math.sin(middle)
        now = np.array([c * v.speed - s * v.side_speed, s * v.speed + c * v.side_speed])
        most, before, yaw = max(most, np.hypot(*(now - before)) / DT), now, yaw + v.yaw_rate * DT
        assert np.hypot(*now) < 0.4 + 1e-9
    assert most == pytest.approx(0.3, rel=1e-6)


def test_the_robot_files_hold_the_papers_figures() -> None:
    def drive(model: str) -> DriveConfig:
        return load_robot(RobotPlacement(model=model, position_m=(0.0, 0.0))).config.drive

    soccer = drive("soccer_small_size")  # floor paper: 400 mm/s, 300 mm/s^2, idle for 0.03 s
    assert (soccer.max_speed_m_s, soccer.max_accel_m_s2, soccer.command_delay_s) == (0.4, 0.3, 0.03)
    assert soccer.is_omnidirectional and drive("soccer_middle_size").is_omnidirectional
    for segway in ("segway_rmp50", "segway_urg", "segway_stereo"):
        assert drive(segway).max_speed_m_s == pytest.approx(6.0 / 3.6, abs=5e-4)  # 6 km/h
        assert not drive(segway).is_omnidirectional


def test_work_of_the_limiter_is_that_of_a_constant_force() -> None:
    """From rest the limit alpha acts over s = v^2 / (2 alpha), so alpha s is the energy gained."""
    way = sum(v.side_speed for v in _run(SOCCER, Velocity(0.0, 0.0, 0.4), 133)) * DT
    last = _run(SOCCER, Velocity(0.0, 0.0, 0.4), 133)[-1].side_speed
    # Steps of DT take the speed at their end: half a step's gain more than the integral.
    assert 0.3 * (way - last * DT / 2.0) == pytest.approx(last**2 / 2.0)


def test_speed_vector_is_clipped_along_its_direction() -> None:
    last = _run(SOCCER, Velocity(0.6, 0.0, 0.8), 400)[-1]
    assert (last.speed, last.side_speed) == pytest.approx((0.24, 0.32))


def test_a_differential_drive_ignores_sideways_commands() -> None:
    last = _run(DriveConfig(command_delay_s=0.0), Velocity(0.5, 0.0, 0.5), 400)[-1]
    assert (last.speed, last.side_speed) == (0.5, 0.0)
    assert "linear.y" in refusal(DriveConfig(), Velocity(0.0, 0.0, math.nan))
