"""The sonar part of `sensor-models`: how often walls answer by angle, and from how far."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from floornav_common.reporting import Picture, Section, Table
from sim_bridge.drawing import GLASS
from sim_bridge.glass import Glass
from sim_bridge.simulation import Simulation
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.world import RobotPlacement, Wall, World

WALL_X = 2.5
YAWS_DEG = np.arange(-11.0, 11.1, 2.0)
ROUNDS = 60
BIN_DEG = 5.0
FAR_DEG = 50.0
INK = "#6b7480"


def sonar_by_angle(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return shares of firings answered and errors by angle, for a plain wall and a glass one."""
    values: dict[str, Any] = {}
    table, curves = [], {}
    for name, glass in (("wall", None), ("glass", Glass())):
        angles, ranges, truth, config = _fire(glass, args.seed)
        promised = _promised(config, angles)
        is_hit = np.isfinite(ranges)
        off = np.where(is_hit, ranges - truth, np.nan)
        rows = []
        for low in np.arange(0.0, FAR_DEG, BIN_DEG):
            here = (np.abs(angles) >= low) & (np.abs(angles) < low + BIN_DEG)
            row = {
                "from_deg": float(low), "answered": float(is_hit[here].mean()),
                "promised": float(promised[here].mean()), "bias_m": _mean(off[here]),
                "sd_m": float(np.nanstd(off[here])) if is_hit[here].any() else None,
            }  # fmt: skip
            rows.append(row)
            cells = [f"{row['answered']:.3f}", f"{row['promised']:.3f}"]
            cells += ["-" if v is None else f"{1e3 * v:.1f}" for v in (row["bias_m"], row["sd_m"])]
            table.append([name, f"{low:.0f}-{low + BIN_DEG:.0f}", *cells])
        values[name] = rows
        curves[name] = (angles, is_hit, promised)
    worst = max(abs(r["answered"] - r["promised"]) for rows in values.values() for r in rows)
    values["worst_difference"] = worst
    values["promised_sd_m"] = float(
        np.hypot(config.noise_sd_m, config.noise_sd_share * (WALL_X - 0.2))
    )
    values["kept"] = worst < 0.05 and abs(values["wall"][0]["bias_m"]) < 0.01
    picture = args.out_dir / "sonar.png"
    _draw(picture, curves)
    header = ["wall of", "angle deg", "answered", "promised", "bias mm", "deviation mm"]
    text = (
        f"Angle between a sonar's axis and the wall's normal. Promised: a surface answers where "
        f"its normal is within the critical angle ({np.degrees(config.critical_rad):.0f} deg) of "
        f"the nearest ray of the cone; {1e3 * values['promised_sd_m']:.1f} mm deviation (and the "
        f"step of {1e3 * config.quantum_m:.0f} mm). Largest difference {worst:.3f}."
    )
    return values, Section("Sonar by angle", [text, Table(header, table), Picture(picture)])


def _fire(glass: Glass | None, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, SonarConfig]:
    """Return angle, range and promised range of each firing at one long wall."""
    half = 0.06 if glass is None else glass.thickness_m / 2.0
    ends = ((WALL_X + half, -30.0), (WALL_X + half, 30.0))
    wall = Wall(from_m=ends[0], to_m=ends[1], glass=glass)
    angles, ranges, truth = [], [], []
    for k, yaw in enumerate(YAWS_DEG):
        overrides = {"laser": None, "sonar": {"period_s": 0.04}}
        robot = RobotPlacement(
            model="segway_rmp50", position_m=(0.0, 0.0), yaw_deg=float(yaw), overrides=overrides
        )
        simulation = Simulation(World(name="sonar", walls=(wall,), robots=(robot,)), seed=seed + k)
        model = simulation.models[""]
        pose = simulation.starts[""]
        config = model.config.sonar
        mounts = [model.mounts[frame] for frame in model.config.sonar_frames]
        for _ in range(ROUNDS * round(config.period_s / 0.01)):
            for number, reading in enumerate(simulation.step({}).robots[""].sonar or ()):
                if np.isnan(reading.range):
                    continue
                ahead = mounts[number][:2, 0]
                place = pose @ mounts[number][None, :2, 3]
                angles.append(np.degrees(pose.yaw + np.arctan2(ahead[1], ahead[0])))
                ranges.append(reading.range)
                truth.append(WALL_X - place[0, 0])
        simulation.close()
    wrapped = (np.array(angles) + 180.0) % 360.0 - 180.0
    # Beyond the cone the nearest point of the wall that sound meets is on the cone's edge.
    slant = np.cos(np.minimum(_beyond_cone(config, wrapped), 1.5))
    return wrapped, np.array(ranges), np.array(truth) / slant, config


def _promised(config: SonarConfig, angles_deg: np.ndarray) -> np.ndarray:
    nearest = _beyond_cone(config, angles_deg)
    sure = 1.0 - config.miss_share
    return sure * norm.cdf((config.critical_rad - nearest) / config.critical_sd_rad)


def _beyond_cone(config: SonarConfig, angles_deg: np.ndarray) -> np.ndarray:
    return np.maximum(np.abs(np.radians(angles_deg)) - config.opening_rad / 2.0, 0.0)


def _mean(values: np.ndarray) -> float | None:
    return float(np.nanmean(values)) if np.isfinite(values).any() else None


def _draw(path: Path, curves: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9.0, 3.8), layout="constrained")
    for (name, (angles, is_hit, promised)), color in zip(curves.items(), (INK, GLASS), strict=True):
        places = np.unique(np.round(angles, 1))
        shares = [is_hit[np.abs(angles - place) < 0.06].mean() for place in places]
        axes.plot(places, shares, "o", color=color, ms=4, label=f"{name}, measured")
        order = np.argsort(angles)
        axes.plot(angles[order], promised[order], color=color, lw=1.2)
    axes.set(xlim=(-FAR_DEG, FAR_DEG), ylim=(-0.02, 1.05))
    axes.set(xlabel="angle of axis to the wall's normal [deg]", ylabel="share answered")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=100)
    plt.close(figure)
