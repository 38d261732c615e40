"""The pose in a voxel map by two stereo pairs at random places, beside the stereo paper's Table 3.

Map: the simulator's world, or views of it, through make_voxel_map. Images: rendered with the
sensors' noise. Each place is found on its own, without a guess, by the published search with
distances from interval DP and from monotone DP and by color alone, and by ours with distances from
our matcher and with true ones; `published_true` is the published search with true ones. Then a
drive is followed.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

from experiments.stereo_drive import LOST_M, drive_values, follow
from experiments.stereo_localization_judge import (
    METHODS,
    judge_place,
    look_alike_values,
    summarized,
)
from experiments.stereo_localization_pictures import draw_drive, draw_places, draw_views
from experiments.stereo_look_alike import FAR_M, LookAlikes
from experiments.stereo_map_views import map_of_views
from experiments.stereo_places import Observer
from experiments.stereo_views import WORLD, StereoRoom
from experiments.stereo_world_map import map_of_world
from floornav_common.arguments import count, not_negative
from floornav_common.reporting import Picture, Progress, Section, Table, UserError
from multi_localizer.stereo_localizer import StereoLocalizer
from multi_localizer.stereo_localizer_config import StereoLocalizerConfig
from multi_localizer.voxel_map import VoxelMap, load_voxel_map, save_voxel_map
from multi_localizer.voxel_view import VoxelScene

Values = dict[str, Any]
PAPER = {
    "interval_dp": (80.0, 9.78, 6.90, 7.76),
    "monotone_dp": (64.7, 11.9, 7.32, 8.9),
    "color_only": (22.0, 18.8, 15.8, 8.1),
}
_MEASURES = ("within_8cm", "mean_x_cm", "mean_y_cm", "mean_theta_deg")
_MORE = (
    "median_cm",
    "median_theta_deg",
    "over_1m",
    "known",
    "known_within_8cm",
    "mean_nees",
    "median_ms",
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    add = parser.add_argument
    add("--places", type=count, metavar="N", help="random places (default: 150; 10 with --quick)")
    add("--drive", type=not_negative, metavar="M", help="length of the drive (default: 50; 3 with "
        "--quick)")  # fmt: skip
    add("--map", type=Path, metavar="NPZ", help="another map of the room, by make_voxel_map")
    text = "made from the world's solids, or stereo or RGB-D views of 60 places (default: world)"
    add("--map-from", choices=("world", "stereo", "rgbd"), default="world", help=text)
    add("--threads", type=count, default=2, metavar="N", help="of the search (default: 2)")
    add("--quick", action="store_true", help="few places, a short drive")


def check(args: argparse.Namespace) -> None:
    """Refuse bad options; read the map."""
    args.places = (10 if args.quick else 150) if args.places is None else args.places
    args.drive = (3.0 if args.quick else 50.0) if args.drive is None else args.drive
    try:
        args.voxels = None if args.map is None else load_voxel_map(args.map)
    except (OSError, ValueError) as error:
        raise UserError(str(error)) from error


def run(args: argparse.Namespace, values: Values) -> list[Section]:
    """Make the map, locate, follow, draw."""
    values.update(
        methods=None, tracking=None, look_alike=None, paper=PAPER, cameras=None, map=None,
        places=[], num_places=None,
    )  # fmt: skip
    room = StereoRoom(args.seed)
    observer = Observer(room)
    voxels = _voxels(args, values, room)
    values["cameras"] = {
        "baseline_m": room.baseline_m, "fov_rad": room.fov_rad, "focal_px": room.focal_px,
        "height_m": observer.cameras[0].height_m, "size_px": list(room.size_px), "disparities": 64,
    }  # fmt: skip
    localizers = {
        kind: StereoLocalizer(
            voxels, observer.cameras, StereoLocalizerConfig(method=kind), args.threads
        )
        for kind in dict.fromkeys(kind for _, kind in METHODS.values())
    }
    alike = LookAlikes(VoxelScene(voxels, args.threads), observer.cameras)
    pictures = _locate_all(args, values, room, observer, localizers, alike)
    pictures.append(draw_places(args.out_dir / "places.png", voxels, values["places"]))
    sections = [
        Section("random places, no guess", [_text(values), _table(values), *pictures]),
        Section("places that look alike", [_alike_text(values)]),
    ]
    if args.drive > 0.0:
        sections.append(_drive(args, values, observer, localizers["ours"], voxels))
    return sections


def _voxels(args: argparse.Namespace, values: Values, room: StereoRoom) -> VoxelMap:
    voxels: VoxelMap | None = args.voxels
    if voxels is None:
        path = args.out_dir / "map.npz"
        if args.map_from == "world":
            save_voxel_map(path, map_of_world(WORLD))
        else:
            views = args.out_dir / "views"
            map_of_views(views, path, room, args.map_from == "stereo", args.seed)
        voxels = load_voxel_map(path)
    layers, rows, columns = voxels.shape
    values["map"] = {
        "layers": layers, "rows": rows, "columns": columns, "cell_m": voxels.cell_m,
        "layer_m": voxels.layer_m, "from": args.map_from if args.map is None else str(args.map),
    }  # fmt: skip
    return voxels


def _locate_all(
    args: argparse.Namespace, values: Values, room: StereoRoom, observer: Observer,
    localizers: dict[str, StereoLocalizer], alike: LookAlikes,
) -> list[Picture]:  # fmt: skip
    rng = np.random.default_rng(args.seed)
    pictures: list[Picture] = []
    with Progress("places", args.places, is_quiet=args.quiet) as progress:
        for k in range(args.places):
            place = observer.look(room.standing_pose(rng), k)
            row = judge_place(place, localizers, alike)
            values["places"].append(row)
            if k < 2:
                path = args.out_dir / f"view_{k}.png"
                pictures.append(draw_views(path, place, observer, alike.scene))
            values["methods"] = {name: summarized(values["places"], name) for name in METHODS}
            values["look_alike"] = look_alike_values(values["places"])
            values["num_places"] = k + 1
            progress.update(k + 1, f"ours {values['methods']['ours']['within_8cm']:.0f} % in 8 cm")
    return pictures


def _text(values: Values) -> str:
    c, m = values["cameras"], values["map"]
    return (
        f"{values['num_places']} places of the stereo room; map {m['columns']} x {m['rows']} x "
        f"{m['layers']} voxels, made from {m['from']}; two pairs {c['height_m']:.2f} m above the "
        f"floor, {c['baseline_m']:.2f} m apart, {math.degrees(c['fov_rad']):.0f} degrees, "
        f"{c['disparities']} disparities. Percentage within 8 cm, mean errors in x, y (cm) and "
        "heading (degrees); beside them the paper's. Known: percentage at which the method itself "
        "says that the pose is known; nees: squared errors over its own covariance, mean where it "
        "is known, 3 if that is right. published_true is the published search with true distances."
    )


def _table(values: Values) -> Table:
    rows = []
    for name, measures in values["methods"].items():
        paper = PAPER.get(name, (None,) * 4)
        rows.append([name, *(_number(measures[k]) for k in (*_MEASURES, *_MORE)),
                     *(_number(p) for p in paper)])  # fmt: skip
    papers = ("paper %", "paper x", "paper y", "paper deg")
    head = ("within 8 cm %", "x cm", "y cm", "deg", "median cm", "median deg", "over 1 m %",
            "known %", "known: within %", "nees", "ms")  # fmt: skip
    return Table(["method", *head, *papers], rows)


def _alike_text(values: Values) -> str:
    alike = values["look_alike"]
    return (
        f"Eq. 1 at the very place is {alike['mean_score']:.4f} on average and varies by "
        f"{alike['noise']:.4f} (its noise). At {alike['share']:.1f} % of the places another one "
        f"farther than {FAR_M:g} m shows a view whose eq. 1 against this one's is less than that; "
        f"at {alike['share_below_mean_score']:.1f} % it is less than the average."
    )


def _drive(
    args: argparse.Namespace, values: Values, observer: Observer, localizer: StereoLocalizer,
    voxels: VoxelMap,
) -> Section:  # fmt: skip
    with Progress("drive", None, is_quiet=args.quiet) as progress:
        steps = follow(
            observer, localizer, args.drive, args.seed, lambda done, _: progress.update(done)
        )
    tracking = values["tracking"] = drive_values(steps)
    path = args.out_dir / "drive.png"
    picture = draw_drive(path, voxels, steps)
    text = (
        f"{tracking['length_m']:.1f} m with an image pair of each side every 0.1 s, started "
        f"without a guess: {tracking['lost_steps']} of {tracking['steps']} steps lost, "
        f"{tracking['far_off_steps']} more than {LOST_M:g} m off; error {tracking['median_cm']:.1f}"
        f" cm in the median, {tracking['max_cm']:.1f} cm at most; {tracking['median_ms']:.0f} ms a "
        f"step (99 %: {tracking['p99_ms']:.0f} ms), {tracking['first_ms']:.0f} ms for the first."
    )
    return Section("drive", [text, picture])


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}" if abs(value) < 100.0 else f"{value:.0f}"
