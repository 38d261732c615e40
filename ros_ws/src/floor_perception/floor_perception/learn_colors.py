"""Learn the floor's color from pictures and write the file that `color.file` names.

Taken is a ring on the floor around the robot, as `floor_detector` does it, of all pictures
together; with `--box` a rectangle of each picture that shows floor, and then no camera is needed.
Exit code 0: written, 1: no color prevails, 2: bad input.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np

from floor_perception.color_files import save_color
from floor_perception.color_model import FloorColor, has_color, learn
from floor_perception.config import FloorDetectorConfig
from floor_perception.first_color import learn_first
from floor_perception.floor_detector import FloorDetector
from floor_perception.resources import load_camera_model, load_hidden_mask
from floornav_common.arguments import share, whole
from floornav_common.reporting import UserError, run_command

_MAX_PIXELS = 200_000
Box = tuple[int, int, int, int]


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    if args.out.exists():
        raise UserError(f"{args.out} exists; name another file with --out")
    pictures = [read_picture(path) for path in args.images]
    config = FloorDetectorConfig()
    try:
        if args.box is not None:
            colors = np.concatenate([in_box(p, args.box) for p in pictures])
            color = learn(colors[:: -(-len(colors) // _MAX_PIXELS)], config.color, args.share)
        else:
            colors, color = of_rings(pictures, config, args)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    args.out.parent.mkdir(parents=True, exist_ok=True)
    save_color(color, args.out)
    share = has_color(color, colors, config.color).mean()
    red, green = color.chroma
    print(
        f"{share:.1%} of {len(colors)} pixels have the color: chromaticity {red:.3f} {green:.3f}, "
        f"brightness {color.low:.0f} to {color.high:.0f} of 765\n"
        f"written: {args.out}; use it with -p color.file:={args.out}"
    )
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="learn_colors", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    add = parser.add_argument
    add("images", nargs="+", type=Path, metavar="IMAGE", help="pictures of the camera")
    add("--out", type=Path, default=Path("floor_color.yaml"), metavar="FILE",
        help="file to write (default: %(default)s); one that exists is refused")  # fmt: skip
    add("--camera-model", default="soccer_small_size", metavar="YAML",
        help="the camera, as floor_detector's parameter (default: %(default)s)")  # fmt: skip
    add("--hidden-mask", default="", metavar="IMAGE", help="as floor_detector's parameter")
    add("--box", nargs=4, type=whole, metavar=("LEFT", "TOP", "RIGHT", "BOTTOM"),
        help="take these pixels instead, right and bottom not included")  # fmt: skip
    add(
        "--share",
        type=share,
        default=0.5,
        metavar="P",
        help="with --box: least share of its pixels in one color (default: %(default)g)",
    )
    return parser


def read_picture(path: Path) -> np.ndarray:
    """Return a picture, (H, W, 3), R, G, B.

    Raises:
        UserError: It cannot be read.
    """
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise UserError(f"{path} is not a picture that can be read")
    return np.ascontiguousarray(picture[..., ::-1])


def in_box(picture: np.ndarray, box: Box) -> np.ndarray:
    """Return the pixels of a rectangle, (N, 3).

    Raises:
        UserError: It does not lie in the picture.
    """
    left, top, right, bottom = box
    height, width = picture.shape[:2]
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        raise UserError(f"--box must lie within {width} x {height} pixels, got {tuple(box)}")
    return picture[top:bottom, left:right].reshape(-1, 3)


def of_rings(
    pictures: list[np.ndarray], config: FloorDetectorConfig, args: argparse.Namespace
) -> tuple[np.ndarray, FloorColor]:
    """Return the pixels of the rings around the robot, (N, 3), and the floor's color.

    Raises:
        UserError: The camera or the mask cannot be used.
        ValueError: No color prevails.
    """
    try:
        camera = load_camera_model(args.camera_model)
        detector = FloorDetector(camera, config, load_hidden_mask(args.hidden_mask))
        rings = [detector.ring(picture) for picture in pictures]
    except (ValueError, OSError) as error:
        raise UserError(str(error)) from error
    colors, points = (np.concatenate(parts) for parts in zip(*rings, strict=True))
    bearings, distances = np.arctan2(points[:, 1], points[:, 0]), np.hypot(*points.T)
    return colors, learn_first(colors, bearings, distances, config.color)


def run() -> int:
    """Run as a console command."""
    return run_command(main)


if __name__ == "__main__":
    sys.exit(run())
