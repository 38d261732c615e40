"""The laser part of `sensor-models`: noise before walls, shares by angle through a pane."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from floornav_common.reporting import Picture, Section, Table
from sim_bridge.glass import (
    Glass,
    optical_delay,
    scatter_probability,
    specular_probability,
    transmittance,
)
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, Wall, World

PANE_X, WALL_X = 3.0, 4.0
LASER_X = 0.14
SPECKLE_SD = 0.1  # sim_bridge.panes: of the logarithm of an echo's reach
EXACT = {"noise_sd_m": 0.0, "quantum_m": 0.0, "dropout_share": 0.0, "edge_share": 0.0}
BIN_DEG, FAR_DEG = 5.0, 80.0  # beyond, the pane itself is out of range


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
    return values, Section("Laser noise", [Table(header, rows), text])


def glass_by_angle(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return shares of beams by angle: through a pane, back from it, from dirt, lost."""
    glass = Glass()
    half = glass.thickness_m / 2.0
    pane = Wall(from_m=(PANE_X + half, -40.0), to_m=(PANE_X + half, 40.0), glass=glass)
    behind = Wall(from_m=(WALL_X + 0.06, -40.0), to_m=(WALL_X + 0.06, 40.0))
    laser = {**EXACT, "num_beams": 681, "fov_rad": math.radians(170.0), "range_max_m": 20.0}
    ranges = _scans((pane, behind), laser, args.scans, args.seed)
    angles = np.abs(np.linspace(-85.0, 85.0, 681))
    cos = np.cos(np.radians(angles))
    front, wall = (PANE_X - LASER_X) / cos, (WALL_X - LASER_X) / cos + optical_delay(glass, cos)
    found = {
        "through": np.abs(ranges - wall) < 1e-4,
        "mirror": np.abs(ranges - front) < 1e-4,
        "lost": np.isinf(ranges),
    }
    found["dirt"] = ~(found["through"] | found["mirror"] | found["lost"])
    promised = _promised_shares(glass, cos, wall, reach=1.5 * laser["range_max_m"])
    names = ("through", "mirror", "dirt", "lost")
    rows, table = [], []
    for low in np.arange(0.0, FAR_DEG, BIN_DEG):
        here = (angles >= low) & (angles < low + BIN_DEG)
        row: dict[str, float] = {"from_deg": float(low)}
        for name in names:
            row[name] = float(found[name][:, here].mean())
            row[f"promised_{name}"] = float(promised[name][here].mean())
        row["transmittance"] = float(transmittance(glass, cos[here]).mean())
        rows.append(row)
        pairs = [f"{row[n]:.3f} / {row[f'promised_{n}']:.3f}" for n in names]
        table.append([f"{low:.0f}-{low + BIN_DEG:.0f}", f"{row['transmittance']:.3f}", *pairs])
    worst = max(abs(row[n] - row[f"promised_{n}"]) for row in rows for n in names)
    picture = args.out_dir / "glass.png"
    _draw_glass(picture, angles, found, promised)
    header = ["angle deg", "light through", *(f"{n} / promised" for n in names)]
    text = (
        "Shares of the beams by angle of incidence on a pane 2.9 m ahead with a wall 1 m behind: "
        f"measured / promised, {args.scans} scans. Largest difference {worst:.3f}."
    )
    values = {"by_angle": rows, "worst_difference": worst, "kept": worst < 0.02}
    return values, Section("Laser and glass", [text, Table(header, table), Picture(picture)])


def _promised_shares(
    glass: Glass, cos: np.ndarray, wall: np.ndarray, reach: float
) -> dict[str, np.ndarray]:
    mirror, dirt = specular_probability(glass, cos), scatter_probability(glass, cos)
    on = (1.0 - mirror) * (1.0 - dirt)
    drowns = norm.cdf(np.log(wall / (reach * transmittance(glass, cos))) / SPECKLE_SD)
    # Beyond the longest range it gives, a laser cannot tell either.
    drowns = np.where(wall > reach / 1.5, 1.0, drowns)
    return {
        "through": on * (1.0 - drowns), "mirror": mirror, "dirt": (1.0 - mirror) * dirt,
        "lost": on * drowns,
    }  # fmt: skip


def _draw_glass(
    path: Path, angles: np.ndarray, found: dict[str, np.ndarray], promised: dict[str, np.ndarray]
) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9.0, 4.2), layout="constrained")
    order = np.argsort(angles)
    for (name, share), color in zip(
        promised.items(), ("#1a7f4b", "#31b5d6", "#8a5cc2", "#d7301f"), strict=True
    ):
        axes.plot(angles[order], share[order], color=color, lw=1.6, label=f"{name}, promised")
        axes.plot(angles, found[name].mean(axis=0), ".", color=color, ms=3)
    axes.set(xlabel="angle of incidence [deg]", ylabel="share of beams", ylim=(-0.02, 1.02))
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, ncols=2)
    figure.savefig(path, dpi=100)
    plt.close(figure)


def _turned(corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    return (*corners[1:], corners[0])


def _world(walls: tuple[Wall, ...], laser: dict[str, Any]) -> World:
    start = (0.0, 0.0) if walls[0].glass is not None else (4.5, 3.0)
    overrides = {"laser": laser, "sonar": None}
    robot = RobotPlacement(model="segway_rmp50", position_m=start, overrides=overrides)
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
