"""The faults of files and settings, while the robot drives: it must not notice."""

from __future__ import annotations

import os
import resource
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from experiments.faults_case import Act, Fault
from experiments.faults_files import (
    Attempt,
    module_command,
    try_starts,
    write_maps,
    write_worlds,
)
from experiments.faults_fuzz import NODES, as_words, draw_set, try_set
from experiments.faults_graph import FaultGraph, set_parameters
from experiments.faults_judge import DRIVE

_MAPPER = "grid_mapper"
_DISK = "4k"
_FILE_BYTES = 1024
_NUM_SETS, _NUM_STARTS, _SETS_AT_ONCE = 1000, 9, 10
_STARTED = (
    "grid_mapper grid_mapper",
    "sjmc_planner local_planner",
    "sjmc_planner wavefront_planner",
)
_OF_RCLPY = "Wrong parameter type"
"""What rclpy itself says, before a node is asked; whoever sets knows the name by its place."""
_ON = "the robot drives on"


def file_faults(seed: int) -> list[Fault]:
    """Return the faults of files and settings."""
    return [
        Fault(
            name="disk-full", what=f"disk full while the map is saved ({_how_full()})", kind=DRIVE,
            expected=f"the service says so in one line, no half file stays; {_ON}",
            strike=_save_to_full_disk, mend=_free_disk, check=_was_refused, after=_saves,
            hold_s=1.0,
        ),
        Fault(
            name="malformed-worlds", what="sim_bridge is started on malformed worlds",
            kind=DRIVE, expected=f"each ends with 2 and one line; {_ON}",
            strike=_starting(_world_commands), check=_no_problems, hold_s=0.5,
        ),
        Fault(
            name="malformed-maps", what="grid_mapper is started on malformed maps", kind=DRIVE,
            expected=f"each ends with 2 and one line; {_ON}",
            strike=_starting(_map_commands), check=_no_problems, hold_s=0.5,
        ),
        Fault(
            name="fuzz-settings", kind=DRIVE, hold_s=0.5,
            what=f"{_NUM_SETS} sets of parameters drawn for all nodes, built as the nodes do (in "
            f"this process), and {_NUM_STARTS} of them given to nodes that are started",
            expected=f"refused in one line that names a parameter, or taken; {_ON}",
            strike=_fuzz(seed), check=_no_problems,
        ),
        Fault(
            name="fuzz-live", what="values that cannot be are set on the nodes that run",
            expected=f"each refused with the parameter's name, or as of a wrong type; {_ON}",
            kind=DRIVE,
            strike=_set_nonsense, check=_no_problems, hold_s=0.5,
        ),
    ]  # fmt: skip


def _can_mount() -> bool:
    return os.geteuid() == 0 and Path("/bin/mount").exists()


def _how_full() -> str:
    if _can_mount():
        return f"a file system of {_DISK}"
    return f"files of grid_mapper may hold {_FILE_BYTES} bytes: nothing may be mounted here"


def _save_to_full_disk(graph: FaultGraph) -> None:
    folder = graph.notes["disk"] = graph.out / "full"
    folder.mkdir(exist_ok=True)
    pid = graph.children.pids[_MAPPER]
    if _can_mount():
        size = ["mount", "-t", "tmpfs", "-o", f"size={_DISK}", "tmpfs", str(folder)]
        subprocess.run(size, check=True)
        graph.notes["mounted"] = True
    else:
        _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (_FILE_BYTES, most))
    set_parameters(graph, _MAPPER, map_file=str(folder / "map"))
    graph.notes["answer"] = graph.call(f"{_MAPPER}/save_map")
    graph.notes["left"] = sorted(path.name for path in folder.iterdir())


def _free_disk(graph: FaultGraph) -> None:
    if graph.notes.pop("mounted", False):
        subprocess.run(["umount", str(graph.notes["disk"])], check=True)
    else:
        _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
        pid = graph.children.pids[_MAPPER]
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, most))
    set_parameters(graph, _MAPPER, map_file=str(graph.out / "saved"))


