"""Stereo matching by interval DP, monotone DP and ours, beside OpenCV's StereoBM and StereoSGBM.

`--pair LEFT RIGHT --gt FILE --scale S` takes one real pair with its true disparities: shares of bad
pixels among all whose truth is known, a pixel without a value being bad. StereoSGBM stands there
twice: with the settings that OpenCV advises, and tuned on that very pair.
"""

from __future__ import annotations

import argparse
from typing import Any

import cv2
import numpy as np

from experiments.stereo_pairs import Pair, judge_all, read_pair
from floornav_common.reporting import Picture, Section, Table, UserError, say

Values = dict[str, Any]
_MEASURES = ("bad1", "bad2", "mean_px", "valid", "bad1_valid", "bad1_filled", "bad2_filled")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--pair", nargs=2, metavar=("LEFT", "RIGHT"), help="one real pair of rectified images"
    )
    parser.add_argument("--gt", metavar="FILE", help="true disparities of LEFT, gray, 0 = unknown")
    parser.add_argument(
        "--scale", type=float, metavar="S", help="what a disparity of 1 px is in FILE"
    )
    parser.add_argument(
        "--disparities", type=int, default=64, metavar="N",
        help="disparities searched, a multiple of 16 (default: 64)",
    )  # fmt: skip


def check(args: argparse.Namespace) -> None:
    """Refuse bad options; read the pair."""
    given = [o is not None for o in (args.pair, args.gt, args.scale)]
    if not all(given):
        raise UserError("--pair, --gt and --scale belong together")
    if args.scale <= 0.0:
        raise UserError(f"--scale must be above 0, got {args.scale}")
    if args.disparities % 16 != 0 or not 16 <= args.disparities <= 256:
        raise UserError(f"--disparities must be a multiple of 16 to 256, got {args.disparities}")
    args.images = read_pair(*args.pair, args.gt, args.scale)


def run(args: argparse.Namespace, values: Values) -> list[Section]:
    """Match, judge, draw."""
    values.update(pairs={}, disparities=args.disparities)
    return [_real_pair(args, values)]


def _real_pair(args: argparse.Namespace, values: Values) -> Section:
    rows, pictures = [], []
    for name, measures, found in judge_all(args.images, args.disparities):
        say(f"{name} done", is_quiet=args.quiet)
        values["pairs"][name] = measures
        rows.append([name, *(_number(measures[m]) for m in _MEASURES)])
        path = args.out_dir / f"{name}.png"
        cv2.imwrite(str(path), picture_of(found, args.images, args.disparities))
        pictures.append(Picture(path, f"{name}: disparities; black = none"))
    return Section("real pair", [Table(["method", *_MEASURES], rows), *pictures])


def picture_of(found: np.ndarray, pair: Pair, num_disparities: int) -> np.ndarray:
    """Return disparities in colors, BGR; those without a value are black."""
    top = min(float(np.nanmax(pair.truth)) + 1.0, float(num_disparities))
    gray = np.clip(np.nan_to_num(found) * 255.0 / top, 0, 255).astype(np.uint8)
    colors = cv2.applyColorMap(gray, cv2.COLORMAP_TURBO)
    colors[np.isnan(found)] = 0
    return colors


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
