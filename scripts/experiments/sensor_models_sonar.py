"""The sonar part of `sensor-models`: who answers by angle, thin posts, cross-talk."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

from experiments.sensor_models_textbook import answered_share, cross_talk_range
from floornav_common.reporting import Picture, Section, Table
from sim_bridge.drawing import GLASS
from sim_bridge.glass import Glass
from sim_bridge.simulation import Simulation
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.world import Column, RobotPlacement, Wall, World

WALL_X = 2.5
# Dense where a wall ceases to answer: 25 degrees, with a deviation of 2.
ANGLES_DEG = (0.0, 5.0, 10.0, 15.0, 19.0, 21.0, 23.0, 25.0, 27.0, 29.0, 31.0, 35.0, 45.0)
FIRINGS = 200
MOST_OFF, MOST_OFF_M = 0.12, 0.01  # of shares of so many firings: 3.5 deviations at one half
POSTS = ((0.03, 1.0), (0.03, 3.0), (0.065, 3.0))
LISTENING_DEG = (5.0, 10.0, 14.0, 20.0, 30.0)
TALK_YAW_DEG = 6.0
INK = "#6b7480"
_EXACT = {
    "noise_sd_m": 0.0, "noise_sd_share": 0.0, "quantum_m": 0.0, "miss_share": 0.0,
    "critical_sd_rad": 0.0,
}  # fmt: skip
_ALONE = {"count": 1, "groups": [], "period_s": 0.01}
_ENOUGH = 100  # hits for a deviation


def sonar_by_angle(args: argparse.Namespace) -> tuple[dict[str, Any], Section]:
    """Return shares of firings answered and errors by angle, for walls, posts and cross-talk."""
    walls = {
        "wall": _by_angle(None, args.seed),
        "glass": _by_angle(Glass(), args.seed + 5000),  # its own numbers: else the same to a digit
    }
    posts = [_post(radius, distance, args.seed) for radius, distance in POSTS]
    talk = [_cross_talk(half, args.seed) for half in LISTENING_DEG]
    worst = max(abs(r["answered"] - r["promised"]) for rows in walls.values() for r in rows)
    values: dict[str, Any] = {
        **walls, "posts": posts, "cross_talk": talk, "worst_difference": worst,
        "kept": worst < MOST_OFF and all(r["kept"] for rows in walls.values() for r in rows)
        and all(row["kept"] for row in (*posts, *talk)),
    }  # fmt: skip
    path = args.out_dir / "sonar.png"
    _draw(path, walls)
    return values, Section("Sonar", _blocks(walls, posts, talk, worst, path))


def _by_angle(glass: Glass | None, seed: int) -> list[dict[str, Any]]:
    """Return how the front sonar answers a long wall, by the angle of its axis to the normal."""
    half = 0.06 if glass is None else glass.thickness_m / 2.0
    wall = Wall(from_m=(WALL_X + half, -30.0), to_m=(WALL_X + half, 30.0), glass=glass)
    rows = []
    for k, angle in enumerate(ANGLES_DEG):
        simulation = _simulation(World(name="sonar", walls=(wall,)), angle, _ALONE, seed + k)
        config, place = _config(simulation), _sonar(simulation, 0)[0]
        ranges = _fire(simulation, 0, FIRINGS)
        # Beyond the cone the nearest point of the wall that sound meets is on the cone's edge.
        beyond = max(math.radians(angle) - config.opening_rad / 2.0, 0.0)
        truth = (WALL_X - place[0]) / math.cos(beyond)
        is_hit, off = np.isfinite(ranges), ranges - truth
        promised = float(
            answered_share(
                np.array(beyond), config.critical_rad, config.critical_sd_rad, config.miss_share
            )
        )
        sd = math.hypot(config.noise_sd_m, config.noise_sd_share * truth)
        sd = math.hypot(sd, config.quantum_m / math.sqrt(12.0))
        has_enough = is_hit.sum() >= _ENOUGH
        bias = float(off[is_hit].mean()) if has_enough else None
        found = float(off[is_hit].std()) if has_enough else None
        is_exact = bias is None or abs(bias) < MOST_OFF_M
        is_even = found is None or abs(found / sd - 1.0) < 0.25
        rows.append({
            "angle_deg": angle, "answered": float(is_hit.mean()), "promised": promised,
            "bias_m": bias, "sd_m": found, "promised_sd_m": sd, "kept": is_exact and is_even,
        })  # fmt: skip
    return rows


def _post(radius: float, distance: float, seed: int) -> dict[str, Any]:
    """Return how often a thin post is heard, over bearings in the cone."""
    heard, off = [], []
    for bearing in np.radians(np.arange(-9.5, 9.6, 1.0)):
        x, y = 0.2 + distance * math.cos(bearing), distance * math.sin(bearing)
        post = Column(name="post", center_m=(x, y), radius_m=radius)
        world = World(name="post", columns=(post,))
        ranges = _fire(_simulation(world, 0.0, {**_ALONE, **_EXACT}, seed), 0, 1)
        heard.append(np.isfinite(ranges).all())
        off += [float(r) - (distance - radius) for r in ranges if np.isfinite(r)]
    share, worst = float(np.mean(heard)), float(np.abs(off).max(initial=0.0))
    return {
        "radius_m": radius, "distance_m": distance, "heard": share, "promised": 1.0,
        "worst_m": worst, "kept": share == 1.0 and worst < 1e-3,
    }  # fmt: skip


def _cross_talk(half_listening_deg: float, seed: int) -> dict[str, Any]:
    """Return what a sonar reads that hears only its neighbor's echo."""
    wall = Wall(from_m=(WALL_X + 0.06, -30.0), to_m=(WALL_X + 0.06, 30.0))
    rest = [[k] for k in range(16) if k not in (0, 1)]
    settings = {
        **_EXACT, "groups": [[0, 1], *rest], "period_s": 0.15,
        "listening_rad": 2.0 * math.radians(half_listening_deg),
    }  # fmt: skip
    simulation = _simulation(World(name="talk", walls=(wall,)), TALK_YAW_DEG, settings, seed)
    config = _config(simulation)
    (sender, axis), (receiver, facing) = _sonar(simulation, 0), _sonar(simulation, 1)
    promised = cross_talk_range(
        sender, axis, receiver, facing, WALL_X, config.opening_rad / 2.0, config.critical_rad,
        math.radians(half_listening_deg),
    )  # fmt: skip
    found = float(_fire(simulation, 1, 1)[0])
    kept = found == promised or abs(found - promised) < 0.03
    none = {math.inf: None}
    return {
        "half_listening_deg": half_listening_deg, "range_m": none.get(found, found),
        "promised_m": none.get(promised, promised), "kept": kept,
    }  # fmt: skip


