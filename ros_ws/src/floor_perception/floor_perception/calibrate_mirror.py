"""Calibrate an omnidirectional camera: `calibrate_mirror.py INPUT... [options] --out DIR`.

From what it is given it knows what to do:

  a table with the header `radius_px,distance_m`: the mirror's curve r = f(R) (floor paper, eq. 26);
  pictures of a checkerboard (or their folder): the unified camera model;
  a table with the header `u_px,v_px,x_m,y_m`: points on the floor in base_link and their pixels in
  one picture, for height, heading and, as freed, tilt, position and camera.

It writes DIR/camera.yaml, which the nodes' parameter `camera_model` names, with confidence
intervals, and pictures of the residuals.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

from floor_perception import calibration_input as given
from floor_perception.board_calibration import calibrate_checkerboard, find_boards
from floor_perception.calibration_outcome import Outcome, ViewOptions, report_lines
from floor_perception.pairs_calibration import calibrate_pairs
from floor_perception.points_calibration import calibrate_points
from floor_perception.points_fit import GROUPS
from floor_perception.unified_fit import AUTO, MODELS
from floornav_common import reporting
from floornav_common.arguments import count, finite, not_negative, positive
from floornav_common.camera_files import camera_values, load_camera, save_camera, save_floor_camera
from floornav_common.cameras import hyperboloidal_mirror, radius_table, unified
from floornav_common.cameras.central import LOOKS, CentralCamera
from floornav_common.floor_camera import FloorCamera
from floornav_common.progress import say
from floornav_common.reporting import UserError

COMMAND = "calibrate_mirror"
PAIR_KINDS = (hyperboloidal_mirror.KIND, unified.KIND, radius_table.KIND)
SUMMARY_KEYS = (
    "job", "kind", "rms_px", "residual_sd_px", "condition", "parameters", "warnings", "camera_file",
)  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    _one_thread()
    try:
        job, outcome = _calibrate(args)
    except (ValueError, OSError) as error:
        raise UserError(" ".join(str(error).split())) from error
    out = reporting.open_out_dir(COMMAND, args.input[0].resolve().name.split(".")[0], args.out)
    values: dict[str, Any] = dict.fromkeys(SUMMARY_KEYS)
    with reporting.summary(out, command=COMMAND, seed=args.seed, values=values) as summary:
        _write(out, job, outcome, summary)
    say("\n".join(report_lines(outcome)), is_quiet=args.quiet)
    for warning in outcome.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    say(f"camera: {out / 'camera.yaml'}\nresults: {out}", is_quiet=args.quiet)
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").replace("calibrate_mirror.py", "%(prog)s"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("input", type=Path, nargs="+", metavar="INPUT", help="one table, or pictures")
    reporting.add_common_options(parser)
    group = parser.add_argument_group("the picture")
    add = group.add_argument
    add("--image-size", type=count, nargs=2, metavar=("W", "H"), help="for tables: its size, px")
    add("--image", type=Path, metavar="FILE", help="for tables: the picture itself; gives its size")
    add("--center", type=finite, nargs=2, metavar=("U", "V"),
        help="pixel of the mirror's axis (default: found, or the middle)")  # fmt: skip
    add("--center-sd", type=not_negative, default=0.0, metavar="PX",
        help="for pairs: deviation of the center, for the camera file (default: 0)")  # fmt: skip
    add("--max-radius", type=positive, metavar="PX",
        help="edge of the view (default: found, or the largest measured)")  # fmt: skip
    add("--looks", choices=LOOKS, default="mirror_above",
        help="where the camera looks (default: %(default)s)")  # fmt: skip
    group = parser.add_argument_group("pairs of radius and distance")
    add = group.add_argument
    add("--kind", choices=PAIR_KINDS, default=PAIR_KINDS[0],
        help="of the camera file (default: %(default)s)")  # fmt: skip
    add("--height", type=positive, metavar="M", help="of the viewpoint over the floor, if known")
    group = parser.add_argument_group("checkerboard")
    add = group.add_argument
    add("--pattern", type=_pattern, metavar="CxR", default=(6, 8),
        help="inner corners of the board (default: 6x8)")  # fmt: skip
    add("--model", choices=(AUTO, *MODELS), default=AUTO,
        help="what is free; auto: the simplest that the data do not refute (default)")  # fmt: skip
    group = parser.add_argument_group("points on the floor")
    add = group.add_argument
    add(
        "--camera", type=Path, metavar="YAML", help="camera that is known; only its mount is fitted"
    )
    add("--free", type=_groups, metavar="LIST",
        help=f"what is fitted, of {','.join(GROUPS)} (default: height,yaw, and camera "
        "where no --camera is given)")  # fmt: skip
    add("--position", type=finite, nargs=2, metavar=("X", "Y"), default=(0.0, 0.0),
        help="viewpoint over base_link, m (default: 0 0)")  # fmt: skip
    return parser


def _calibrate(args: argparse.Namespace) -> tuple[str, Outcome]:
    if given.job_of(args.input) == given.CHECKERBOARD:
        boards = find_boards(given.picture_files(args.input), args.pattern, args.quiet)
        center = None if args.center is None else tuple(args.center)
        return given.CHECKERBOARD, calibrate_checkerboard(
            boards, center, args.max_radius, args.looks, args.model
        )
    table = given.read_table(args.input[0])
    gray = None if args.image is None else given.read_gray(args.image)
    camera = None if args.camera is None else load_camera(args.camera)
    options = _view_options(args, gray, camera)
    if table.job == given.PAIRS:
        return table.job, calibrate_pairs(table, options, args.kind, args.height)
    free = args.free
    if free is None:
        free = ("height", "yaw") if camera is not None else ("camera", "height", "yaw")
    if camera is None and "camera" not in free:
        raise ValueError("without --camera, --free must name camera")
    position = (args.position[0], args.position[1])
    return table.job, calibrate_points(table, options, camera, free, position, gray)


def _view_options(
    args: argparse.Namespace, gray: np.ndarray | None, camera: CentralCamera | None
) -> ViewOptions:
    if gray is not None:
        size = gray.shape[1], gray.shape[0]
    elif args.image_size is not None:
        size = args.image_size[0], args.image_size[1]
    elif camera is not None:
        size = camera.width_px, camera.height_px
    else:
        raise ValueError("a table needs --image-size W H or --image FILE")
    if min(size) < 1:
        raise ValueError(f"--image-size must be > 0, got {size[0]} {size[1]}")
    if camera is not None and size != (camera.width_px, camera.height_px):
        raise ValueError(
            f"the picture is {size[0]} x {size[1]}, the camera {camera.width_px} x "
            f"{camera.height_px}"
        )
    return ViewOptions(
        size_px=size, center_px=None if args.center is None else tuple(args.center),
        max_radius_px=args.max_radius, looks=args.looks, center_sd_px=args.center_sd,
    )  # fmt: skip


def _write(out: Path, job: str, outcome: Outcome, summary: dict[str, Any]) -> None:
    for name, content in outcome.files.items():
        reporting.write_atomic(out / name, content)
    comment = "\n".join([f"{COMMAND}, {job}", *report_lines(outcome), *outcome.warnings])
    path = out / "camera.yaml"
    if isinstance(outcome.camera, FloorCamera):
        save_floor_camera(outcome.camera, path, comment)
    else:
        save_camera(outcome.camera, path, comment)
    s = outcome.statistics
    parameters = {
        name: {"value": float(v), "low": float(v - h), "high": float(v + h)}
        for name, v, h in zip(s.names, s.values, s.half_widths, strict=True)
    }
    summary.update(
        job=job, kind=_kind(outcome), rms_px=outcome.rms_px,
        residual_sd_px=s.residual_sd, condition=s.condition, parameters=parameters,
        warnings=outcome.warnings, camera_file=path, **outcome.values,
    )  # fmt: skip
    figures: list[tuple[str, ...]] = [("RMS, px", f"{outcome.rms_px:.3f}")]
    sections = [
        reporting.Section("", [reporting.Figures(figures), *outcome.warnings]),
        reporting.Section("Parameters", [_parameter_table(s)]),
        reporting.Section("Residuals", [reporting.Table(outcome.header, outcome.rows)]),
        reporting.Section(
            "Pictures", [reporting.Picture(out / n, outcome.captions[n]) for n in outcome.files]
        ),
    ]
    reporting.write_html(out, "Camera calibration", sections, f"from {job}")


def _kind(outcome: Outcome) -> str:
    camera = outcome.camera
    model = camera.camera if isinstance(camera, FloorCamera) else camera
    return str(camera_values(model)["kind"])


def _parameter_table(statistics: Any) -> reporting.Table:
    rows: list[list[Any]] = [
        [name, float(v), float(h)]
        for name, v, h in zip(
            statistics.names, statistics.values, statistics.half_widths, strict=True
        )
    ]
    return reporting.Table(["parameter", "value", "95 % +-"], rows)


def _one_thread() -> None:
    """Keep BLAS to one thread: these matrices are small, and threads cost more than they give."""
    with contextlib.suppress(ImportError):
        from threadpoolctl import threadpool_limits

        threadpool_limits(1)


def _pattern(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and int(part) > 2 for part in parts):
        raise argparse.ArgumentTypeError(f"must be like 6x8, each at least 3, got {text}")
    return int(parts[0]), int(parts[1])


def _groups(text: str) -> tuple[str, ...]:
    names = tuple(part.strip() for part in text.split(",") if part.strip())
    unknown = [name for name in names if name not in GROUPS]
    if unknown or not names:
        raise argparse.ArgumentTypeError(f"must be of {', '.join(GROUPS)}, got {text!r}")
    return names


def run() -> None:
    """Entry point of the installed command."""
    sys.exit(reporting.run_command(main))


if __name__ == "__main__":
    run()
