"""The glass part of `sensor-models`: what becomes of laser beams at a pane, by angle."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

from experiments.sensor_models_textbook import (
    delay_of_a_pane,
    dirt_share,
    light_through_a_pane,
    lost_share,
    mirror_share,
)
from floornav_common.reporting import Picture, Section, Table
from sim_bridge.config import LaserConfig
from sim_bridge.glass import Glass
from sim_bridge.simulation import Simulation
from sim_bridge.world import RobotPlacement, Wall, World

PANE_X, WALL_X, LASER_X = 2.0, 2.5, 0.14
YAWS_DEG = (-35.0, -12.0, 0.0, 17.0, 40.0)
SEEDS_A_YAW = 8  # other dirt each
FAR_DEG, BIN_DEG = 84.0, 3.0
NAMES = ("through", "mirror", "dirt", "lost")
COLORS = ("#1a7f4b", "#31b5d6", "#8a5cc2", "#d7301f")
SPOTS_DEG = (30.0, 60.0, 75.0)
MOST_OFF, MOST_OFF_M = 0.025, 1e-4
_LASER = {
    "noise_sd_m": 0.0, "quantum_m": 0.0, "dropout_share": 0.0, "edge_share": 0.0,
    "num_beams": 681, "fov_rad": math.radians(170.0), "range_max_m": 30.0,
}  # fmt: skip


def glass_by_angle(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return shares of beams by angle: through a pane, back from it, from dirt, lost."""
    glass = Glass()
    angles, ranges, from_laser, config = _look(glass, args.scans, args.seed)
    incidence = np.abs(np.radians(angles))
    front = (PANE_X - from_laser) / np.cos(incidence)
    direct = (WALL_X - from_laser) / np.cos(incidence)
    delay = delay_of_a_pane(incidence, glass.refractive_index, glass.thickness_m)
    found = {
        "through": np.abs(ranges - direct - delay) < MOST_OFF_M,
        "mirror": np.abs(ranges - front) < MOST_OFF_M,
        "lost": np.isinf(ranges),
    }
    found["dirt"] = ~(found["through"] | found["mirror"] | found["lost"])
    promised = _promised(glass, config, incidence, direct)
    bins = _by_bin(np.degrees(incidence), found, promised)
    spots = [_at(d, glass, np.degrees(incidence), ranges - direct, delay) for d in SPOTS_DEG]
    worst = max(abs(row[n] - row[f"promised_{n}"]) for row in bins for n in NAMES)
    values = {"by_angle": bins, "behind": spots, "worst_difference": worst}
    values["kept"] = worst < MOST_OFF and all(
        s["delay_m"] is not None and abs(s["delay_m"] - s["promised_delay_m"]) < MOST_OFF_M
        for s in spots
    )
    path = args.out_dir / "glass.png"
    _draw(path, bins)
    return values, Section("Laser and glass", _blocks(bins, spots, worst, path))


def _look(
    glass: Glass, scans: int, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, LaserConfig]:
    """Return angle [deg], range and the laser's x of every beam that meets pane and wall."""
    half = glass.thickness_m / 2.0
    pane = Wall(from_m=(PANE_X + half, -60.0), to_m=(PANE_X + half, 60.0), glass=glass)
    wall = Wall(from_m=(WALL_X + 0.06, -60.0), to_m=(WALL_X + 0.06, 60.0))
    each = max(round(scans / len(YAWS_DEG) / SEEDS_A_YAW), 1)
    parts = []
    for k, yaw in enumerate(YAWS_DEG):
        robot = RobotPlacement(
            model="segway_rmp50", position_m=(0.0, 0.0), yaw_deg=yaw,
            overrides={"laser": _LASER, "sonar": None},
        )  # fmt: skip
        simulation = Simulation(World(name="glass", walls=(pane, wall), robots=(robot,)))
        config = simulation.models[""].config.laser
        beams = np.linspace(-85.0, 85.0, 681) + yaw
        is_onto = np.abs(beams) < FAR_DEG
        laser_x = np.full(is_onto.sum(), LASER_X * math.cos(math.radians(yaw)))
        for number in range(SEEDS_A_YAW):
            simulation.reset(seed + 100 * k + number)
            for scan in _scans(simulation, each):
                parts.append((beams[is_onto], scan[is_onto], laser_x))
        simulation.close()
    angles, ranges, places = (np.concatenate(part) for part in zip(*parts, strict=True))
    return angles, ranges, places, config


def _scans(simulation: Simulation, num: int) -> list[np.ndarray]:
    scans: list[np.ndarray] = []
    while len(scans) < num:
        scan = simulation.step({}).robots[""].scan
        if scan is not None:
            scans.append(scan.ranges.astype(np.float64))
    return scans


