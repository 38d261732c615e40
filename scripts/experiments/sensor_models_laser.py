"""The laser part of `sensor-models`: noise, bias, lost beams and steps before plain walls."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from floornav_common.reporting import Section, Table
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, Wall, World

EXACT = {"noise_sd_m": 0.0, "quantum_m": 0.0, "dropout_share": 0.0, "edge_share": 0.0}


def laser_noise(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return deviation, bias, share of lost beams and step of the ranges in an empty room."""
    config = {"noise_sd_share": 0.005, "edge_share": 0.0}
    corners = ((0.0, 0.0), (9.0, 0.0), (9.0, 6.0), (0.0, 6.0))
    walls = tuple(Wall(from_m=a, to_m=b) for a, b in zip(corners, _turned(corners), strict=True))
    exact = _scans(walls, EXACT, 1, args.seed)[0]
    seen = _scans(walls, config, args.scans, args.seed)
    off = seen - exact
    model = Simulation(_world(walls, config)).models[""].config.laser
    promised = np.sqrt(
        model.noise_sd_m**2 + (model.noise_sd_share * exact) ** 2 + model.quantum_m**2 / 12.0
    )
    rows, sds = [], []
    edges = np.arange(1.0, 8.0, 1.0)
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        here = (exact >= low) & (exact < high)
        if here.any():
            sd, want = float(np.nanstd(off[:, here])), float(np.sqrt((promised[here] ** 2).mean()))
            bias = float(np.nanmean(off[:, here]))
            sds.append({"from_m": low, "sd_m": sd, "promised_sd_m": want, "bias_m": bias})
            rows.append([f"{low:.0f}-{high:.0f}", *(f"{1e3 * v:.2f}" for v in (sd, want, bias))])
    lost = float(np.isnan(seen).mean())
    step = float(np.nanmax(np.abs(seen / model.quantum_m - np.round(seen / model.quantum_m))))
    values = {
        "by_range": sds, "dropout_share": lost, "promised_dropout_share": model.dropout_share,
        "bias_m": float(np.nanmean(off)), "promised_bias_m": 0.0, "off_step_share": step,
    }  # fmt: skip
    values["kept"] = (
        all(abs(s["sd_m"] / s["promised_sd_m"] - 1.0) < 0.05 for s in sds)
        and abs(values["bias_m"]) < 3e-4
        and abs(lost - model.dropout_share) < 1e-3
    )
    header = ["range m", "deviation mm", "promised mm", "bias mm"]
    text = f"{100 * lost:.2f} % of the beams lost, {100 * model.dropout_share:.2f} % promised."
    title = (
        "Ranges in an empty room beside those of an exact laser, by distance: deviation beside "
        "what noise and step of the settings make up, and bias, which ought to be 0."
    )
    return values, Section("Laser noise", [title, Table(header, rows), text])


def _turned(corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    return (*corners[1:], corners[0])


def _world(walls: tuple[Wall, ...], laser: dict[str, Any]) -> World:
    overrides = {"laser": laser, "sonar": None}
    robot = RobotPlacement(model="segway_rmp50", position_m=(4.5, 3.0), overrides=overrides)
    return World(name="laser", walls=walls, robots=(robot,))


def _scans(walls: tuple[Wall, ...], laser: dict[str, Any], num: int, seed: int) -> np.ndarray:
    """Return the ranges of a number of scans from standstill, shape (num, N), m."""
    simulation, scans = Simulation(_world(walls, laser), seed=seed), []
    while len(scans) < num:
        scan = simulation.step({}).robots[""].scan
        if scan is not None:
            scans.append(scan.ranges.astype(np.float64))
    simulation.close()
    return np.array(scans)
