"""Free space beside the simulator's truth, over templates and image sizes.

For each direction: the error of its range; a phantom is a range shorter than the truth by more than
one cell and 5 cm. The truth of a direction is the nearest footprint anywhere in its sector. A cube
that the camera can see is missed if every direction through its central half has a range beyond its
near face by more than one cell and 5 cm, `inf` among them. Elsewhere `inf` is the horizon.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np

from experiments.floor_scenes import CubeView, Scene, Truth, scenes, truth_of
from floor_perception.config import FloorDetectorConfig, TemplateConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.free_space import floor_areas, free_ranges, free_ratios
from floor_perception.overlay import overlay
from floor_perception.polar_template import PolarTemplate, make_template
from floor_perception.resources import load_camera_model
from floornav_common.arguments import count
from floornav_common.floor_camera import FloorCamera
from floornav_common.reporting import Figures, Picture, Progress, Section, Table
from floornav_common.scan import Scan

SIZES = ((256, 220), (640, 480))
RADII_PX = (95, 100, 105, 110)  # at 256 x 220
PAPER_RADIUS_PX = 105
SLACK_M = 0.05
NEAR_M = 1.0
FRAME_NS = 400_000_000
NUM_FADING = 25  # pictures while one light fades into another, 10 s
_NUM_PICTURES = 6
Row = list[Any]


@dataclass
class Tally:
    """What one template did at one image size."""

    config: TemplateConfig
    template: PolarTemplate
    errors: list[np.ndarray] = field(default_factory=list)
    num_phantoms: int = 0
    num_directions: int = 0
    num_unseen: int = 0
    cubes: dict[bool, list[bool]] = field(default_factory=lambda: {True: [], False: []})

    def add(self, truth: Truth, mask: np.ndarray) -> np.ndarray:
        """Judge one scene; returns the ranges as they are."""
        t = self.template
        ranges = free_ranges(free_ratios(floor_areas(mask, t), t), self.config.free_share, t.edges)
        nearest = np.minimum(truth.ranges[t.num_directions], t.edges[-1])
        said = as_distance(ranges, t.edges)
        is_seen = ~np.isnan(said)
        self.num_unseen += int((~is_seen).sum())
        self.num_directions += len(said)
        is_phantom = said < nearest - cell_at(nearest, t.edges) - SLACK_M
        self.num_phantoms += int(is_phantom.sum())
        is_inside = is_seen & (nearest < t.edges[-1])
        self.errors.append((said - nearest)[is_inside])
        for cube in truth.cubes:
            if cube.near < t.edges[-1]:
                self.cubes[cube.near <= NEAR_M].append(is_missed(cube, ranges, t))
        return ranges

    def summary(self) -> dict[str, Any]:
        """Return the figures."""
        errors = np.concatenate(self.errors) if self.errors else np.zeros(0)
        return {
            "missed_within_1m": sum(self.cubes[True]),
            "cubes_within_1m": len(self.cubes[True]),
            "missed_beyond_1m": sum(self.cubes[False]),
            "cubes_beyond_1m": len(self.cubes[False]),
            "phantom_share": self.num_phantoms / max(self.num_directions, 1),
            "unseen_share": self.num_unseen / max(self.num_directions, 1),
            "range_error_median_m": float(np.median(np.abs(errors))) if len(errors) else None,
            "range_bias_median_m": float(np.median(errors)) if len(errors) else None,
        }


def as_distance(ranges: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return what ranges say at most, m: the horizon for inf, the first ring for -inf."""
    return np.clip(ranges, edges[0], edges[-1])


