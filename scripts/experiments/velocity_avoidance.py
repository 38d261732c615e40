"""The avoidance experiment of the floor paper's 5.1, Fig. 9, and 200 random fields of cubes.

The robot sees the small-size field through its mirror (rendered images, `floor_perception`), drives
by `sjmc_planner` on the simulated wheels, and heads for a goal behind the cubes, with and without
regard to its velocity, with our default template and method and with the published ones. The
published: I 6, J 32, r_th 0.8, v 400 mm/s, alpha 300 mm/s^2, idle time 0.03 s, T_th 2.75 s, one
cycle 40 ms; its outer radius is not given: here 95 px of 256 x 220 (1.16 m) in all fields, and
105 px (2.61 m) in one of eight. Nor is r_robot (85 mm and 20 mm of air here). Our method for a
differential robot drives one field of eight too.

The fields' seeds are other ones than those that the defaults were chosen on (seed 1000).
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.avoidance_fields import Field, figure_9, random_field
from experiments.avoidance_judge import Run, figures, turns
from experiments.avoidance_pictures import draw_fields, draw_figure_4c, draw_figure_9
from experiments.avoidance_runs import PERIOD_S, Perception, drive_field
from experiments.parallel_tasks import add_spread_options, run_tasks
from floor_perception.config import FloorDetectorConfig, TemplateConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.resources import load_camera_model
from floornav_common.arguments import count
from floornav_common.reporting import Picture, Progress, Section, Table
from sjmc_planner.config import LocalPlannerConfig, OmniConfig, RobotConfig
from sjmc_planner.methods import make_method

MODES = ("omni_velocity", "omni_static")
CAMERA = "soccer_small_size"
RENDERED = {"samples": 1}
NUM_FIELDS, NUM_QUICK = 200, 8
HEADER = [
    "template and rule", "mode", "runs", "collisions", "reached", "time s", "path m",
    "least clearance m", "clearance m (median)", "turn begins s",
]  # fmt: skip
Task = tuple[int, int, str, str]


@dataclass(frozen=True)
class Setting:
    """One way to drive the fields.

    Attributes:
        title: For tables.
        modes: Methods driven.
        share: One field in so many.
        radius_px: Outer radius of the published template and rule; None for ours.
        drive: Of the robot.
    """

    title: str
    modes: tuple[str, ...] = MODES
    share: int = 1
    radius_px: float | None = None
    drive: str = "omni"


SETTINGS = {
    "default": Setting("default"),
    "paper": Setting("paper, 95 px", radius_px=95.0),
    "paper_105_px": Setting("paper, 105 px", share=8, radius_px=105.0),
    "differential": Setting("default, differential", MODES[:1], share=8, drive="differential"),
}
CASES = [(key, mode) for key, setting in SETTINGS.items() for mode in setting.modes]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--fields", type=count, default=NUM_FIELDS, metavar="N",
        help=f"random fields (default: {NUM_FIELDS})",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help=f"{NUM_QUICK} random fields only")
    add_spread_options(parser)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive all fields, write pictures, and return the report."""
    num = NUM_QUICK if args.quick else args.fields
    values["runs_of_each"] = num
    tasks = [
        (args.seed, number, *case)
        for number in range(-1, num)
        for case in CASES
        if number < 0 or number % SETTINGS[case[0]].share == 0
    ]
    runs: dict[Task, Run] = {}
    with Progress("velocity-avoidance", len(tasks), is_quiet=args.quiet) as progress:
        for task, done in run_tasks(_drive, tasks, args.jobs, args.cluster):
            runs[task] = done
            num_touched = sum(r.has_collided for r in runs.values())
            note = f"{len(runs)} of {len(tasks)} drives, {num_touched} touched something"
            progress.update(len(runs), note, is_last=len(runs) == len(tasks))
            _fill(values, runs)
    return _sections(args, values, runs)


