"""The whole graph of the flat: processor share and memory of nodes, and sensor-to-command time.

Busy: every node hears its sensors at their nominal rates (`demo.py flat_day`'s robot, driven by
goals). Idle: the same processes, and nothing comes. Start-up: from the start of a process until its
first message, the simulator running. One row a node; ms are processor time in each second. The
peer is the same with rclpy's SingleThreadedExecutor in place of the one that is used.

`scan_to_cmd_vel`: from the publishing of a scan of 1081 beams at 40 Hz to the first command
decided after it, in the reader's process. Its floor is a node that answers each scan with a
constant command.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.timing import Case, median_and_p99

WORLD = "flat_day"
BUSY_S, IDLE_S, LATENCY_S = 30.0, 10.0, 20.0
_FIRST_OF = {
    "grid_mapper": "pose", "wavefront_planner": "path", "local_planner": "planner/state",
    "floor_detector": "floor/free_space", "marker_detector": "bearings/robots",
    "stereo_matcher": "stereo/front/disparity", "stereo_localizer": "stereo_pose/candidates",
}  # fmt: skip
_START_TIMEOUT_S = 240.0
_VOXEL_CELL_M = 0.02
EXECUTORS = ("events", "single")


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return the cases."""
    late: dict[str, np.ndarray] = {}
    for answerer in (*EXECUTORS, "floor"):
        say(f"graph: scan to command, {LATENCY_S:.0f} s, {answerer}")
        late[answerer] = _delays_ms(answerer)
    median, p99 = median_and_p99(late["events"])
    peer = median_and_p99(late["single"])
    extra = {
        "scans": len(late["events"]), "peer_p99_ms": peer[1],
        "floor_p99_ms": median_and_p99(late["floor"])[1],
    }  # fmt: skip
    floor = float(np.median(late["floor"]))
    cases = [Case("scan_to_cmd_vel", median, p99, _PEER, peer[0], floor, extra)]
    found = {name: _graph(seed, name, say) for name in EXECUTORS}
    for node, ours in found["events"].items():
        busy, theirs = median_and_p99(ours["busy_ms"]), found["single"][node]
        peer_busy = float(np.median(theirs["busy_ms"]))
        more = {
            "idle_ms": ours["idle_ms"], "peer_idle_ms": theirs["idle_ms"], "rss_mb": ours["rss_mb"],
            "first_output_s": ours["first_s"],
        }  # fmt: skip
        cases.append(Case(node, *busy, _PEER, peer_busy, None, more))
    idle = {k: sum(node["idle_ms"] for node in v.values()) for k, v in found.items()}
    cases.append(Case("all nodes, idle", idle["events"], idle["events"], _PEER, idle["single"]))
    return cases


_PEER = "SingleThreadedExecutor"
_SINGLE = (
    "import runpy, sys; import floornav_common.ros.main as m; "
    "from rclpy.executors import SingleThreadedExecutor as E; m.make_executor = E; "
    "name = sys.argv[1]; sys.argv = sys.argv[1:]; runpy.run_module(name, run_name='__main__')"
)


def _with_executor(command: list[str], executor: str) -> list[str]:
    """Return a command `python -m MODULE ...` that runs with an executor."""
    python, _, module, *words = command
    return command if executor == "events" else [python, "-c", _SINGLE, module, *words]


