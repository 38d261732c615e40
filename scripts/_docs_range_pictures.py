"""Pictures for docs/ of what laser and sonars make of glass: one scene, and shares by angle."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from _docs_world_pictures import save
from experiments.sensor_models_glass import BIN_DEG, glass_by_angle
from experiments.sensor_models_sonar import sonar_by_angle
from floornav_common.transform3 import Transform3
from sim_bridge.drawing import GLASS, LASER, ROBOT, SONAR, draw_robot, draw_solids
from sim_bridge.glass import Glass
from sim_bridge.simulation import Simulation
from sim_bridge.snapshot import Snapshot, snapshot
from sim_bridge.solids import solids_of
from sim_bridge.world import RobotPlacement, Wall, World

INK, DIRT, THROUGH, MIRROR = "#6b7480", "#8a5cc2", "#1a7f4b", "#e0641a"
_SCANS = 40
_PANE_X, _BACK_X = 1.6, 2.6


def write_laser(path: Path, folder: Path, seed: int) -> None:
    """Draw scans before a pane with a wall behind it, and shares of beams by angle."""
    import matplotlib.pyplot as plt

    figure, (scene, curves) = plt.subplots(1, 2, figsize=(11.5, 4.4), layout="constrained")
    _draw_scans(scene, seed)
    values, _ = glass_by_angle(argparse.Namespace(seed=seed, scans=_SCANS, out_dir=folder))
    rows = values["by_angle"]
    angles = np.array([row["from_deg"] + BIN_DEG / 2.0 for row in rows])
    for name, text, color in (
        ("through", "what is behind", THROUGH),
        ("mirror", "the pane, as a mirror", MIRROR),
        ("dirt", "dirt: a point behind the pane", DIRT),
        ("lost", "nothing: lost", INK),
    ):
        curves.plot(angles, [row[f"promised_{name}"] for row in rows], color=color, lw=1.4)
        curves.plot(angles, [row[name] for row in rows], "o", color=color, ms=4, label=text)
    curves.set(xlabel="angle of incidence [deg]", ylabel="share of beams", ylim=(-0.02, 1.02))
    curves.set_title("what a beam measures; dots: simulated, lines: from the settings", fontsize=10)
    curves.grid(alpha=0.25)
    curves.legend(frameon=False)
    save(path, figure)


def write_sonar(path: Path, folder: Path, seed: int) -> None:
    """Draw one round of sixteen sonars in a corner of glass, and shares of echoes by angle."""
    import matplotlib.pyplot as plt

    figure, (scene, curves) = plt.subplots(1, 2, figsize=(11.5, 4.6), layout="constrained")
    _draw_round(scene, seed)
    values, _ = sonar_by_angle(argparse.Namespace(seed=seed, out_dir=folder))
    for name, text, color in (("wall", "plain wall", INK), ("glass", "glass", GLASS)):
        angles = np.array([row["angle_deg"] for row in values[name]])
        shares = [row["answered"] for row in values[name]]
        promised = [row["promised"] for row in values[name]]
        curves.plot(angles, promised, color=color, lw=1.4)
        curves.plot(angles, shares, "o" if name == "wall" else "x", color=color, ms=6, label=text)
    curves.set(xlabel="angle between the sonar's axis and the wall's normal [deg]")
    curves.set(ylabel="share of firings with an echo", ylim=(-0.02, 1.05))
    curves.set_title("one long wall; marks: simulated, lines: from the settings", fontsize=10)
    curves.grid(alpha=0.25)
    curves.legend(frameon=False)
    save(path, figure)


def _draw_scans(axes: Any, seed: int) -> None:
    """Draw what each beam of some scans measured, by what it met."""
    glass = Glass()
    pane = Wall(from_m=(_PANE_X, -2.2), to_m=(_PANE_X, 2.2), glass=glass)
    back = Wall(from_m=(_BACK_X + 0.06, -2.2), to_m=(_BACK_X + 0.06, 2.2))
    robot = RobotPlacement(model="segway_rmp50", position_m=(0.0, 0.0), overrides={"sonar": None})
    world = World(name="pane", walls=(pane, back), robots=(robot,))
    simulation, points = Simulation(world, seed=seed), []
    model = simulation.models[""]
    assert model.config.laser is not None
    mount = Transform3(model.mounts[model.config.laser.frame]).to_se2()
    while len(points) < _SCANS:
        scan = simulation.step({}).robots[""].scan
        if scan is not None:
            points.append(mount @ scan.points())
    simulation.close()
    found = np.vstack(points)
    draw_solids(axes, solids_of(world))
    far = np.abs(found[:, 0] - _BACK_X) < 0.06
    near = np.abs(found[:, 0] - _PANE_X) < 0.06
    for chosen, color, text in (
        (far, THROUGH, "the wall behind,\nthrough the glass"),
        (near, MIRROR, "the pane: as a mirror\nnear the normal; dirt"),
        (~(far | near), DIRT, "between: dirt,\nmeasured too far"),
    ):
        axes.plot(*found[chosen].T, ".", color=color, ms=2.5, label=text)
    seen = Snapshot(model, simulation.starts[""], None, ())
    draw_robot(axes, seen, color=ROBOT, width=1.6)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", xlim=(-0.7, 2.9), ylim=(-2.1, 2.1))
    axes.set_title(f"{_SCANS} scans before a pane (blue), a wall behind it", fontsize=10)
    axes.legend(
        frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 0.7), markerscale=3.0
    )


def _draw_round(axes: Any, seed: int) -> None:
    """Draw the cone of each sonar to its echo; those too long, and the silent ones, otherwise."""
    panes = (((2.0, -2.6), (2.0, 1.7)), ((2.0, 1.7), (-3.4, 1.7)))
    walls = [Wall(from_m=a, to_m=b, glass=Glass()) for a, b in panes]
    robot = RobotPlacement(model="segway_rmp50", position_m=(0.0, 0.0), yaw_deg=0.0)
    world = World(name="corner", walls=tuple(walls), robots=(robot,))
    seen = snapshot(world, robot.pose, seed)
    draw_solids(axes, solids_of(world))
    labels = {"an echo from the glass", "a longer echo, by way of a mirror or a corner", "no echo"}
    for frame, reading in zip(seen.model.config.sonar_frames, seen.sonar, strict=True):
        T = Transform3(seen.model.mounts[frame]).to_se2()
        angles = np.linspace(-0.5, 0.5, 13) * reading.field_of_view
        arc = np.column_stack((np.cos(angles), np.sin(angles)))
        if not reading.is_hit:
            name = "no echo"
            ends = T @ np.array([[0.0, 0.0], [0.7, 0.0]])
            axes.plot(*ends.T, color=INK, lw=1.2, ls=":", label=name if name in labels else None)
        else:
            reached = T @ (reading.range * arc)
            is_longer = bool((reached[6] > (2.1, 1.8)).any())
            name = "a longer echo, by way of a mirror or a corner" if is_longer else (
                "an echo from the glass")  # fmt: skip
            color, corners = (
                (LASER if is_longer else SONAR),
                np.vstack((T @ np.zeros((1, 2)), reached)),
            )
            axes.fill(*corners.T, color=color, alpha=0.15, lw=0.0)
            axes.plot(*reached.T, color=color, lw=1.8, label=name if name in labels else None)
        labels.discard(name)
    draw_robot(axes, seen, color=ROBOT, width=1.6)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", xlim=(-3.5, 3.6), ylim=(-2.7, 3.0))
    axes.set_title("one round of 16 sonars in a corner of glass (blue)", fontsize=10)
    axes.legend(frameon=True, fontsize=8, loc="lower left")
