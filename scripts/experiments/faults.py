"""Faults in the running graph: what the robot does, how soon it stands, how soon it drives again.

Every node is a process of its own over DDS; a relay of ours sits between the simulator and the
nodes and does to messages what a fault asks for. The robot drives when a fault strikes. Judged is
what arrives at the simulator as `cmd_vel` and how the robot truly moves, in simulated time.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from typing import Any

from _demo_domain import join_domain
from _processes import ChildDiedError
from experiments.faults_case import Fault, run_fault
from experiments.faults_graph import FaultGraph, GraphError
from experiments.faults_network import (
    NETWORK,
    is_inside,
    network,
    network_faults,
    run_on_hosts,
    start_link,
    why_no_network,
)
from experiments.faults_page import faults_page
from experiments.faults_pictures import draw_speeds, write_trace
from experiments.faults_result import Row
from experiments.faults_rows import other_sensor_faults, scan_faults, traffic_faults
from experiments.faults_rows_clock import clock_faults
from experiments.faults_rows_field import camera_faults
from experiments.faults_rows_files import file_faults
from experiments.faults_rows_nodes import company_faults, process_faults, simulator_fault
from experiments.faults_rows_told import told_faults
from experiments.faults_setups import Setup, field, hall
from floornav_common.arguments import positive
from floornav_common.reporting import Figures, Picture, Section, Table, UserError, say, write_atomic

_HEADS = [
    "fault", "what", "expected", "seen", "stop ms", "stands after s", "drives again after s",
    "lost", "passed",
]  # fmt: skip
_CAPTION = (
    "Speed over time, m/s and s, from when the fault begins. Blue: commands that arrived at the "
    "simulator; black: the robot's true speed; ground: the fault; red: when it had to stop."
)


def all_faults(seed: int = 0) -> dict[str, list[Fault]]:
    """Return the faults of each graph in the order they are run."""
    return {
        "hall": [
            *scan_faults(), *other_sensor_faults(), *traffic_faults(seed), *clock_faults(),
            *told_faults(), *company_faults(), *file_faults(seed), *process_faults(),
            simulator_fault(),
        ],
        "field": camera_faults(),
        NETWORK: network_faults(),
    }  # fmt: skip


_QUICK = (
    "scan-silent", "nan-odom", "nan-ranges", "tf-silent", "clock-back", "clock-stands", "nan-goal",
    "second-cmd_vel", "tf-missing", "disk-full", "fuzz-live", "kill-local_planner",
    "sigterm-wavefront_planner", "image-black",
)  # fmt: skip
"""One of each kind of fault and of expectation."""
_SETUPS = {"hall": hall, "field": field, NETWORK: network}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these faults alone")
    parser.add_argument("--quick", action="store_true", help="one fault of each kind")
    text = "simulated seconds in a second at most (1); less for a machine that is busy"
    parser.add_argument("--rtf", type=positive, default=1.0, metavar="F", help=text)
    parser.add_argument("--list", action="store_true", help="name the faults and end")


def check(args: argparse.Namespace) -> None:
    """Look at the input before anything is made.

    Raises:
        UserError: If there is no such fault, or the user's ROS domain has a `/clock` already.
    """
    faults = [fault for some in all_faults().values() for fault in some]
    unknown = [name for name in args.only or () if name not in {f.name for f in faults}]
    if unknown:
        raise UserError(f"no fault named {', '.join(unknown)}; --list names them")
    if args.list:
        for fault in faults:
            print(f"{fault.name:28s} {fault.what}")
        raise SystemExit(0)
    if not 0.0 < args.rtf <= 1.0:
        raise UserError(f"--rtf must be in (0, 1], got {args.rtf}")
    if problem := join_domain():
        raise UserError(problem)


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run the faults; fills `values["faults"]`, `values["passed"]` and `values["total"]`."""
    rows: list[Row] = []
    values |= {"faults": [], "passed": 0, "total": 0, "sim_s": 0.0, "graphs_started": 0}
    for name, faults in all_faults(args.seed).items():
        wanted = args.only or (_QUICK if args.quick else [f.name for f in faults])
        chosen = [fault for fault in faults if fault.name in wanted]
        if chosen and name == NETWORK and not is_inside():
            _run_network(args, values, rows)
            continue
        while chosen:
            chosen = _run_graph(_SETUPS[name](), chosen, args, values, rows)
    values["ok"] = values["passed"] == values["total"]
    page = faults_page(rows, values["sim_s"], machine(args.rtf))
    write_atomic(args.out_dir / "faults.md", page)
    picture = args.out_dir / "speeds.png"
    draw_speeds(picture, rows)
    table = Table(_HEADS, [_cells(row) for row in rows])
    figures = Figures([("passed", f"{values['passed']} of {values['total']}")])
    return [Section("Faults", [figures, __doc__ or "", table, Picture(picture, _CAPTION)])]


