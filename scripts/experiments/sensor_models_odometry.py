"""The odometry part of `sensor-models`: drift on a straight way over many runs."""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np

from floornav_common.reporting import Section, Table
from sim_bridge.config import WheelConfig
from sim_bridge.drive import Velocity
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, World

SPEED = 0.8  # m/s
SECONDS = 13.0


def odometry_drift(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return mean and deviation of the drift a meter, beside the wheels' settings."""
    robot = RobotPlacement(
        model="segway_rmp50", position_m=(0.0, 0.0), overrides={"laser": None, "sonar": None}
    )
    simulation = Simulation(World(name="hall", robots=(robot,)))
    ends = []
    for k in range(args.runs):
        simulation.reset(args.seed + k)
        for _ in range(round(SECONDS / 0.01)):
            seen = simulation.step({"": Velocity(SPEED, 0.0)}).robots[""]
        ends.append((seen.ground_truth.pose.as_array(), seen.odometry.pose.as_array(),
                     np.sqrt(np.diag(seen.odometry.cov))))  # fmt: skip
    wheels = simulation.models[""].config.wheels
    simulation.close()
    truth, odometry, claimed = (np.array(v) for v in zip(*ends, strict=True))
    way = float(odometry[:, 0].mean())
    # Along the way each believed, so that a curve does not count as too short a way.
    along = np.hypot(*truth[:, :2].T) - np.hypot(*odometry[:, :2].T)
    yaw = truth[:, 2] - odometry[:, 2]
    promised = _promised(wheels, way)
    figures = {
        "mean_per_m": (float(along.mean()) / way, -wheels.slip_mean),
        "sd_m": (float(along.std(ddof=1)), promised[0]),
        "yaw_sd_rad": (float(yaw.std(ddof=1)), promised[1]),
        "claimed_sd_m": (float(claimed[:, 0].mean()), promised[0]),
        "claimed_yaw_sd_rad": (float(claimed[:, 2].mean()), promised[1]),
    }
    values: dict[str, Any] = {"way_m": way, "runs": args.runs}
    for name, (measured, want) in figures.items():
        values[name], values[f"promised_{name}"] = measured, want
    spread = 3.0 / math.sqrt(2.0 * args.runs)  # of a deviation from so many runs
    values["kept"] = (
        abs(values["mean_per_m"] + wheels.slip_mean) < 3.5 * promised[0] / way / args.runs**0.5
        and abs(values["sd_m"] / promised[0] - 1.0) < spread
        and abs(values["yaw_sd_rad"] / promised[1] - 1.0) < spread
    )
    rows = [[name, f"{a:.4f}", f"{b:.4f}"] for name, (a, b) in figures.items()]
    text = (
        f"{args.runs} runs of {way:.1f} m at {SPEED} m/s. Promised: from wheel radii, mean slip "
        "and its deviation; claimed: the covariance in the messages, which should not be less."
    )
    return values, Section("Odometry", [text, Table(["drift", "measured", "promised"], rows)])


def _promised(wheels: WheelConfig, way: float) -> tuple[float, float]:
    """Return deviations of way (m) and yaw (rad) after a straight way."""
    # Slip is an Ornstein-Uhlenbeck process: its integral grows like a random walk.
    seconds, tau = way / SPEED, wheels.slip_time_s
    walk = 2.0 * tau * seconds - 2.0 * tau**2 * (1.0 - math.exp(-seconds / tau))
    slip = wheels.slip_sd * SPEED * math.sqrt(walk)
    wheel = math.hypot(wheels.radius_error_sd * way, slip)
    return wheel / math.sqrt(2.0), math.sqrt(2.0) * wheel / wheels.track_m
