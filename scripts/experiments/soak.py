"""The flat on a day with people in it, its goals round and round: memory, exceptions, touches.

The graph of `demo.py flat_day`, every node a process of its own over DDS, for simulated minutes.
Memory is what a process holds (RSS); its growth is from the end of the first fifth, when maps and
caches are there, to the end.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from _day_load import resident_mb
from _day_nodes import BUILDING, STEREO_NODES, node_command, node_names, write_settings
from _demo_domain import join_domain
from experiments.faults_graph import EXCEPTION, FaultGraph, GraphError
from experiments.faults_setups import Setup
from experiments.goal_drives import GOAL_LIMIT_S
from experiments.stereo_world_map import map_of_world
from floornav_common.arguments import positive
from floornav_common.reporting import Picture, Progress, Section, Table, UserError, say
from multi_localizer.voxel_map import save_voxel_map
from sim_bridge.robot_model import RobotModel, load_robot
from sim_bridge.world import World, load_world

_WORLD = "flat_day"
_LOOK_S = 5.0
_SETTLED = 0.2
_VOXEL_CELL_M = 0.02


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument(
        "--minutes", type=positive, default=30.0, metavar="M", help="simulated (30)"
    )


def check(args: argparse.Namespace) -> None:
    """Look at the input before anything is made.

    Raises:
        UserError: If the user's ROS domain has a `/clock` already.
    """
    if problem := join_domain():
        raise UserError(problem)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Drive; fills `minutes`, `collisions`, `rss_growth_mb`, `exceptions` and more."""
    values |= {"minutes": 0.0, "collisions": None, "rss_growth_mb": None, "exceptions": None}
    memory: dict[str, list[tuple[float, float]]] = defaultdict(list)
    with FaultGraph(_flat(), args.out_dir, args.seed) as graph:
        graph.start(lambda text: say(text, is_quiet=args.quiet))
        graph.watch.goal_limit_s = GOAL_LIMIT_S
        problem = _drive(graph, args, memory)
        values["minutes"] = graph.sim_s / 60.0
        values["collisions"] = len(graph.watch.record.touches)
        values["goals_reached"] = graph.watch.number - graph.watch.num_left
        values["goals_left"] = graph.watch.num_left
        values["goals_sent_again"] = graph.watch.num_goals_again
    values["exceptions"] = graph.count_logged(EXCEPTION)
    values["rss_growth_of"] = {name: growth_mb(looks) for name, looks in memory.items()}
    values["rss_growth_mb"] = sum(values["rss_growth_of"].values())
    values["problem"] = problem or None
    values["ok"] = not (problem or values["collisions"] or values["exceptions"])
    _draw(args.out_dir / "memory.png", memory)
    return [_section(values, args.out_dir / "memory.png")]


def growth_mb(looks: list[tuple[float, float]]) -> float:
    """Return how much a process grew after its first fifth, from (time, MiB), MiB.

    Both ends are medians of a tenth of the looks, so that one that was high for a moment is none.
    """
    sizes = np.array([size for _, size in looks])
    if not len(sizes):
        return 0.0
    first, num = int(_SETTLED * len(sizes)), max(1, len(sizes) // 10)
    return float(np.median(sizes[-num:]) - np.median(sizes[first : first + num]))


def _flat() -> Setup:
    world = load_world(_WORLD)
    assert world.goals is not None
    return Setup(
        name="flat_day", world=_WORLD, nodes=tuple(node_names(load_robot(world.robots[0]))),
        topics=("/clock",), frame="map", goals=np.array(world.goals.points_m), speed=0.3,
        room_m=0.0, decel=0.6, has_map=True, scan_topic="scan", write=_write,
        command=node_command,
    )  # fmt: skip


def _write(folder: Path, world: World, model: RobotModel) -> Path:
    settings = write_settings(folder, world, model)
    if STEREO_NODES[-1] in node_names(model):
        made = map_of_world(_WORLD, cell=_VOXEL_CELL_M)
        save_voxel_map(folder / "voxel_map.npz", replace(made, frame=BUILDING))
    return settings


def _drive(graph: FaultGraph, args: argparse.Namespace, memory: dict[str, Any]) -> str:
    """Go round until the time is over; return what ended it sooner, "" for nothing."""
    total_s = 60.0 * args.minutes
    with Progress("soak", total_s, is_quiet=args.quiet) as bar:
        while graph.sim_s < total_s:
            try:
                graph.spin_sim(min(_LOOK_S, max(total_s - graph.sim_s, 0.1)))
            except GraphError as error:
                return str(error)
            for name, pid in graph.children.pids.items():
                status = Path(f"/proc/{pid}/status").read_text()
                memory[name].append((graph.sim_s, resident_mb(status)))
            text = f"{graph.sim_s:6.1f} s, {graph.watch.number} goals"
            bar.update(min(graph.sim_s, total_s), text)
    return ""


def _draw(path: Path, memory: dict[str, list[tuple[float, float]]]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.5))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, looks in memory.items():
        axes.plot(*np.array(looks).T / [[60.0], [1.0]], label=name)
    axes.set_xlabel("simulated minutes")
    axes.set_ylabel("RSS, MiB")
    axes.set_ylim(bottom=0.0)
    if memory:
        axes.legend(fontsize=8, ncol=2)
    figure.savefig(path, dpi=110, bbox_inches="tight")


def _section(values: dict[str, Any], picture: Path) -> Section:
    keys = ("minutes", "goals_reached", "goals_left", "collisions", "exceptions", "rss_growth_mb")
    main = Table(list(keys), [[_cell(values[key]) for key in keys]])
    rows = [[name, _cell(grown)] for name, grown in values["rss_growth_of"].items()]
    nodes = Table(["process", "growth MiB"], rows)
    blocks = [__doc__ or "", main, nodes, Picture(picture, "What each process holds.")]
    return Section("Soak", blocks + ([values["problem"]] if values["problem"] else []))


def _cell(value: float | None) -> float | None:
    return None if value is None else round(value, 2)
