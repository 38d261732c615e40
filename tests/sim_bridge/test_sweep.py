"""Scans that take their time: beams are cast from where the robot was."""

from dataclasses import replace

import numpy as np
import pytest

from floornav_common.se2 import SE2
from sim_bridge.config import LaserConfig
from sim_bridge.drive import Velocity
from sim_bridge.ros_conversions import scan_msg
from sim_bridge.simulation import Simulation
from sim_bridge.sweep import beam_lags, earlier_poses

from .conftest import PERFECT, box_room


def test_earlier_poses_by_hand() -> None:
    # A quarter of a turn in 1 s at pi/2 m/s is a quarter of a circle of radius 1.
    T = earlier_poses(Velocity(np.pi / 2.0, np.pi / 2.0), np.array([0.0, 1.0]))
    assert T[0] == pytest.approx(np.eye(4))
    assert T[1, :2, 3] == pytest.approx([-1.0, 1.0])
    assert T[1, :2, :2] == pytest.approx(np.array([[0.0, 1.0], [-1.0, 0.0]]), abs=1e-12)


def test_sideways_motion_goes_back_sideways() -> None:
    T = earlier_poses(Velocity(0.5, 0.0, 0.2), np.array([2.0]))
    assert T[0, :2, 3] == pytest.approx([-1.0, -0.4])


def _last_scan(simulation: Simulation, command: Velocity, num: int):
    seen = [simulation.step({"": command}).robots[""] for _ in range(num)]
    scans = [(k, s) for k, s in enumerate(seen) if s.scan is not None]
    return scans[-1][1]


def _exact(overrides: dict) -> dict:
    laser = {**PERFECT["laser"], "echo_log_sd": 0.0, **overrides}
    drive = {"command_delay_s": 0.0, "max_yaw_accel_rad_s2": 100.0}
    return {**PERFECT, "laser": laser, "drive": drive, "sonar": None}


def test_each_beam_of_a_turning_robot_is_taken_where_it_was_then(simulate) -> None:
    sweep = 0.08
    seen = _last_scan(simulate(box_room(_exact({"sweep_s": sweep}))), Velocity(0.0, 1.5), 30)
    scan, pose = seen.scan, seen.ground_truth.pose
    assert scan.time_increment == pytest.approx(sweep / 540)
    for k in (0, 135, 270, 405, 540):
        then = SE2(pose.x, pose.y, pose.yaw - 1.5 * sweep * (540 - k) / 540)
        angle, at = then.yaw + scan.angles[k], (then @ np.array([[0.14, 0.0]]))[0]
        ahead = np.array([np.cos(angle), np.sin(angle)])
        with np.errstate(divide="ignore"):
            ways = np.where(ahead > 0.0, (np.array([6.0, 4.0]) - at) / ahead, -at / ahead)
        assert scan.ranges[k] == pytest.approx(ways.min(), abs=2e-3), k


def test_a_robot_that_stands_scans_the_same_with_and_without_a_sweep(simulate) -> None:
    still = Velocity(0.0, 0.0)
    a, b = (
        _last_scan(simulate(box_room(_exact({"sweep_s": s}))), still, 12).scan for s in (0.0, 0.09)
    )
    assert a.ranges == pytest.approx(b.ranges, abs=1e-6)
    assert a.time_increment == 0.0


def test_the_message_has_the_stamp_of_the_first_beam(simulate) -> None:
    pytest.importorskip("sensor_msgs", reason="no ROS messages")
    config = LaserConfig(sweep_s=0.08)
    scan = replace(
        _last_scan(simulate(box_room(_exact({}))), Velocity(0.0, 0.0), 12).scan,
        time_increment=0.08 / 540,
    )
    msg = scan_msg(scan, config, 100_000_000, "laser")
    assert (msg.header.stamp.sec, msg.header.stamp.nanosec) == (0, 20_000_000)
    assert msg.time_increment == pytest.approx(0.08 / 540)


def test_a_sweep_ends_before_the_next_begins() -> None:
    assert beam_lags(LaserConfig(num_beams=3, sweep_s=0.1)).tolist() == [0.1, 0.05, 0.0]
    with pytest.raises(ValueError, match="sweep_s"):
        LaserConfig(period_s=0.05, sweep_s=0.06)
