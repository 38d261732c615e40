"""The avoidance experiment of the floor paper's 5.1, Fig. 9, and 200 random fields of cubes.

The robot sees the small-size field through its mirror (rendered images, `floor_perception`), drives
by `sjmc_planner` on the simulated wheels, and heads for a goal behind the cubes, with and without
regard to its velocity, with our default template and method and with the published ones. The
published: I 6, J 32, r_th 0.8, v 400 mm/s, alpha 300 mm/s^2, idle time 0.03 s, T_th 2.75 s, one
cycle 40 ms; its outer radius is not given (here 105 px of 256 x 220), nor is r_robot (85 mm and
20 mm of air here).

The fields' seeds are other ones than those that the defaults were chosen on (seed 1000).
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import Any

import numpy as np

from experiments.avoidance_fields import Field, figure_9, random_field
from experiments.avoidance_pictures import draw_fields, draw_figure_4c, draw_figure_9
from experiments.avoidance_runs import PERIOD_S, Perception, Run, drive_field
from floor_perception.config import FloorDetectorConfig, TemplateConfig
from floor_perception.floor_detector import FloorDetector
from floor_perception.resources import load_camera_model
from floornav_common.reporting import Picture, Progress, Section, Table, UserError
from sjmc_planner.config import LocalPlannerConfig, OmniConfig
from sjmc_planner.methods import make_method
from sjmc_planner.planning import Method

MODES = ("omni_velocity", "omni_static")
SETTINGS = ("default", "paper")
CAMERA = "soccer_small_size"
RENDERED = {"samples": 1}
PAPER_RADIUS_PX = 95.0
NUM_FIELDS, NUM_QUICK = 200, 8
HEADER = [
    "template and rule", "mode", "runs", "collisions", "reached", "time s", "path m",
    "least clearance m", "clearance m (median)", "turn begins s",
]  # fmt: skip
Task = tuple[int, int, str, str]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to this experiment."""
    parser.add_argument(
        "--fields", type=int, default=NUM_FIELDS, metavar="N",
        help=f"random fields (default: {NUM_FIELDS})",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help=f"{NUM_QUICK} random fields only")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="processes (default: 2)")


def check(args: argparse.Namespace) -> None:
    """Refuse bad input before a folder is made."""
    if args.fields < 1 or args.jobs < 1:
        raise UserError(f"--fields and --jobs must be >= 1, got {args.fields} and {args.jobs}")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive all fields, write pictures, and return the report."""
    num = NUM_QUICK if args.quick else args.fields
    values["runs_of_each"] = num
    cases = [(setting, mode) for setting in SETTINGS for mode in MODES]
    tasks = [(args.seed, -1, *case) for case in cases]
    tasks += [(args.seed, number, *case) for case in cases for number in range(num)]
    runs: dict[Task, Run] = {}
    with Progress("velocity-avoidance", len(tasks), is_quiet=args.quiet) as progress:
        for task, done in _driven(tasks, args.jobs):
            runs[task] = done
            num_touched = sum(r.has_collided for r in runs.values())
            note = f"{len(runs)} of {len(tasks)} drives, {num_touched} touched something"
            progress.update(len(runs), note, is_last=len(runs) == len(tasks))
            _fill(values, runs)
    return _sections(args, values, runs)


def _driven(tasks: list[Task], jobs: int) -> Iterator[tuple[Task, Run]]:
    if jobs == 1:
        yield from ((task, _drive(task)) for task in tasks)
        return
    with ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_one_thread
    ) as pool:
        try:
            yield from zip(tasks, pool.map(_drive, tasks), strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _one_thread() -> None:
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import cv2

    cv2.setNumThreads(1)


def _drive(task: Task) -> Run:
    seed, number, setting, mode = task
    method = _method(setting, mode)
    return drive_field(_field(seed, number), method, _perception(setting), seed, RENDERED)


def _field(seed: int, number: int) -> Field:
    return figure_9() if number < 0 else random_field(seed, number)


def _method(setting: str, mode: str) -> Method:
    config = LocalPlannerConfig(method=mode, control_period_s=PERIOD_S)
    if setting == "paper":
        omni = OmniConfig(
            num_directions=32, num_speeds=1, keeps_stoppable=False, remembers_near=False
        )
        config = replace(config, omni=omni)
    return make_method(config)


def _perception(setting: str) -> Perception:
    camera = load_camera_model(CAMERA)
    config = FloorDetectorConfig()
    if setting == "paper":
        horizon = float(camera.camera.floor_distance(PAPER_RADIUS_PX))  # type: ignore[attr-defined]
        template = TemplateConfig(num_rings=6, num_directions=32, free_share=0.8, horizon_m=horizon)
        config = replace(config, template=template)
    detector = FloorDetector(camera, config)

    def see(image: np.ndarray, stamp_ns: int) -> Any:
        result = detector.detect(image, "rgb", stamp_ns)
        return None if result is None else result.scan

    return see


def _fill(values: dict[str, Any], runs: dict[Task, Run]) -> None:
    """Write what is known so far: the default's figures on top, the published ones in `paper`."""
    values.setdefault("paper", {})
    values.setdefault("figure_9", {"paper": {}})
    for setting in SETTINGS:
        for mode in MODES:
            mine = [r for t, r in runs.items() if t[2:] == (setting, mode)]
            random = [r for r in mine if r.field.name != "figure 9"]
            shown = [r for r in mine if r.field.name == "figure 9"]
            on_top = setting == "default"
            (values if on_top else values["paper"])[mode] = _figures(random)
            (values["figure_9"] if on_top else values["figure_9"]["paper"])[mode] = _figures(shown)
    values["turns_earlier"] = _turns(runs, "default")
    values["paper"]["turns_earlier"] = _turns(runs, "paper")