def _drive(task: Task) -> Run:
    seed, number, setting, mode = task
    config = _config(SETTINGS[setting], mode)
    see = _perception(SETTINGS[setting])
    method = make_method(config)
    return drive_field(_field(seed, number), method, config.robot, see, seed, RENDERED)


def _field(seed: int, number: int) -> Field:
    return figure_9() if number < 0 else random_field(seed, number)


def _config(setting: Setting, mode: str) -> LocalPlannerConfig:
    robot = RobotConfig(drive=setting.drive)
    config = LocalPlannerConfig(method=mode, control_period_s=PERIOD_S, robot=robot)
    if setting.radius_px is None:
        return config
    omni = OmniConfig(num_directions=32, num_speeds=1, keeps_stoppable=False, remembers_near=False)
    return replace(config, omni=omni)


def _perception(setting: Setting) -> Perception:
    camera = load_camera_model(CAMERA)
    config = FloorDetectorConfig()
    if setting.radius_px is not None:
        horizon = float(camera.camera.floor_distance(setting.radius_px))  # type: ignore[attr-defined]
        template = TemplateConfig(num_rings=6, num_directions=32, free_share=0.8, horizon_m=horizon)
        config = replace(config, template=template)
    detector = FloorDetector(camera, config)

    def see(image: np.ndarray, stamp_ns: int) -> Any:
        result = detector.detect(image, "rgb", stamp_ns)
        return None if result is None else result.scan

    return see


def _fill(values: dict[str, Any], runs: dict[Task, Run]) -> None:
    """Write what is known so far: the default's figures on top, the others by their names."""
    shown = values.setdefault("figure_9", {})
    for key, setting in SETTINGS.items():
        on_top = key == "default"
        place = values if on_top else values.setdefault(key, {})
        shown_place = shown if on_top else shown.setdefault(key, {})
        for mode in setting.modes:
            place[mode] = figures(
                [r for t, r in runs.items() if t[1] >= 0 and t[2:] == (key, mode)]
            )
            shown_place[mode] = figures(
                [r for t, r in runs.items() if t[1] < 0 and t[2:] == (key, mode)]
            )
        if setting.modes == MODES:
            place["turns_earlier"] = turns(_pairs(runs, key))


def _pairs(runs: dict[Task, Run], setting: str) -> list[tuple[Run, Run]]:
    """Return the drives with velocity and without of each random field that has both."""
    found = []
    for (seed, number, own, mode), aware in runs.items():
        static = runs.get((seed, number, setting, "omni_static"))
        if (own, mode) == (setting, "omni_velocity") and number >= 0 and static is not None:
            found.append((aware, static))
    return found


def _sections(
    args: argparse.Namespace, values: dict[str, Any], runs: dict[Task, Run]
) -> list[Section]:
    by_case = {case: [r for t, r in runs.items() if t[2:] == case] for case in CASES}
    pictures = [
        draw_figure_4c(args.out_dir / "figure_4c.png"),
        *(
            draw_figure_9(
                args.out_dir / f"figure_9_{s}.png", s, {m: by_case[s, m][0] for m in MODES}
            )
            for s in ("default", "paper")
        ),
        draw_fields(args.out_dir / "fields.png", {m: by_case["default", m][1:7] for m in MODES}),
    ]
    tables = []
    for title, key in (("random fields", None), ("figure 9", "figure_9")):
        place = values if key is None else values[key]
        rows = [
            [SETTINGS[s].title, m, *_row((place if s == "default" else place[s])[m])]
            for s, m in CASES
        ]
        tables.append(Section(title, [Table(HEADER, rows)]))
    return [*tables, Section("Pictures", [Picture(path, text) for path, text in pictures])]


def _row(figures: dict[str, Any]) -> list[Any]:
    keys = (
        "runs", "collisions", "reached", "time_s", "path_m", "min_clearance_m",
        "median_clearance_m", "turn_start_s",
    )  # fmt: skip
    return [
        round(figures[key], 3) if isinstance(figures[key], float) else figures[key] for key in keys
    ]