def _simulation(world: World, yaw_deg: float, sonar: dict[str, Any], seed: int) -> Simulation:
    robot = RobotPlacement(
        model="segway_rmp50", position_m=(0.0, 0.0), yaw_deg=yaw_deg,
        overrides={"laser": None, "sonar": sonar},
    )  # fmt: skip
    return Simulation(World(**{**vars(world), "robots": (robot,)}), seed=seed)


def _config(simulation: Simulation) -> SonarConfig:
    config = simulation.models[""].config.sonar
    assert config is not None
    return config


def _sonar(simulation: Simulation, number: int) -> tuple[np.ndarray, float]:
    """Return where a sonar is and the bearing of its axis in the world."""
    mount, start = simulation.models[""].mounts[f"sonar_{number}"], simulation.starts[""]
    place = (start @ mount[None, :2, 3])[0]
    return place, start.yaw + math.atan2(mount[1, 0], mount[0, 0])


def _fire(simulation: Simulation, number: int, num: int) -> np.ndarray:
    """Return a number of readings of one sonar from standstill, (num,), m; frees the engine."""
    ranges: list[float] = []
    while len(ranges) < num:
        readings = simulation.step({}).robots[""].sonar
        if readings is not None and not np.isnan(readings[number].range):
            ranges.append(readings[number].range)
    simulation.close()
    return np.array(ranges)


def _blocks(
    walls: dict[str, list[dict]], posts: list[dict], talk: list[dict], worst: float, path: Path
) -> list:
    def mm(value: float | None) -> str:
        return "-" if value is None else f"{1e3 * value:.1f}"

    by_angle = [
        [name, f"{r['angle_deg']:.0f}", f"{r['answered']:.3f}", f"{r['promised']:.3f}",
         mm(r["bias_m"]), mm(r["sd_m"]), mm(r["promised_sd_m"])]
        for name, rows in walls.items() for r in rows
    ]  # fmt: skip
    text = (
        f"Share of {FIRINGS} firings answered by the angle between a sonar's axis and the wall's "
        "normal. Promised: a smooth wall answers where its normal is within the critical angle "
        "(15 deg, 2 deg of deviation from firing to firing) of the nearest ray of the cone (10 deg "
        f"to each side). Largest difference {worst:.3f}; {MOST_OFF} allowed."
    )
    thin = [
        [f"{200 * r['radius_m']:.0f}", f"{r['distance_m']:g}", f"{r['heard']:.2f}",
         f"{r['promised']:.2f}", mm(r["worst_m"])]
        for r in posts
    ]  # fmt: skip
    heard = [
        [f"{r['half_listening_deg']:.0f}",
         *("none" if r[key] is None else f"{r[key]:.3f}" for key in ("range_m", "promised_m"))]
        for r in talk
    ]  # fmt: skip
    return [
        text,
        Table(["wall of", "angle deg", "answered", "promised", "bias mm", "deviation mm",
               "promised mm"], by_angle),
        "Thin upright posts, at 20 bearings in the cone: a cylinder always answers from the line "
        "of it that is nearest.",
        Table(["thick cm", "distance m", "heard", "promised", "largest error mm"], thin),
        "Cross-talk: what a sonar too slanted for an echo of its own reads of its neighbor's, by "
        "half the angle in which it listens.",
        Table(["half listening angle deg", "range m", "promised m"], heard),
        Picture(path),
    ]  # fmt: skip


def _draw(path: Path, walls: dict[str, list[dict[str, Any]]]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9.0, 3.8), layout="constrained")
    config = SonarConfig()
    fine = np.linspace(0.0, 50.0, 501)
    beyond = np.maximum(np.radians(fine) - config.opening_rad / 2.0, 0.0)
    curve = answered_share(beyond, config.critical_rad, config.critical_sd_rad, config.miss_share)
    axes.plot(fine, curve, color="#1a7f4b", lw=1.4, label="promised for both")
    looks = {"wall": ("s", INK, -0.25), "glass": ("o", GLASS, 0.25)}
    for name, rows in walls.items():
        marker, color, aside = looks[name]
        axes.plot([r["angle_deg"] + aside for r in rows], [r["answered"] for r in rows], marker,
                  color=color, ms=6, mfc="none", mew=1.6, label=f"{name}, measured")  # fmt: skip
    axes.set(xlim=(-1.0, 50.0), ylim=(-0.02, 1.05))
    axes.set(xlabel="angle of axis to the wall's normal [deg]", ylabel="share answered")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=100)
    plt.close(figure)
