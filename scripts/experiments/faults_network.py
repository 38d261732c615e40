"""A line that loses and delays, between two hosts that are network namespaces.

The simulator and the judge are on one host, which is the robot; the nodes are on the other, its
computer. All that they say to each other goes over a cable of ours, frame by frame. Time is not
paced here, as a simulator that waits for commands would take the delay out again.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from _day_nodes import node_command
from experiments.faults_case import Fault
from experiments.faults_graph import FaultGraph
from experiments.faults_judge import OTHER
from experiments.faults_setups import Setup, hall
from experiments.network_hosts import TwoHosts, joined, link_command, why_not

NETWORK = "network"
_HOSTS = "FLOORNAV_FAULT_HOSTS"
_LOSS, _DELAY_S = "0.3", "0.2"
_EVALUATE = Path(__file__).resolve().parent.parent / "evaluate.py"
_LINK = "link"


def network_faults() -> list[Fault]:
    """Return the fault of the line."""
    return [
        Fault(
            name="lossy-network", kind=OTHER, hold_s=8.0,
            what="30 % of all frames lost, the others 200 ms late on average and out of order "
            "(a cable between two network namespaces)",
            expected="touches nothing: drives on what comes, or stands",
            strike=_with_link("--loss", _LOSS, "--delay", _DELAY_S, "--seed", "1"),
            mend=_with_link(),
        ),
    ]  # fmt: skip


def network() -> Setup:
    """Return the hall with its nodes on another host; to be called on the robot's own."""
    keeper = _hosts()["keeper"]

    def command(name: str, settings: Path) -> list[str]:
        return joined(keeper, node_command(name, settings))

    nodes = ("grid_mapper", "wavefront_planner", "local_planner")
    return replace(hall(), name=NETWORK, nodes=nodes, command=command, is_paced=False)


def start_link(graph: FaultGraph) -> None:
    """Let the cable carry everything, before the nodes start."""
    _carry(graph)


def is_inside() -> bool:
    """Whether this process is on the robot's host already."""
    return _HOSTS in os.environ


def why_no_network() -> str:
    """Return why there can be no such hosts here; "" if there can."""
    return why_not()


def run_on_hosts(args: Any, out: Path) -> dict[str, Any]:
    """Make two hosts, run the fault of the line there, and return what it found.

    Raises:
        RuntimeError: If it left no result.
    """
    hosts = TwoHosts()
    try:
        told = json.dumps({"keeper": hosts.keeper("b"), "cable": hosts.cable})
        words = ["faults", "--only", "lossy-network", "--seed", str(args.seed), "--out", str(out)]
        command = hosts.join("a", [sys.executable, str(_EVALUATE), *words])
        log = out.with_suffix(".log")
        with log.open("wb") as output:
            subprocess.run(command, env=_environ(told), stdout=output, stderr=subprocess.STDOUT)
    finally:
        hosts.remove()
    summary = out / "summary.json"
    if not summary.exists():
        raise RuntimeError(f"no result on the hosts: {log.read_text(errors='replace')[-300:]}")
    found: dict[str, Any] = json.loads(summary.read_text())
    return found


def _environ(told: str) -> dict[str, str]:
    return {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", _HOSTS: told}


def _hosts() -> Mapping[str, Any]:
    told: Mapping[str, Any] = json.loads(os.environ[_HOSTS])
    return told


def _with_link(*words: str) -> Any:
    return lambda graph: _carry(graph, *words)


def _carry(graph: FaultGraph, *words: str) -> None:
    """Put another cable in the place of the one there is."""
    if _LINK in graph.notes:
        graph.children.stop(_LINK)
    graph.notes[_LINK] = True
    graph.children.start(_LINK, link_command(_hosts()["cable"], *words))
