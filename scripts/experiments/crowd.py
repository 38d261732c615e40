"""Driving among people who react, and among recorded ones who do not: every method, ORCA, DWA.

The thesis's robot (Segway RMP 50, laser 1 m above the floor, 4 m, 240 degrees, 3 km/h) crosses a
corridor, a doorway, a living room and a hall, each with people of `sim_bridge` that notice it late
or never and step aside or not; with `--people FILE` also recorded pedestrians (ETH/UCY), who are
replayed and see nothing of it. All methods meet the same people. The robot knows its scans and
its odometry, which drifts; a command is sent one period after the scan it was decided on.

A contact is caused by the robot if it moves faster than 0.05 m/s and the person is in its front
half-plane or it moves into them; the others are theirs. Success: there within 60 s without a
contact that it caused; there is level with the goal, as how a method stops at one is not asked
here. Least distance: outline to torso. Intimate and personal space after Hall
(1966): time with somebody within 0.45 and 1.2 m. A heading change is a turn by more than 15 deg.
Beside VFH+: a run without success counts with its 60 s; "both" is of runs in which both had it.

Not all are told the same of the robot: sjmc and sjmc_published its box (0.56 m wide), all others
the disk about its base that holds the box (1.14 m wide), which is what their models take. The row
sjmc_disk is sjmc told that disk.

Recorded people are met from a start that nobody comes near in the first 2 s, with somebody on the
way, and nobody whose recording begins within 3 m of it.

No method is tuned on these seeds: other ones (`--seed`) are for that.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from experiments.crowd_pictures import draw_scene
from experiments.crowd_runs import (
    ALL_METHODS,
    NUM_PICTURED,
    Outcome,
    Task,
    beside,
    figures,
    run_task,
    scene_of,
)
from experiments.crowd_scenes import SCENES
from experiments.crowd_words import BESIDE, SHOWN, glossary
from experiments.parallel_tasks import add_spread_options, run_tasks
from floornav_common.arguments import count, positive
from floornav_common.reporting import Picture, Progress, Section, Table, UserError
from sim_bridge.people.recorded import read_obsmat
from sim_bridge.schema import WorldError

NUM_RUNS, NUM_OTHERS, NUM_QUICK = 75, 10, 2
_BASE = "vfh_plus"
_CLAIMED = ("sjmc", _BASE)
_AIMS = (
    "contacts caused", "stops over 5 s where all yield", "time / VFH+", "turns / VFH+, both"
)  # fmt: skip
_MOST = 0.0, 0.0, 0.7, 0.5


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--people", nargs="+", default=[], metavar="FILE",
        help="recorded pedestrians (obsmat, plain or .gz), one scene a file",
    )  # fmt: skip
    parser.add_argument("--fps", type=positive, default=25.0, help="of their videos (default: 25)")
    parser.add_argument(
        "--runs", type=count, default=NUM_RUNS, metavar="N",
        help=f"runs of {' and '.join(_CLAIMED)} in each scene (default: {NUM_RUNS}), "
        f"{NUM_OTHERS} at most of the others",
    )  # fmt: skip
    parser.add_argument(
        "--quick", action="store_true", help=f"{NUM_QUICK} runs of each only, to try it out"
    )
    parser.add_argument(
        "--methods", nargs="+", choices=ALL_METHODS, default=list(ALL_METHODS), metavar="NAME",
        help=f"which (default: all: {', '.join(ALL_METHODS)})",
    )  # fmt: skip
    parser.add_argument(
        "--scenes", nargs="*", choices=tuple(SCENES), default=list(SCENES), metavar="NAME",
        help=f"which simulated ones (default: all: {', '.join(SCENES)}); none with no name",
    )  # fmt: skip
    add_spread_options(parser)


def check(args: argparse.Namespace) -> None:
    """Refuse bad input before a folder is made."""
    for file in args.people:
        try:
            read_obsmat(Path(file).expanduser())
        except WorldError as error:
            raise UserError(str(error)) from error
    if not args.scenes and not args.people:
        raise UserError("no scene: name one with --scenes or a recording with --people")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Make all runs, write pictures, and return the report."""
    num = NUM_QUICK if args.quick else args.runs
    places = _places(args)
    values["runs_of_each"] = num
    tasks = [
        Task(scene, number, method, args.seed, people, args.fps)
        for number in range(num)
        for scene, people in places.items()
        for method in args.methods
        if number < NUM_OTHERS or method in _CLAIMED
    ]
    outcomes: dict[Task, Outcome] = {}
    with Progress("crowd", len(tasks), is_quiet=args.quiet) as progress:
        for task, outcome in run_tasks(run_task, tasks, args.jobs, args.cluster):
            outcomes[task] = outcome
            caused = sum(o.caused for o in outcomes.values())
            note = f"{len(outcomes)} of {len(tasks)} runs, {caused} contacts caused by a robot"
            progress.update(len(outcomes), note, is_last=len(outcomes) == len(tasks))
            if len(outcomes) % len(args.methods) == 0 or len(outcomes) == len(tasks):
                values["scenes"] = _scenes(outcomes, list(places), args.methods)
    return _sections(args, values, outcomes, places)