def _run_graph(
    setup: Setup, faults: list[Fault], args: argparse.Namespace, values: dict[str, Any],
    rows: list[Row],
) -> list[Fault]:  # fmt: skip
    """Run faults one after the other in one graph; return those left when it is of no use more."""
    values["graphs_started"] += 1
    out = args.out_dir / f"{setup.name}-{values['graphs_started']}"
    with FaultGraph(setup, out, args.seed, args.rtf) as graph:
        if setup.name == NETWORK:
            start_link(graph)
        graph.start(lambda text: say(text, is_quiet=args.quiet))
        left = list(faults)
        while left:
            fault = left.pop(0)
            try:
                rows.append(run_fault(graph, fault))
            except (GraphError, ChildDiedError) as error:
                rows.append(_failed(fault, setup, str(error)))
            _fill(values, rows)
            if rows[-1].trace is not None:
                write_trace(args.out_dir / "traces" / f"{fault.name}.csv", rows[-1].trace)
            say(_line(rows[-1]), is_quiet=args.quiet)
            if not rows[-1].recovered:
                break
        values["sim_s"] += graph.sim_s
    return left


def _run_network(args: argparse.Namespace, values: dict[str, Any], rows: list[Row]) -> None:
    """Run the fault of the line on hosts of its own; where none can be made, it is left out."""
    values["network"] = why_no_network() or "run"
    if values["network"] != "run":
        say(f"left out, lossy-network: {values['network']}", is_quiet=args.quiet)
        return
    say("lossy-network runs on two hosts of its own ...", is_quiet=args.quiet)
    found = run_on_hosts(args, args.out_dir / NETWORK)
    for told in found["faults"]:
        rows.append(Row(**{key: value for key, value in told.items() if key != "passed"}))
        say(_line(rows[-1]), is_quiet=args.quiet)
    values["sim_s"] += found["sim_s"]
    _fill(values, rows)


def _failed(fault: Fault, setup: Setup, text: str) -> Row:
    row = Row(fault.name, fault.what, fault.expected, text, safe=False, recovered=False)
    row.kind, row.graph = fault.kind, setup.name
    return row


def machine(rtf: float) -> str:
    """Return how fast time went, how many cores there are, and how busy they were."""
    cores, busy = len(os.sched_getaffinity(0)), os.getloadavg()[2]
    load = f"on average {busy:.0f} processes that wanted one"
    return f"at most {rtf:g} times real time, {cores} cores, {load}"


def _fill(values: dict[str, Any], rows: list[Row]) -> None:
    values["faults"] = [_plain(row) for row in rows]
    found = Counter(row.passed for row in rows)
    values["passed"], values["total"] = found[True], len(rows)


def _plain(row: Row) -> dict[str, Any]:
    kept = {key: value for key, value in vars(row).items() if key != "trace"}
    return {**kept, "passed": row.passed}


def _line(row: Row) -> str:
    stop = "" if row.stop_ms is None else f", {row.stop_ms:.0f} ms"
    again = "never" if row.recover_s is None else f"{row.recover_s:.1f} s"
    word = "passed" if row.passed else "FAILED"
    return f"{word}  {row.name}: {row.seen}{stop}; drives again after {again}; lost: {row.lost}"


def _cells(row: Row) -> list[Any]:
    passed = "yes" if row.passed else "NO"
    figures = [row.stop_ms, row.stand_s, row.recover_s]
    rounded = [None if v is None else round(v, 2) for v in figures]
    return [row.name, row.what, row.expected, row.seen, *rounded, row.lost or "nothing", passed]
