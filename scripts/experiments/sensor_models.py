"""What the simulated sensors do, measured from their readings, beside what their settings promise.

Laser: noise, bias and lost beams before plain walls; through a pane, by angle of incidence, the
shares of beams that pass, come back from the pane, from dirt behind it, or not at all. Sonars: by
angle to a plain wall and to a glass one, how often they answer and how far off. Odometry: drift on
a straight way. Cameras: where `sensor_models_cameras` measures them. Ground truth is used to know
what should have been measured.
"""

from __future__ import annotations

import argparse
import importlib.util
from typing import Any

from experiments.sensor_models_glass import glass_by_angle
from experiments.sensor_models_laser import laser_noise
from experiments.sensor_models_odometry import odometry_drift
from experiments.sensor_models_sonar import sonar_by_angle
from floornav_common.arguments import count
from floornav_common.reporting import Picture, Progress, Section, Table

_CAMERAS = "experiments.sensor_models_cameras"
_STEPS = (
    ("laser noise", "laser", laser_noise),
    ("glass", "glass", glass_by_angle),
    ("sonar", "sonar", sonar_by_angle),
    ("odometry", "odometry", odometry_drift),
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--scans", type=count, default=200, metavar="N", help="per place (200)")
    parser.add_argument("--runs", type=count, default=40, metavar="N", help="odometry runs (40)")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Measure every sensor; fills a key of `values` each, with measured beside promised."""
    values.update({key: None for _, key, _ in _STEPS}, cameras=None)
    sections = []
    with Progress("sensor-models", len(_STEPS) + 1, is_quiet=args.quiet) as progress:
        for k, (name, key, measure) in enumerate(_STEPS):
            progress.update(k, name)
            values[key], section = measure(args)
            sections.append(section)
        if importlib.util.find_spec(_CAMERAS) is not None:
            progress.update(len(_STEPS), "cameras")
            values["cameras"], section = _cameras(args)
            sections.append(section)
        progress.update(len(_STEPS) + 1, "done")
    cameras = values["cameras"] or []
    values["promises_kept"] = all(
        (*(values[key]["kept"] for _, key, _ in _STEPS), *(row["kept"] for row in cameras))
    )
    return sections


def _cameras(args: argparse.Namespace) -> tuple[list[dict[str, Any]], Section]:
    from matplotlib.image import imsave

    module = importlib.import_module(_CAMERAS)
    rows, pictures = module.run(args.seed)
    keys = module.HEADER
    text = (
        "Images beside their models: radii of rings on the floor beside eq. 26, noise and "
        "brightness beside the settings, the shift of a wall between two cameras."
    )
    shown = [[*row[:-1], "yes" if row[-1] else "NO"] for row in rows]
    blocks: list[str | Table | Picture] = [text, Table(list(keys), shown)]
    for name, pixels in pictures.items():
        imsave(args.out_dir / f"{name}.png", pixels)
        blocks.append(Picture(args.out_dir / f"{name}.png", name))
    return [dict(zip(keys, row, strict=True)) for row in rows], Section("Cameras", list(blocks))
