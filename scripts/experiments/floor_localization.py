"""Pose from the floor's shape at the paper's six positions, beside its Table 1 and the bound.

Pictures of the small-size field as a mirror sees it, with lens blur and sensor noise; the mask is
floor_detector's. At each place the heading is random and four cubes of 130 mm stand anywhere, drawn
by seed (those of the paper's Fig. 10 are not in the text). The mirror is calibrated from 24 pairs
of distance and pixel radius whose radii have noise of 0.3 px, and its center is known to 0.05 px;
both are drawn anew for every pose, and once for the floor's detector. Of the two poses that a
symmetric field allows the one that is nearer to the truth counts; in short drives with goals and
odometry the localizer has to settle it by itself. RMS errors are those of poses that were given.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from experiments import floor_pose_report as report
from experiments.floor_pose_bounds import PAIR_NOISE_PX, calibrated
from experiments.floor_pose_drives import drives
from experiments.floor_pose_runs import (
    BORDER_SD_PX,
    BOUND_CASES,
    POSITIONS_MM,
    Outcome,
    View,
    border_errors,
    calibrated_fitters,
    cell,
    consistency,
    field_camera,
    judge,
    judge_published,
    rms,
    views_at,
    views_hiding,
)
from experiments.floor_pose_scenes import FieldCamera
from floornav_common.arguments import count
from floornav_common.floor_camera import FloorCamera
from floornav_common.reporting import Progress, Section, UserError
from multi_localizer.floor_fitter import FloorShapeFitter
from multi_localizer.floor_plan import FloorPlan, load_plan
from sim_bridge.appearance import Light
from sim_bridge.camera_config import ImageConfig

SIZES = ((256, 220), (640, 480))
SHARES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
PAIR_NOISES_PX = (0.0, 0.1, 0.3, 0.6, 1.0)
CENTER_ERRORS_PX = (0.25, 0.5, 1.0, 2.0)
PAPER_POSES, DRIVES_BY = 10, 4
LIGHTS = {
    "the world's": (Light(direction=(0.35, 0.25, 1.0), ambient=0.55, shadow=0.6), 0.9),
    "half as bright": (Light(direction=(0.35, 0.25, 1.0), ambient=0.55, shadow=0.6), 0.45),
    "bright, from above": (Light(direction=(0.0, 0.0, 1.0), ambient=0.7, shadow=0.5), 1.3),
    "low lamp at one end": (Light(direction=(1.0, 0.0, 0.6), ambient=0.4, shadow=0.8), 0.9),
    "low lamp at one side": (Light(direction=(0.1, 1.0, 0.6), ambient=0.4, shadow=0.8), 0.9),
    "warm": (Light(direction=(0.35, 0.25, 1.0), color=(1.0, 0.86, 0.68)), 0.9),
    "cold": (Light(direction=(0.35, 0.25, 1.0), color=(0.86, 0.94, 1.0)), 0.9),
}
Values = dict[str, Any]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of this experiment."""
    parser.add_argument(
        "--poses", type=count, default=100, metavar="N", help="poses at each place (default: 100)"
    )


def check(args: argparse.Namespace) -> None:
    """Refuse bad options."""
    if args.poses < 2:
        raise UserError(f"--poses must be at least 2, got {args.poses}")