def cell_at(distance: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the length of the cell that a distance lies in, m."""
    i = np.clip(np.searchsorted(edges, distance, side="right") - 1, 0, len(edges) - 2)
    return np.asarray(np.diff(edges)[i])


def is_missed(cube: CubeView, ranges: np.ndarray, template: PolarTemplate) -> bool:
    """Return whether all directions through a cube's central half say that it is not there."""
    j = np.round((cube.bearings + math.pi) / template.angle_increment).astype(int)
    j %= template.num_directions
    limit = cube.faces + cell_at(cube.faces, template.edges) + SLACK_M
    is_beyond = ~(ranges[j] <= limit)  # inf is beyond, and not seen is no detection either
    return bool(all(is_beyond[j == k].all() for k in np.unique(j)))


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--scenes", type=count, default=500, metavar="N", help="scenes at each size (default: 500)"
    )


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Judge every template over the scenes of both sizes."""
    values.update(dict.fromkeys(
        ("missed_within_1m", "phantom_share", "range_error_median_m", "scenes", "paper", "rows")
    ))  # fmt: skip
    camera = load_camera_model("soccer_small_size")
    results: dict[str, dict[str, Any]] = {}
    pictures: list[Picture] = []
    for size in SIZES:
        resized = camera.resized(*size)
        tallies = _tallies(resized, camera)
        pictures += _judge(resized, camera, tallies, args, size)
        for name, tally in tallies.items():
            results[f"{size[0]}x{size[1]} {name}"] = tally.summary()
    values["rows"], values["scenes"] = results, args.scenes
    values.update(_both(results, "default"))
    values["paper"] = {**_both(results, _name(6, 32, PAPER_RADIUS_PX)), "scenes": args.scenes}
    table = Table(_HEADER, [_row(name, figures) for name, figures in results.items()])
    return [
        Section("Free space", [_figures(values), table]),
        Section("Scenes", [*pictures]),
    ]


def _judge(
    camera: FloorCamera,
    calibrated: FloorCamera,
    tallies: dict[str, Tally],
    args: argparse.Namespace,
    size: tuple[int, int],
) -> list[Picture]:
    detector = FloorDetector(calibrated, FloorDetectorConfig())
    drawn = []
    with Progress(f"{size[0]} x {size[1]}", args.scenes, is_quiet=args.quiet) as progress:
        for k, scene in enumerate(scenes(size, args.scenes, args.seed)):
            mask = mask_of(detector, scene)
            truth = truth_of(scene, {tally.config.num_directions for tally in tallies.values()})
            ranges = {name: tally.add(truth, mask) for name, tally in tallies.items()}["default"]
            if k % 7 == 0 and len(drawn) < _NUM_PICTURES:
                drawn.append(_drawn(scene, mask, ranges, tallies["default"].template, camera))
            progress.update(k + 1)
    path = args.out_dir / f"scenes_{size[0]}x{size[1]}.png"
    rows = [np.hstack(drawn[i : i + 3]) for i in range(0, len(drawn) // 3 * 3, 3)]
    if not rows:
        rows = [np.hstack(drawn)]
    cv2.imwrite(str(path), np.vstack(rows))
    return [Picture(path, f"{size[0]} x {size[1]}: floor green, end of the free space red")]


def mask_of(detector: FloorDetector, scene: Scene) -> np.ndarray:
    """Return the mask of a scene: color learned from the first robot, then the light changes.

    Light adds up, so a lamp that fades into another gives a mixture of both pictures.
    """
    detector.reset()
    detector.detect(scene.learned_from, "rgb", 0)
    num = 0 if scene.before is None else NUM_FADING
    for k in range(1, num):
        mixed = cv2.addWeighted(scene.picture, k / num, scene.before, 1.0 - k / num, 0.0)
        detector.track(mixed, "rgb", k * FRAME_NS)
    result = detector.detect(scene.picture, "rgb", (num + 1) * FRAME_NS)
    if result is None:
        return np.zeros(scene.picture.shape[:2], dtype=np.uint8)
    return result.mask


def _tallies(camera: FloorCamera, calibrated: FloorCamera) -> dict[str, Tally]:
    configs = {"default": TemplateConfig()}
    for I, J in ((6, 32), (6, 180), (24, 32), (24, 180)):  # noqa: E741
        for radius in RADII_PX:
            horizon = 0.999 * float(calibrated.floor_distance(radius))
            configs[_name(I, J, radius)] = replace(
                TemplateConfig(), num_rings=I, num_directions=J, horizon_m=horizon,
                spacing="image", free_share=0.8,
            )  # fmt: skip
    return {name: Tally(c, make_template(camera, c)) for name, c in configs.items()}


def _name(num_rings: int, num_directions: int, radius_px: int) -> str:
    return f"{num_rings} x {num_directions} to {radius_px} px"


def _both(results: dict[str, dict[str, Any]], name: str) -> dict[str, Any]:
    """Return a template's figures over both sizes: all cubes missed, the worse share and error."""
    of = [results[f"{w}x{h} {name}"] for w, h in SIZES]
    return {
        "missed_within_1m": sum(f["missed_within_1m"] for f in of),
        "cubes_within_1m": sum(f["cubes_within_1m"] for f in of),
        "phantom_share": max(f["phantom_share"] for f in of),
        "range_error_median_m": max(f["range_error_median_m"] for f in of),
    }


_HEADER = [
    "size, template", "missed to 1 m", "of", "beyond", "of", "phantoms %", "not seen %",
    "|error| median m", "bias m",
]  # fmt: skip


def _row(name: str, f: dict[str, Any]) -> Row:
    return [
        name, f["missed_within_1m"], f["cubes_within_1m"], f["missed_beyond_1m"],
        f["cubes_beyond_1m"], round(100.0 * f["phantom_share"], 3),
        round(100.0 * f["unseen_share"], 3), round(f["range_error_median_m"], 3),
        round(f["range_bias_median_m"], 3),
    ]  # fmt: skip


def _figures(values: dict[str, Any]) -> Figures:
    is_good = values["missed_within_1m"] == 0, values["phantom_share"] < 0.005
    marks = ["good" if good else "bad" for good in is_good]
    of = values["cubes_within_1m"]
    return Figures([
        ("cubes missed within 1 m", f"{values['missed_within_1m']} of {of}", marks[0]),
        ("phantom directions", f"{100.0 * values['phantom_share']:.2f} %", marks[1]),
        ("median range error", f"{values['range_error_median_m']:.3f} m"),
        ("scenes at each size", str(values["scenes"])),
    ])  # fmt: skip


def _drawn(
    scene: Scene, mask: np.ndarray, ranges: np.ndarray, template: PolarTemplate, camera: FloorCamera
) -> np.ndarray:
    scan = Scan(
        ranges, float(template.bearings[0]), template.angle_increment, float(template.edges[0]),
        float(template.edges[-1]),
    )  # fmt: skip
    bgr = np.ascontiguousarray(scene.picture[..., ::-1])
    return cv2.resize(
        overlay(bgr, mask, scan, camera), (384, 330 if camera.width_px == 256 else 288)
    )