def _promised(
    glass: Glass, config: LaserConfig, incidence: np.ndarray, wall: np.ndarray
) -> dict[str, np.ndarray]:
    mirror = mirror_share(
        incidence, glass.specular_share, math.radians(glass.specular_half_width_deg)
    )
    dirt = dirt_share(incidence, glass.scatter_share)
    light = light_through_a_pane(incidence, glass.refractive_index, glass.transmission)
    reach = config.reach_factor * config.range_max_m
    lost = lost_share(wall, incidence, reach, light, config.echo_log_sd)
    lost = np.where(wall > config.range_max_m, 1.0, lost)
    on = (1.0 - mirror) * (1.0 - dirt)
    return {
        "through": on * (1.0 - lost), "mirror": mirror, "dirt": (1.0 - mirror) * dirt,
        "lost": on * lost, "light": light,
    }  # fmt: skip


def _by_bin(
    degrees: np.ndarray, found: dict[str, np.ndarray], promised: dict[str, np.ndarray]
) -> list[dict[str, float]]:
    rows = []
    for low in np.arange(0.0, FAR_DEG, BIN_DEG):
        here = (degrees >= low) & (degrees < low + BIN_DEG)
        row = {"from_deg": float(low), "light": float(promised["light"][here].mean())}
        for name in NAMES:
            row[name] = float(found[name][here].mean())
            row[f"promised_{name}"] = float(promised[name][here].mean())
        rows.append(row)
    return rows


def _at(
    at_deg: float, glass: Glass, degrees: np.ndarray, later: np.ndarray, delay: np.ndarray
) -> dict[str, float | None]:
    """Return how much too far the wall behind seems at an angle, measured beside promised."""
    here = (np.abs(degrees - at_deg) < 0.13) & (np.abs(later - delay) < 0.01)
    want = delay_of_a_pane(np.radians(at_deg), glass.refractive_index, glass.thickness_m)
    found = float(np.median(later[here])) if here.any() else None
    # At the angles of the beams, not between them.
    off = 0.0 if found is None else float(np.median(delay[here])) - float(want)
    return {
        "at_deg": at_deg, "delay_m": None if found is None else found - off,
        "promised_delay_m": float(want),
    }  # fmt: skip


def _blocks(bins: list[dict], spots: list[dict], worst: float, path: Path) -> list:
    rows = [
        [f"{r['from_deg']:.0f}-{r['from_deg'] + BIN_DEG:.0f}",
         *(f"{r[n]:.3f} / {r[f'promised_{n}']:.3f}" for n in NAMES), f"{r['light']:.3f}"]
        for r in bins
    ]  # fmt: skip
    text = (
        "Shares of the beams by angle of incidence on a pane with a wall 0.5 m behind, robot "
        f"turned by {', '.join(f'{y:.0f}' for y in YAWS_DEG)} deg: measured / promised (textbook "
        "formulas, not the simulator's own). The last column is no share of beams: it is how much "
        "light crosses the pane once, and a beam still comes through while its echo is strong "
        "enough. Steep beams are lost: weakened twice by the pane, and by the slant. Largest "
        f"difference {worst:.3f}; {MOST_OFF} allowed."
    )
    late = [
        [f"{s['at_deg']:.0f}", "-" if s["delay_m"] is None else f"{1e3 * s['delay_m']:.2f}",
         f"{1e3 * s['promised_delay_m']:.2f}"]
        for s in spots
    ]  # fmt: skip
    return [
        text,
        Table(["angle deg", *(f"{n} / promised" for n in NAMES), "light crossing once"], rows),
        "How much too far the wall behind the pane seems, mm: light is slower in glass.",
        Table(["angle deg", "measured", "promised"], late),
        Picture(path),
    ]


def _draw(path: Path, bins: list[dict[str, float]]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9.0, 4.2), layout="constrained")
    middles = [row["from_deg"] + BIN_DEG / 2.0 for row in bins]
    for name, color in zip(NAMES, COLORS, strict=True):
        axes.plot(middles, [row[f"promised_{name}"] for row in bins], color=color, lw=1.6,
                  label=f"{name}, promised")  # fmt: skip
        axes.plot(middles, [row[name] for row in bins], "o", color=color, ms=4.5, mfc="none",
                  label=f"{name}, measured")  # fmt: skip
    axes.set(xlabel="angle of incidence [deg]", ylabel="share of beams", ylim=(-0.02, 1.02))
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure.savefig(path, dpi=100)
    plt.close(figure)