def _was_refused(graph: FaultGraph) -> str:
    answer, left = graph.notes["answer"], graph.notes["left"]
    if answer.success or not answer.message or "\n" in answer.message:
        return f"save_map answers {answer.success}: {answer.message!r}"
    return f"half files stay: {left}" if left else ""


def _saves(graph: FaultGraph) -> str:
    answer = graph.call(f"{_MAPPER}/save_map")
    is_there = answer.success and Path(answer.message).exists()
    return "" if is_there else f"afterwards save_map says {answer.message!r}"


def _starting(commands: Any) -> Act:
    """Return what starts nodes that should be refused, while the robot drives."""

    def strike(graph: FaultGraph) -> None:
        some = commands(graph)
        name = next(iter(some)).partition("-")[0]
        attempts = try_starts(some, graph.out / f"tried-{name}", lambda: graph.spin(0.05))
        graph.notes["problems"] = [a.problem for a in attempts if a.problem]

    return strike


def _world_commands(graph: FaultGraph) -> dict[str, list[str]]:
    worlds = write_worlds(graph.out / "worlds")
    module = "sim_bridge.nodes.sim_bridge_node"
    return {
        f"world-{name}": module_command(module, "-p", f"world:={path}")
        for name, path in worlds.items()
    }


def _map_commands(graph: FaultGraph) -> dict[str, list[str]]:
    maps = write_maps(graph.out / "maps")
    module = "grid_mapper.nodes.grid_mapper_node"
    return {
        f"map-{name}": module_command(module, "-p", f"start_map:={path}")
        for name, path in maps.items()
    }


def _no_problems(graph: FaultGraph) -> str:
    problems = graph.notes["problems"]
    more = f" and {len(problems) - 3} more" if len(problems) > 3 else ""
    return "; ".join(problems[:3]) + more


def _fuzz(seed: int) -> Act:
    def strike(graph: FaultGraph) -> None:
        rng = np.random.default_rng(seed)
        problems = []
        for k, node in enumerate(_cycled(sorted(NODES), _NUM_SETS)):
            _, problem = try_set(node, draw_set(rng, node))
            problems += [problem] if problem else []
            if k % _SETS_AT_ONCE == 0:
                graph.spin(0.005)
        commands = {
            f"fuzz-{k}": module_command(_module(node), *as_words(draw_set(rng, node)))
            for k, node in enumerate(_cycled(_STARTED, _NUM_STARTS))
        }
        attempts = list(try_starts(commands, graph.out / "tried-fuzz", lambda: graph.spin(0.05)))
        graph.notes["problems"] = problems + [p for p in map(_fuzz_problem, attempts) if p]

    return strike


def _fuzz_problem(attempt: Attempt) -> str:
    """Return what is wrong with a start that may also run."""
    return "" if attempt.code is None and "Traceback" not in attempt.text else attempt.problem


def _module(node: str) -> str:
    package, name = node.split()
    return f"{package}.nodes.{name}_node"


def _cycled(nodes: Iterable[str], num: int) -> list[str]:
    names = list(nodes)
    return [names[k % len(names)] for k in range(num)]


def _set_nonsense(graph: FaultGraph) -> None:
    nan = float("nan")
    wrong: dict[str, dict[str, Any]] = {
        "local_planner": {"lookahead_m": nan, "scan_timeout_s": -1.0, "method": "none"},
        "grid_mapper": {"scan_timeout_s": 0.0, "map_mode": "x", "map_file": 3},
        "wavefront_planner": {"radius_m": nan, "margin_m": -1.0, "near_weight": "much"},
        "sim_bridge": {"real_time_factor": nan, "paused": 2, "step_s": 1e9},
    }
    problems = graph.notes["problems"] = []
    for node, values in wrong.items():
        for (name, _), answer in zip(
            values.items(), set_parameters(graph, node, **values), strict=True
        ):
            if answer.successful:
                problems.append(f"{node} takes {name} = {values[name]!r}")
            elif name not in answer.reason and _OF_RCLPY not in answer.reason:
                problems.append(f"{node} refuses {name} without its name: {answer.reason!r}")