def _figures(runs: list[Run]) -> dict[str, Any]:
    there = [r for r in runs if r.is_reached]
    turns = [r.turn_start_s for r in runs if r.turn_start_s is not None]
    return {
        "collisions": sum(r.has_collided for r in runs),
        "runs": len(runs),
        "reached": len(there),
        "time_s": _median([r.time_s for r in there]),
        "path_m": _median([r.path_m for r in there]),
        "min_clearance_m": min((r.min_clearance_m for r in runs), default=None),
        "median_clearance_m": _median([r.min_clearance_m for r in runs]),
        "turn_start_s": _median(turns),
    }


def _turns(runs: dict[Task, Run], setting: str) -> dict[str, Any]:
    """Return in how many fields the turn begins earlier with velocity, and by how much."""
    leads = []
    for (seed, number, own, mode), aware in runs.items():
        static = runs.get((seed, number, setting, "omni_static"))
        if (own, mode) != (setting, "omni_velocity") or number < 0 or static is None:
            continue
        if aware.turn_start_s is not None and static.turn_start_s is not None:
            leads.append(static.turn_start_s - aware.turn_start_s)
    lead = np.round(np.array(leads), 3)
    return {
        "fields": len(lead), "earlier": int((lead > 0).sum()), "later": int((lead < 0).sum()),
        "mean_lead_s": float(lead.mean()) if len(lead) else None,
    }  # fmt: skip


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


def _sections(
    args: argparse.Namespace, values: dict[str, Any], runs: dict[Task, Run]
) -> list[Section]:
    by_case = {
        (setting, mode): [r for t, r in runs.items() if t[2:] == (setting, mode)]
        for setting in SETTINGS
        for mode in MODES
    }
    pictures = [
        draw_figure_4c(args.out_dir / "figure_4c.png"),
        *(
            draw_figure_9(
                args.out_dir / f"figure_9_{s}.png", s, {m: by_case[s, m][0] for m in MODES}
            )
            for s in SETTINGS
        ),
        draw_fields(args.out_dir / "fields.png", {m: by_case["default", m][1:7] for m in MODES}),
    ]
    tables = []
    for title, key in (("random fields", None), ("figure 9", "figure_9")):
        place = values if key is None else values[key]
        rows = [
            [setting, mode, *_row((place if setting == "default" else place["paper"])[mode])]
            for setting in SETTINGS
            for mode in MODES
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
