"""Drive robots through a simulated world, every node a process of its own, over DDS.

In a world with goals (`flat_day`) the whole graph of nodes that the robot's
sensors ask for maps, localizes, plans and drives to them among people; the same goals are then
driven offline as most robots do today, and the page sets the two side by side.

On the `field` four robots locate each other; the `corridor` is that of the glass paper.
In a world with a route for one robot with a laser, grid_mapper maps and route_follower steers by
its pose. In every other world the robots are driven by a script, and the page shows the world from
above and what each sensor gave. Nothing but the judge knows the ground truth.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from _environment import ensure_environment

if __name__ == "__main__":
    ensure_environment(needs="node")

from _saying import saying
from floornav_common.arguments import positive
from floornav_common.reporting import (
    UserError,
    add_common_options,
    open_out_dir,
    run_command,
    say,
    summary,
)
from sim_bridge.display import NO_DISPLAY, has_display
from sim_bridge.physics import PybulletMissingError, require_pybullet
from sim_bridge.placement import oddities
from sim_bridge.robot_model import load_robot
from sim_bridge.schema import WorldError, parsed_parameters
from sim_bridge.world import World, load_world, world_names

_KEYS = (
    "world", "sim_s", "rtf", "path_m", "scans", "scans_used", "ate_m", "final_error_m",
    "final_yaw_error_deg", "odometry_ate_m", "odometry_final_error_m",
    "odometry_final_yaw_error_deg", "map_error_m", "map_error_p95_m", "map_found_share",
    "occupied_cells", "glass_recall", "touched", "bag",
)  # fmt: skip
_MAX_FACTOR = 1000.0  # what sim_bridge takes
_DAY_FACTOR, _FACTOR = 1.0, 3.0
_DAY_KEYS = (
    "world", "goals", "reached", "collisions", "glass_touched", "stops_over_5s", "stopped_s",
    "time_s", "path_m", "touched", "sim_s", "rtf", "glass_recall", "pose_error_m",
    "inputs_handled", "latency_ms", "load", "baseline", "bag",
)  # fmt: skip
_FIELD_KEYS = ("world", "sim_s", "pose_error_m", "images")
_SHORT = {"corridor": "glass_corridor", "field": "middle_size_field"}
"""Short names of worlds; `field` is more than its world: the team locates itself there."""
_TOUR_KEYS = ("world", "sim_s", "rtf", "robots", "people", "bag")


def main() -> int:
    """Run the demo."""
    args = _parser().parse_args()
    try:
        world = _loaded(args)
    except PybulletMissingError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    has_window = _has_window(args)
    if args.live and (args.world == "field" or (world.goals is None and world.route is None)):
        raise UserError(f"--live: nobody maps in {args.world}, so there is nothing to show")
    for oddity in oddities(world):
        say(f"look: {oddity}", is_quiet=args.quiet)
    from _demo_domain import join_domain

    if obstacle := join_domain():
        print(f"error: {obstacle}", file=sys.stderr)
        return 1
    out = open_out_dir("demo", world.name, args.out)
    demo, keys, lines = _make(world, args, out, has_window)
    values: dict[str, Any] = dict.fromkeys(keys)
    values["world"] = world.name
    with summary(out, command="demo", seed=args.seed, values=values) as filled:
        try:
            demo.run()
        finally:
            with saying("drawing the report ...", is_quiet=args.quiet):
                filled.update(demo.results())
                filled.update(ok=not demo.problem, partial=bool(demo.problem))
                demo.write(filled)
    _print_result(out, demo.problem, lines(filled), is_quiet=args.quiet)
    return 1 if demo.problem else 0


def _loaded(args: argparse.Namespace) -> World:
    """Return the world.

    Raises:
        UserError: There is none of that name, or it cannot be driven.
        PybulletMissingError: It cannot be simulated here.
    """
    try:
        world = load_world(_SHORT.get(args.world, args.world), parsed_parameters(args.set))
        require_pybullet()
        _require_drivable(world)
    except WorldError as error:
        raise UserError(str(error)) from error
    return world


def _require_drivable(world: World) -> None:
    """Check what would otherwise end the nodes later.

    Raises:
        WorldError: The world has no robots, or cannot be simulated.
    """
    if not world.robots:
        raise WorldError(f"{world.name}: no robots, so there is nothing to drive")
    from sim_bridge.simulation import check_world

    check_world(world)


def _make(
    world: World, args: argparse.Namespace, out: Path, has_window: bool
) -> tuple[Any, tuple[str, ...], Callable[[dict[str, Any]], list[str]]]:
    """Return what runs in a world, its keys of the summary, and what gives its last lines."""
    has_one_laser = len(world.robots) == 1 and load_robot(world.robots[0]).config.laser is not None
    if world.goals is not None and has_one_laser:
        args.rtf = _DAY_FACTOR if args.rtf is None else args.rtf
        from _day_report import last_lines
        from _day_run import Day

        return Day(world, args, out, has_window), _DAY_KEYS, last_lines
    if args.world == "field":
        args.rtf = args.rtf or _DAY_FACTOR
        from _field_run import Field, field_lines

        return Field(world, args, out, has_window), _FIELD_KEYS, field_lines
    args.rtf = _FACTOR if args.rtf is None else args.rtf
    args.world = _SHORT.get(args.world, args.world)
    if world.route is not None and has_one_laser:
        from _demo_report import mapped_lines
        from _demo_run import Demo

        return Demo(world, args, out, has_window), _KEYS, mapped_lines
    from _demo_tour import Tour
    from _tour_report import tour_lines

    return Tour(world, args, out, has_window), _TOUR_KEYS, tour_lines


def _print_result(out: Path, problem: str, lines: list[str], *, is_quiet: bool) -> None:
    if problem:
        print(f"demo failed: {problem}", file=sys.stderr)
    for line in (*lines, f"report: {out / 'report.html'}"):
        say(line, is_quiet=is_quiet)


def _has_window(args: argparse.Namespace) -> bool:
    if args.view and not has_display():
        raise UserError(f"--view {NO_DISPLAY}: use --headless")
    return has_display() and not args.headless


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    names = ", ".join((*_SHORT, *world_names()))
    text = f"{names}, or path of a world file (default: furnished_floor)"
    parser.add_argument("world", nargs="?", default="furnished_floor", metavar="WORLD", help=text)
    window = parser.add_mutually_exclusive_group()
    window.add_argument("--headless", action="store_true", help="no window (default: no display)")
    window.add_argument("--view", action="store_true", help="show pybullet's window")
    text = "show the robot in a browser while it drives (with goals or a route)"
    parser.add_argument("--live", action="store_true", help=text)
    text = "a figure that the world file names, such as start_distance_m=4.7; may be repeated"
    parser.add_argument("--set", action="append", metavar="NAME=VALUE", default=[], help=text)
    text = (
        "stop after so many simulated seconds (default: at the last goal, the route's end, or 20)"
    )
    parser.add_argument("--duration", type=positive, metavar="S", default=None, help=text)
    text = (
        f"simulated seconds in a second (default: {_DAY_FACTOR:g} with goals, else {_FACTOR:g}; "
        "0 = as fast as it goes)"
    )
    parser.add_argument("--rtf", type=_factor, default=None, metavar="F", help=text)
    text = "record camera images too (with goals)"
    parser.add_argument("--images", action="store_true", help=text)
    text = "write film.gif too (with goals)"
    parser.add_argument("--film", action="store_true", help=text)
    add_common_options(parser)
    return parser


def _factor(text: str) -> float:
    value = _number(text)
    if not 0.0 <= value <= _MAX_FACTOR:
        raise argparse.ArgumentTypeError(f"must be a number in 0..{_MAX_FACTOR:g}, got {text}")
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


if __name__ == "__main__":
    sys.exit(run_command(main))