def run(args: argparse.Namespace, values: Values) -> list[Section]:
    """Run all parts; what is done so far stays in the values."""
    keys = (
        "positions", "crlb_ratio_median", "crlb_calibrated_ratio_median",
        "crlb_default_ratio_median", "crlb_calibrated_default_ratio_median", "occlusion",
        "positions_first_10", "positions_640x480", "published", "consistency", "bounds",
        "calibration", "light", "drives",
    )  # fmt: skip
    values.update(dict.fromkeys(keys))
    plan = load_plan("small_size_field")
    small: dict[tuple[int, int], list[View]] = {}
    for size in SIZES:
        field = field_camera(size, args.seed)
        views = _views(field, plan, args)
        _table(field.camera, views, plan, args, values, "" if size == SIZES[0] else "_640x480")
        if size == SIZES[0]:
            small, small_field = views, field
            report.draw_views(small_field, views, plan, args.out_dir)
    _bounds(small_field.camera, plan, args, values)
    _occlusion(small_field, plan, args, values)
    _calibration(small_field.camera, small, plan, args, values)
    _light(plan, args, values)
    scanner = calibrated_fitters(small_field.camera, 1, plan, args.seed, PAIR_NOISE_PX)[0].scanner
    num = max(2, args.poses // DRIVES_BY)
    values["drives"] = drives(small_field, num, plan, args.seed, scanner)
    return report.sections(values, args.out_dir)


def _views(
    field: FieldCamera, plan: FloorPlan, args: argparse.Namespace
) -> dict[tuple[int, int], list[View]]:
    name = f"{field.camera.width_px} x {field.camera.height_px}: pictures of places"
    views = {}
    with Progress(name, len(POSITIONS_MM), is_quiet=args.quiet) as progress:
        for k, position in enumerate(POSITIONS_MM):
            views[position] = views_at(field, position, args.poses, plan, args.seed)
            progress.update(k + 1)
    return views


def _table(
    camera: FloorCamera,
    views: dict[tuple[int, int], list[View]],
    plan: FloorPlan,
    args: argparse.Namespace,
    values: Values,
    suffix: str,
) -> None:
    """Fill in Table 1 for a size; with the published steps and the covariances' consistency."""
    num = args.poses * len(views)
    fitters = iter(calibrated_fitters(camera, num, plan, args.seed, PAIR_NOISE_PX))
    rows: dict[str, list[dict[str, Any]]] = {"positions": [], "first_10": [], "published": []}
    every: list[Outcome] = []
    for position, at in views.items():
        used = [next(fitters) for _ in at]
        got = [judge(f.fit(v.mask), v.pose) for f, v in zip(used, at, strict=True)]
        old = [judge_published(v, f.camera, plan) for f, v in zip(used, at, strict=True)]
        rows["positions"].append(cell(position, got))
        rows["first_10"].append(cell(position, got[:PAPER_POSES]))
        rows["published"].append(cell(position, old))
        every += got
    values[f"positions{suffix}"] = rows["positions"]
    values[f"positions_first_10{suffix}"] = rows["first_10"]
    values[f"published{suffix}"] = rows["published"]
    values[f"consistency{suffix}"] = consistency(every)


def _bounds(camera: FloorCamera, plan: FloorPlan, args: argparse.Namespace, values: Values) -> None:
    rows = []
    with Progress("border of known noise", len(POSITIONS_MM), is_quiet=args.quiet) as progress:
        for k, position in enumerate(POSITIONS_MM):
            rows.append(border_errors(camera, position, args.poses, plan, args.seed))
            progress.update(k + 1)
    values["bounds"] = {"border_sd_px": BORDER_SD_PX, "pair_sd_px": PAIR_NOISE_PX, "rows": rows}
    for name in BOUND_CASES:
        ratios = [ratio for row in rows for ratio in row[f"{name}_ratio"]]
        key = f"{name}_".removeprefix("true_")
        values[f"crlb_{key}ratio_median"] = float(np.median(ratios))


def _occlusion(
    field: FieldCamera, plan: FloorPlan, args: argparse.Namespace, values: Values
) -> None:
    fitters = calibrated_fitters(field.camera, args.poses, plan, args.seed, PAIR_NOISE_PX)
    rows = []
    with Progress("hidden border", len(SHARES), is_quiet=args.quiet) as progress:
        for k, share in enumerate(SHARES):
            views = views_hiding(field, share, args.poses, plan, args.seed)
            at = list(zip(fitters, views, strict=True))
            got = [judge(f.fit(v.mask), v.pose) for f, v in at]
            old = [judge_published(v, f.camera, plan) for f, v in at]
            rows.append({"share": share, **_short(got, old)})
            progress.update(k + 1)
    values["occlusion"] = rows


def _calibration(
    camera: FloorCamera,
    views: dict[tuple[int, int], list[View]],
    plan: FloorPlan,
    args: argparse.Namespace,
    values: Values,
) -> None:
    """Fit the same masks with worse and worse cameras."""
    some = [v for at in views.values() for v in at[: max(2, args.poses // 5)]]
    kinds = [("pairs", e) for e in PAIR_NOISES_PX] + [("center", e) for e in CENTER_ERRORS_PX]
    rows, walked = [], None
    with Progress("calibration", len(kinds), is_quiet=args.quiet) as progress:
        for k, (kind, error) in enumerate(kinds):
            rng = np.random.default_rng([args.seed, 3, k])
            cameras = [_worse(camera, kind, error, rng) for _ in some]
            walked = walked or FloorShapeFitter(cameras[0], plan).scanner
            fitters = [FloorShapeFitter(c, plan, scanner=walked.through(c)) for c in cameras]
            at = list(zip(fitters, some, strict=True))
            got = [judge(f.fit(v.mask), v.pose) for f, v in at]
            old = [judge_published(v, f.camera, plan) for f, v in at]
            rows.append({"kind": kind, "error_px": error, **_short(got, old)})
            progress.update(k + 1)
    values["calibration"] = rows


def _worse(camera: FloorCamera, kind: str, error: float, rng: np.random.Generator) -> FloorCamera:
    """Return a camera calibrated from pairs of some noise, or whose center is off so far."""
    if kind == "pairs":
        return camera if error == 0.0 else calibrated(camera, rng, error).camera(camera)
    way = float(rng.uniform(-np.pi, np.pi))
    u, v = camera.center_px
    moved = {"center_u_px": u + error * np.cos(way), "center_v_px": v + error * np.sin(way)}
    off = calibrated(camera, rng, PAIR_NOISE_PX).camera(camera)
    return replace(off, camera=replace(off.camera, **moved))  # type: ignore[type-var]


def _light(plan: FloorPlan, args: argparse.Namespace, values: Values) -> None:
    rows = []
    with Progress("light", len(LIGHTS), is_quiet=args.quiet) as progress:
        for k, (name, (light, exposure)) in enumerate(LIGHTS.items()):
            field = field_camera(SIZES[0], args.seed, light, ImageConfig(exposure=exposure))
            views = [
                view
                for position in POSITIONS_MM
                for view in views_at(field, position, max(2, args.poses // 5), plan, args.seed)
            ]
            fitters = calibrated_fitters(field.camera, len(views), plan, args.seed, PAIR_NOISE_PX)
            at = list(zip(fitters, views, strict=True))
            got = [judge(f.fit(v.mask), v.pose) for f, v in at]
            old = [judge_published(v, f.camera, plan) for f, v in at]
            rows.append({"light": name, "exposure": exposure, **_short(got, old)})
            progress.update(k + 1)
    values["light"] = rows


def _short(got: list[Outcome], old: list[Outcome]) -> dict[str, Any]:
    """Return a row of a sweep: errors, failures, refusals, and the published steps' errors."""
    x, y, yaw = rms(got)
    old_x, old_y, _ = rms(old)
    return {
        "rms_m": float(np.hypot(x, y)),
        "rms_x_m": float(x),
        "rms_y_m": float(y),
        "rms_theta_deg": float(np.degrees(yaw)),
        "failures": sum(o.has_failed for o in got),
        "refused": sum(bool(o.problem) for o in got),
        "wrong_and_sure": sum(o.has_failed and not o.problem and not o.is_ambiguous for o in got),
        "ambiguous": sum(o.is_ambiguous for o in got),
        "poses": len(got),
        "published_rms_m": float(np.hypot(old_x, old_y)),
        "published_failures": sum(o.has_failed for o in old),
    }
