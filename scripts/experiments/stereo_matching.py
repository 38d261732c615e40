"""Stereo matching by interval DP, monotone DP and ours, beside OpenCV's StereoBM and StereoSGBM.

Rendered pairs of the stereo room from random poses: errors of distance as in the stereo paper's
Table 1. `--pair LEFT RIGHT --gt FILE --scale S` takes one real pair with its true disparities in
their place: shares of bad pixels among all whose truth is known, a pixel without a value being bad.
Shares stand there as found, and with the holes of every method filled by one rule. StereoSGBM has
the settings that OpenCV advises, and those that are best on that very pair for each of the two.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from experiments.stereo_measures import PAPER, DepthErrors, depth_of
from experiments.stereo_pairs import judge_all, matchers, one_row_matchers, read_pair
from experiments.stereo_views import StereoRoom, View
from floornav_common.arguments import count, positive
from floornav_common.reporting import Picture, Progress, Section, Table, UserError, say
from multi_localizer.stereo_config import METHODS

Values = dict[str, Any]
_MEASURES = ("bad1", "bad2", "mean_px", "valid", "bad1_valid", "bad1_filled", "bad2_filled")
_PAIR_TEXT = (
    "Percentages of all pixels whose truth is known, off by more than 1 and 2 px. bad1, bad2: as "
    "found, a pixel without a value is bad. bad1_filled, bad2_filled, mean_px: holes filled from "
    "the farther neighbor, for every method alike. ours fills them itself; ours_with_holes is what "
    "stereo_matcher sends. sgbm_tuned is StereoSGBM with those settings of a grid that are best on "
    "this very pair as found, sgbm_tuned_filled with those that are best when filled."
)
_ERRORS = ("mean_cm", "changing_cm", "smooth_cm")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--views", type=count, default=300, metavar="N", help="rendered pairs (default: 300)"
    )
    parser.add_argument(
        "--pair", nargs=2, metavar=("LEFT", "RIGHT"), help="one real pair of rectified images"
    )
    parser.add_argument("--gt", metavar="FILE", help="true disparities of LEFT, gray, 0 = unknown")
    parser.add_argument(
        "--scale", type=positive, metavar="S", help="what a disparity of 1 px is in FILE"
    )
    parser.add_argument(
        "--disparities", type=count, default=64, metavar="N",
        help="disparities searched, a multiple of 16 (default: 64)",
    )  # fmt: skip


def check(args: argparse.Namespace) -> None:
    """Refuse bad options; read the pair."""
    if args.disparities % 16 != 0 or not 16 <= args.disparities <= 256:
        raise UserError(f"--disparities must be a multiple of 16 to 256, got {args.disparities}")
    given = [o is not None for o in (args.pair, args.gt, args.scale)]
    if any(given) and not all(given):
        raise UserError("--pair, --gt and --scale belong together")
    if args.pair is not None:
        args.images = read_pair(*args.pair, args.gt, args.scale)


def run(args: argparse.Namespace, values: Values) -> list[Section]:
    """Match, judge, draw."""
    values.update(
        methods=None, pairs=None, disparities=args.disparities, paper=PAPER, cameras=None,
        num_views=None, changing_share=None,
    )  # fmt: skip
    return [_rendered(args, values) if args.pair is None else _real_pair(args, values)]


def _rendered(args: argparse.Namespace, values: Values) -> Section:
    room = StereoRoom(args.seed)
    values["cameras"] = {
        "baseline_m": room.baseline_m, "fov_rad": room.fov_rad, "focal_px": room.focal_px,
        "farthest_m": room.farthest_m,
    }  # fmt: skip
    methods = {**matchers(args.disparities), **one_row_matchers(args.disparities)}
    errors = {name: DepthErrors() for name in methods}
    pictures: list[Picture] = []
    with Progress("rendered pairs", args.views, is_quiet=args.quiet) as progress:
        for k, view in enumerate(room.views(args.views, np.random.default_rng(args.seed))):
            found = {name: match(view.left, view.right) for name, match in methods.items()}
            depths = {
                name: depth_of(d, room.focal_px, room.baseline_m, room.farthest_m)
                for name, d in found.items()
            }
            for name, error in errors.items():
                error.add(found[name], depths[name], view.depth)
            if k < 2:
                shown = {name: depths[name] for name in METHODS}
                pictures.append(_draw_view(args.out_dir / f"view_{k}.png", view, shown))
            values["methods"] = {name: error.as_dict() for name, error in errors.items()}
            values["num_views"] = k + 1
            progress.update(k + 1)
    values["changing_share"] = errors["ours"].changing_share
    return Section("rendered pairs", [_text(values), _errors_table(values), *pictures])


def _text(values: Values) -> str:
    cameras = values["cameras"]
    return (
        f"{values['num_views']} pairs of the stereo room, cameras {cameras['baseline_m']:.2f} m "
        f"apart with {np.degrees(cameras['fov_rad']):.0f} degrees, {values['disparities']} "
        f"disparities. Mean error of distance, cm, over all pixels, over those where the distance "
        f"changes by 32 cm or more within 8 px ({values['changing_share']:.1f} %), and over the "
        "others; holes filled from the farther neighbor. Valid: percentage before they were filled."
    )


def _errors_table(values: Values) -> Table:
    rows = []
    for name, measures in values["methods"].items():
        paper = PAPER.get(name)
        published = [_number(paper[e]) if paper else "-" for e in _ERRORS]
        rows.append([name, *(_number(measures[e]) for e in (*_ERRORS, "valid")), *published])
    header = ["method", "all cm", "changing cm", "smooth cm", "valid %"]
    return Table([*header, "paper all", "paper changing", "paper smooth"], rows)


def _draw_view(path: Path, view: View, depths: dict[str, np.ndarray]) -> Picture:
    """Draw the left image, the true distances, and those of every method."""
    top = float(view.depth.max())
    tiles = [cv2.cvtColor(view.left, cv2.COLOR_RGB2BGR), _colored(view.depth, top)]
    tiles += [_colored(depth, top) for depth in depths.values()]
    cv2.imwrite(str(path), np.hstack(tiles))
    return Picture(path, "left image, true distance, " + ", ".join(depths))


def _real_pair(args: argparse.Namespace, values: Values) -> Section:
    rows, pictures = [], []
    values["pairs"] = {}
    top = min(float(np.nanmax(args.images.truth)) + 1.0, float(args.disparities))
    for name, measures, found in judge_all(args.images, args.disparities):
        say(f"{name} done", is_quiet=args.quiet)
        values["pairs"][name] = measures
        rows.append([name, *(_number(measures[m]) for m in _MEASURES)])
        path = args.out_dir / f"{name}.png"
        cv2.imwrite(str(path), _colored(found, top))
        pictures.append(Picture(path, f"{name}: disparities; black = none"))
    return Section("real pair", [_PAIR_TEXT, Table(["method", *_MEASURES], rows), *pictures])


def _colored(values: np.ndarray, top: float) -> np.ndarray:
    """Return values from 0 to `top` in colors, BGR; those that are none are black."""
    gray = np.clip(np.nan_to_num(values) * 255.0 / top, 0, 255).astype(np.uint8)
    colors = cv2.applyColorMap(gray, cv2.COLORMAP_TURBO)
    colors[np.isnan(values)] = 0
    return colors


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