def _delays_ms(answerer: str) -> np.ndarray:
    """Run a planner, or what stands for the floor, beside a source of scans; return its delays."""
    settings = [
        "enable_stamped_cmd_vel:=true", "goal_source:=goal_pose", "method:=sjmc",
        "robot.drive:=differential", "robot.radius_m:=0.45", "robot.speed_m_s:=0.6",
    ]  # fmt: skip
    module, words = "sjmc_planner.nodes.local_planner_node", [
        "--ros-args", *(word for s in settings for word in ("-p", s)),
    ]  # fmt: skip
    if answerer == "floor":
        module, words = "experiments.graph_floor", []
    command = _with_executor([sys.executable, "-m", module, *words], answerer)
    scripts = str(Path(__file__).resolve().parent.parent)
    paths = [scripts, *filter(None, [os.environ.get("PYTHONPATH")])]
    env = dict(os.environ, ROS_DOMAIN_ID="102", PYTHONPATH=os.pathsep.join(paths))
    node = subprocess.Popen(
        command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        assert node.stdout is not None
        said = []
        while not said or "ready" not in said[-1]:
            said.append(node.stdout.readline())
            if node.poll() is not None or not said[-1]:
                raise RuntimeError(f"{module} did not start: {''.join(said)}")
        source = [sys.executable, "-m", "experiments.graph_inputs", str(LATENCY_S)]
        done = subprocess.run(source, env=env, capture_output=True, text=True, check=True)
    finally:
        node.terminate()
        node.wait()
    return np.array([float(line) for line in done.stdout.split()])


def _graph(seed: int, executor: str, say: Callable[[str], None]) -> dict[str, dict[str, Any]]:
    """Run the graph and return what each node took.

    Returns:
        By node: `busy_ms` of each second, `idle_ms` a second, `rss_mb`, `first_s`.
    """
    from _day_load import LoadMeter
    from _day_nodes import BUILDING, node_command, node_names, write_settings
    from _day_watch import DayWatch
    from _watched import watched
    from experiments.stereo_world_map import map_of_world
    from multi_localizer.voxel_map import save_voxel_map
    from sim_bridge.robot_model import load_robot
    from sim_bridge.world import load_world

    world = load_world(WORLD)
    model, names = load_robot(world.robots[0]), node_names(load_robot(world.robots[0]))
    assert world.goals is not None
    goals = world.robots[0].pose.inverse() @ np.array(world.goals.points_m)
    found: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        settings = write_settings(Path(folder) / "nodes", world, model)
        voxels = replace(map_of_world(WORLD, cell=_VOXEL_CELL_M), frame=BUILDING)
        save_voxel_map(Path(folder) / "nodes" / "voxel_map.npz", voxels)
        make_watch = lambda: DayWatch(model, goals, 60.0)  # noqa: E731
        with watched(make_watch, Path(folder) / "logs") as (watch, children, spin):
            words = (f"world:={WORLD}", f"seed:={seed}", "real_time_factor:=1.0")
            simulator = [
                sys.executable, "-m", "sim_bridge.nodes.sim_bridge_node", "--ros-args",
                *(word for w in words for word in ("-p", w)),
            ]  # fmt: skip
            children.start("sim_bridge", _with_executor(simulator, executor))
            children.wait_for_line("sim_bridge", "ready", _START_TIMEOUT_S, spin)
            for name in names:
                say(f"graph: {executor} executor: starting {name}")
                before, started = watch.latencies.counts[_FIRST_OF[name]], time.monotonic()
                children.start(name, _with_executor(node_command(name, settings), executor))
                while watch.latencies.counts[_FIRST_OF[name]] == before:
                    spin()
                    children.check()
                    if time.monotonic() - started > _START_TIMEOUT_S:
                        raise RuntimeError(f"{name}: nothing came on {_FIRST_OF[name]}")
                found[name] = {"first_s": time.monotonic() - started}
            say(f"graph: {executor} executor: busy for {BUSY_S:.0f} s, then idle")
            meter = LoadMeter()
            seconds = _each_second(meter, children, names, spin, BUSY_S)
            children.stop("sim_bridge")
            idle = _each_second(LoadMeter(), children, names, spin, IDLE_S)
            for name in names:
                found[name].update(
                    busy_ms=seconds[name], idle_ms=float(np.mean(idle[name])),
                    rss_mb=meter.loads[name].rss_mb,
                )  # fmt: skip
    return found


def _each_second(
    meter: Any, children: Any, names: list[str], spin: Callable[[], None], seconds: float
) -> dict[str, np.ndarray]:
    """Return the processor time that each node took in each second, ms."""
    marks: list[dict[str, float]] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        looked = time.monotonic()
        meter.look({name: children.pids[name] for name in names})
        marks.append({name: meter.loads[name].cpu_s for name in names} | {"": looked})
        while time.monotonic() < looked + 1.0:
            spin()
    spans = np.diff([mark[""] for mark in marks])
    return {n: 1e3 * np.diff([mark[n] for mark in marks]) / spans for n in names}
