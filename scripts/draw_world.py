"""Pictures of worlds from above, with laser points and sonar arcs."""

from __future__ import annotations

import argparse
import sys

from _environment import ensure_environment

if __name__ == "__main__":
    ensure_environment(needs="node")

from floornav_common.reporting import (
    UserError,
    add_common_options,
    open_out_dir,
    run_command,
    say,
    summary,
)
from sim_bridge.schema import WorldError
from sim_bridge.world import load_world, world_names
from sim_bridge.world_picture import write_world_picture


def main(argv: list[str] | None = None) -> int:
    """Draw the worlds."""
    args = _parser().parse_args(argv)
    try:
        worlds = [load_world(name) for name in args.worlds or world_names()]
    except WorldError as error:
        raise UserError(str(error)) from error
    several = f"{len(worlds)}-worlds" if args.worlds else "all"
    out = open_out_dir("draw_world", worlds[0].name if len(worlds) == 1 else several, args.out)
    with summary(out, command="draw_world", seed=args.seed, values={"worlds": {}}) as values:
        for world in worlds:
            path = out / f"{world.name.replace(':', '-')}.png"
            try:
                num = write_world_picture(path, world, args.seed)
            except WorldError as error:
                raise UserError(str(error)) from error
            values["worlds"][world.name] = {"picture": path.name, "places": num}
            places = "1 place" if num == 1 else f"{num} places"
            say(f"{path}: measured from {places}", is_quiet=args.quiet)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="draw_world.py", description=__doc__)
    text = "names, paths of world files, or generated:SEED:GLASS_SHARE (default: all)"
    parser.add_argument("worlds", nargs="*", metavar="WORLD", help=text)
    add_common_options(parser)
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