def _places(args: argparse.Namespace) -> dict[str, str]:
    """Return the file of each scene by its name; "" for the simulated ones."""
    places = dict.fromkeys(args.scenes, "")
    for file in args.people:
        path = Path(file).expanduser().resolve()
        name = path.parent.name or path.stem
        while name in places:
            name += "_2"
        places[name] = str(path)
    return places


def _scenes(outcomes: dict[Task, Outcome], scenes: list[str], methods: list[str]) -> dict[str, Any]:
    """Return the figures so far, as `summary.json` holds them."""
    found: dict[str, Any] = {}
    for scene in scenes:
        by_number = {
            method: {
                task.number: outcome
                for task, outcome in outcomes.items()
                if (task.scene, task.method) == (scene, method)
            }
            for method in methods
        }
        own: dict[str, Any] = {}
        for method, runs in by_number.items():
            own[method] = figures(list(runs.values()))
            own[method][f"beside_{_BASE}"] = (
                beside(runs, by_number[_BASE]) if _BASE in by_number else None
            )
        found[scene] = {"methods": own}
    return found


def _sections(
    args: argparse.Namespace, values: dict[str, Any], outcomes: dict[Task, Outcome],
    places: dict[str, str],
) -> list[Section]:  # fmt: skip
    sections = []
    header = ["method", *SHOWN.values(), *BESIDE.values()]
    for scene in places:
        rows = []
        for method, own in values["scenes"][scene]["methods"].items():
            ratios = own[f"beside_{_BASE}"] or {}
            cells = [own[key] for key in SHOWN] + [ratios.get(key) for key in BESIDE]
            rows.append([method, *(_cell(value) for value in cells)])
        pictures = _pictures(args, scene, places[scene], outcomes)
        nums = {own["runs"] for own in values["scenes"][scene]["methods"].values()}
        title = f"{scene.replace('_', ' ')}: {' or '.join(map(str, sorted(nums)))} runs a method"
        sections.append(Section(title, [Table(header, rows), *pictures]))
    is_reacting = "sjmc" in args.methods and any(name in SCENES for name in places)
    sections.append(glossary())
    aims = [_aims(values["scenes"])] if is_reacting else []
    if "sjmc" in args.methods and any(places.values()):
        aims.append(_recorded_aims(values["scenes"], [s for s, file in places.items() if file]))
    return [*aims, *sections]


def _aims(scenes: dict[str, Any]) -> Section:
    """Return what was to be reached among people who react, and whether `sjmc` did."""
    rows = []
    for scene in (name for name in SCENES if name in scenes):
        own = scenes[scene]["methods"].get("sjmc")
        if own is not None:
            ratios = own[f"beside_{_BASE}"] or {}
            stops = own["long_stops_where_all_yield"] if own["runs_where_all_yield"] else None
            found = [own["collisions_caused"], stops, ratios.get("time"),
                     ratios.get("heading_changes")]  # fmt: skip
            cells = [_judged(value, most) for value, most in zip(found, _MOST, strict=True)]
            rows.append([scene.replace("_", " "), *cells])
    aims = [f"{text} (aim: {most:g})" for text, most in zip(_AIMS, _MOST, strict=True)]
    return Section("sjmc beside its aims", [Table(["scene", *aims], rows)])


def _recorded_aims(scenes: dict[str, Any], names: list[str]) -> Section:
    """Return whether `sjmc` caused no more contacts a run than the best other, by recording."""
    rows = []
    for scene in names:
        shares = {
            method: own["collisions_caused"] / own["runs"]
            for method, own in scenes[scene]["methods"].items()
            if own["runs"]
        }
        ours = shares.pop("sjmc", None)
        best = min(shares, key=lambda method: shares[method], default=None)
        if ours is not None and best is not None:
            found = _judged(ours, shares[best])
            rows.append([scene.replace("_", " "), found, f"{shares[best]:.2f} ({best})"])
    header = ["recording", "contacts caused a run (aim: the best other's)", "best other"]
    return Section("sjmc beside its aim among recorded people", [Table(header, rows)])


def _judged(value: float | None, most: float) -> str:
    """Return a figure with whether it is at most what was aimed at."""
    if value is None:
        return "not measured"
    return f"{round(value, 2):g}: {'met' if value <= most else 'not met'}"


def _pictures(
    args: argparse.Namespace, scene: str, people: str, outcomes: dict[Task, Outcome]
) -> list[Picture]:
    drawn = []
    for number in range(NUM_PICTURED):
        runs = {t.method: o for t, o in outcomes.items() if (t.scene, t.number) == (scene, number)}
        if not runs:
            continue
        path = args.out_dir / f"{scene}_{number}.png"
        task = Task(scene, number, args.methods[0], args.seed, people, args.fps)
        draw_scene(path, scene_of(task), runs)
        text = (
            f"{scene}, run {number}: the robot every second (blue), people's ways and where they "
            "were at the end (orange dots, disks), the goal (black cross)."
        )
        drawn.append(Picture(path, text))
    return drawn


def _cell(value: Any) -> Any:
    return round(value, 2) if isinstance(value, float) else value
