"""Make the voxel map that `stereo_localizer` reads.

From a folder of posed views (RGB-D images, or stereo pairs, which are matched here; how it looks:
docs/stereo.md) or, with scripts/make_voxel_map.py, from a simulator's world.
Exit code 0: written, 1: failed on the way, 2: bad input.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from floornav_common.arguments import finite, positive
from floornav_common.reporting import Progress, UserError, run_command, say
from multi_localizer.voxel_fusion import FusionSettings, extent_of, fuse_views
from multi_localizer.voxel_map import VoxelMap, save_voxel_map
from multi_localizer.voxel_view_files import PosedViews, load_all_views

_MAX_DEPTH_M = 4.0
WorldMaker = Callable[[str, float, float], VoxelMap]


def main(argv: list[str] | None = None, world_maker: WorldMaker | None = None) -> int:
    """Run the command; return its exit code.

    Args:
        argv: The command line.
        world_maker: Makes a map of a named world with cells and layers so large; None without a
            simulator.
    """
    args = make_parser().parse_args(argv)
    if args.out.exists():
        raise UserError(f"{args.out} exists; name another file with --out")
    if not args.out.parent.is_dir():
        raise UserError(f"no folder {args.out.parent}")
    try:
        voxels = _from_world(args, world_maker) if args.views is None else _from_views(args)
        save_voxel_map(args.out, replace(voxels, frame=args.frame))
    except (ValueError, OSError) as error:
        raise UserError(str(error)) from error
    except MemoryError as error:
        raise UserError(
            f"so many voxels of {args.cell:g} x {args.cell:g} x {args.layer:g} m do not fit into "
            "memory; use a larger --cell or --layer"
        ) from error
    layers, rows, columns = voxels.shape
    say(
        f"{columns} x {rows} cells of {voxels.cell_m:g} m, {layers} layers of {voxels.layer_m:g} m"
        f" from z = {voxels.origin_z_m:g} m; {int(voxels.occupied.sum())} voxels are occupied\n"
        f"written: {args.out}; use it with -p map_file:={args.out}",
        is_quiet=args.quiet,
    )
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="make_voxel_map", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--views", type=Path, nargs="+", metavar="DIR",
        help="folders of posed views, one a camera")  # fmt: skip
    source.add_argument("--world", metavar="NAME", help="a world's name or YAML file")
    add = parser.add_argument
    add("--out", type=Path, default=Path("voxel_map.npz"), metavar="FILE",
        help="file to write (default: %(default)s); one that exists is refused")  # fmt: skip
    add("--cell", type=positive, default=0.01, metavar="M",
        help="edge of a voxel along x and y, m (default: %(default)g)")  # fmt: skip
    add("--layer", type=positive, default=0.16, metavar="M",
        help="height of a layer, m (default: %(default)g)")  # fmt: skip
    add("--max-depth", type=positive, metavar="M",
        help=f"--views: farther distances are not used (default: {_MAX_DEPTH_M:g})")  # fmt: skip
    add("--bounds", nargs=6, type=finite, metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help="--views: what the map reaches over, m (default: all that is seen)")  # fmt: skip
    add("--frame", default="map", metavar="NAME", help="the map's frame (default: %(default)s)")
    add("--quiet", action="store_true", help="print errors only")
    return parser


def _from_world(args: argparse.Namespace, world_maker: WorldMaker | None) -> VoxelMap:
    if args.bounds is not None or args.max_depth is not None:
        raise UserError("--bounds and --max-depth are for --views: a world's map is of all of it")
    if world_maker is None:
        raise UserError("worlds need the simulator: python3 scripts/make_voxel_map.py --world NAME")
    return world_maker(args.world, args.cell, args.layer)


def _from_views(args: argparse.Namespace) -> VoxelMap:
    max_depth = _MAX_DEPTH_M if args.max_depth is None else args.max_depth
    with Progress("views", None, is_quiet=args.quiet) as progress:
        posed = load_all_views(args.views, lambda done, _: progress.update(done))
    _say_what_is_used(posed, args.quiet)
    if args.bounds is None:
        low, high = extent_of(posed.views, max_depth)
    else:
        low, high = np.array(args.bounds).reshape(2, 3)
    settings = FusionSettings(
        cell_m=args.cell, layer_m=args.layer, max_depth_m=max_depth,
        error_grows=posed.is_stereo, band_m=max(0.08, 3.0 * args.cell),
    )  # fmt: skip
    with Progress("layers", None, is_quiet=args.quiet) as progress:
        return fuse_views(posed.views, low, high, settings, lambda done, _: progress.update(done))


def _say_what_is_used(posed: PosedViews, is_quiet: bool) -> None:
    text = f"{len(posed.views)} views"
    if posed.num_without_pose:
        text += f"; {posed.num_without_pose} images have no pose and are left out"
    if posed.num_single:
        text += f"; {posed.num_single} lack their depth or right image and are left out"
    say(text, is_quiet=is_quiet)
    if not posed.are_upright:
        say(
            "warning: in most views down in the image is not down in the map (z up): poses must be "
            "those of the optical frame, x right, y down, z along the view"
        )


def run() -> int:
    """Run as a console command."""
    return run_command(main)


if __name__ == "__main__":
    sys.exit(run())
