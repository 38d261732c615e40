"""The odometry part of `sensor-models`: drift on a straight way, and whether covariances are true.

A covariance C is true if e^T C^-1 e of the errors e has the mean 3 (NEES, normalized estimation
error squared, of three numbers). It is looked at for every robot, straight, sideways and turning.
"""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np

from floornav_common.reporting import Section, Table
from sim_bridge.config import STEP_S, WheelConfig
from sim_bridge.drive import Velocity
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, World

SPEED = 0.8  # m/s
SECONDS = 13.0
NEES = 3.0
WAYS = (
    ("segway_rmp50", Velocity(0.8, 0.0), 4.0),
    ("segway_rmp50", Velocity(0.8, 0.0), 15.0),
    ("segway_rmp50", Velocity(0.0, 1.0), 15.0),
    ("segway_urg", Velocity(0.6, 0.9), 8.0),
    ("segway_stereo", Velocity(0.6, -0.3), 8.0),
    ("soccer_small_size", Velocity(0.4, 0.0), 15.0),
    ("soccer_small_size", Velocity(0.0, 0.0, 0.4), 15.0),
    ("soccer_small_size", Velocity(0.0, 1.5), 10.0),
    ("soccer_middle_size", Velocity(1.0, 0.0), 10.0),
    ("soccer_middle_size", Velocity(0.0, 0.0, 1.0), 8.0),
    ("soccer_middle_size", Velocity(0.7, 0.5, 0.3), 8.0),
)
_BLIND = {"laser": None, "sonar": None, "omni": None, "stereo": None}


def odometry_drift(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return the drift a meter beside the wheels' settings, and how true the covariances are."""
    wheels, truth, odometry, covs = _driven(
        "segway_rmp50", Velocity(SPEED, 0.0), SECONDS, args.runs, args.seed
    )
    claimed = np.sqrt(np.diagonal(covs, axis1=1, axis2=2))
    way = float(odometry[:, 0].mean())
    # Along the way each believed, so that a curve does not count as too short a way.
    along = np.hypot(*truth[:, :2].T) - np.hypot(*odometry[:, :2].T)
    yaw = truth[:, 2] - odometry[:, 2]
    promised = _promised(wheels, way)
    figures = {
        "mean_per_m": (float(along.mean()) / way, -wheels.slip_mean),
        "sd_m": (float(along.std(ddof=1)), promised[0]),
        "yaw_sd_rad": (float(yaw.std(ddof=1)), promised[1]),
        "claimed_rms_m": (
            float(claimed[:, 0].mean()),
            math.hypot(promised[0], wheels.slip_mean * way),
        ),
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
        "and its deviation; claimed: the covariance in the messages."
    )
    values["nees"] = consistency(args)
    values["kept"] = values["kept"] and all(row["kept"] for row in values["nees"])
    parts: list[Any] = [text, Table(["drift", "measured", "promised"], rows)]
    return values, Section("Odometry", [*parts, *_as_parts(values["nees"], args.runs)])


def _driven(
    model: str, velocity: Velocity, seconds: float, runs: int, seed: int
) -> tuple[WheelConfig, np.ndarray, np.ndarray, np.ndarray]:
    """Return a robot's wheels; at the end of each run true pose, odometry, its covariance."""
    robot = RobotPlacement(model=model, position_m=(0.0, 0.0), overrides=_BLIND)
    simulation = Simulation(World(name="hall", robots=(robot,)))
    ends = []
    for k in range(runs):
        simulation.reset(seed + k)
        for _ in range(round(seconds / STEP_S)):
            seen = simulation.step({"": velocity}).robots[""]
        assert seen.odometry is not None
        ends.append(
            (seen.ground_truth.pose.as_array(), seen.odometry.pose.as_array(), seen.odometry.cov)
        )
    wheels = simulation.models[""].config.wheels
    simulation.close()
    truth, odometry, covs = (np.array(v) for v in zip(*ends, strict=True))
    return wheels, truth, odometry, covs


def consistency(args: argparse.Namespace) -> list[dict[str, Any]]:
    """Return the mean NEES of each robot on each kind of way."""
    rows = []
    for model, velocity, seconds in WAYS:
        _, truth, odometry, covs = _driven(model, velocity, seconds, args.runs, args.seed + 1000)
        off = truth - odometry
        off[:, 2] = np.remainder(off[:, 2] + np.pi, 2.0 * np.pi) - np.pi
        nees = np.einsum("ni,ni->n", off, np.linalg.solve(covs, off[..., None])[..., 0])
        mean = float(nees.mean())
        # 3.5 deviations of the mean of so many chi-square values of 3 degrees of freedom.
        spread = 3.5 * math.sqrt(2.0 * NEES / args.runs)
        rows.append(
            {
                "robot": model,
                "speed": velocity.speed,
                "side_speed": velocity.side_speed,
                "yaw_rate": velocity.yaw_rate,
                "seconds": seconds,
                "nees": mean,
                "kept": abs(mean - NEES) < spread,
            }
        )
    return rows


def _as_parts(rows: list[dict[str, Any]], runs: int) -> list[Any]:
    text = (
        f"How true the covariances are: NEES, mean of {runs} runs each; 3 if they are, more if "
        f"they promise too much. Kept: within 3.5 deviations of such a mean, "
        f"{3.5 * math.sqrt(2.0 * NEES / runs):.1f}."
    )
    header = ["robot", "m/s", "m/s sideways", "rad/s", "s", "NEES", "kept"]
    cells = [
        [
            row["robot"], f"{row['speed']:g}", f"{row['side_speed']:g}", f"{row['yaw_rate']:g}",
            f"{row['seconds']:g}", f"{row['nees']:.2f}", "yes" if row["kept"] else "NO",
        ]
        for row in rows
    ]  # fmt: skip
    return [text, Table(header, cells)]


def _promised(wheels: WheelConfig, way: float) -> tuple[float, float]:
    """Return deviations of way (m) and yaw (rad) after a straight way."""
    # Slip is an Ornstein-Uhlenbeck process: its integral grows like a random walk.
    seconds, tau = way / SPEED, wheels.slip_time_s
    walk = 2.0 * tau * seconds - 2.0 * tau**2 * (1.0 - math.exp(-seconds / tau))
    slip = wheels.slip_sd * SPEED * math.sqrt(walk)
    wheel = math.hypot(wheels.radius_error_sd * way, slip)
    return wheel / math.sqrt(2.0), math.sqrt(2.0) * wheel / wheels.track_m
