"""The same bag live and offline: what the node uses of it over DDS, and how equal the maps are.

`replay.py` plays the bag as it was recorded into a running `grid_mapper`, each a process of its
own; `map_bag.py` maps it in lockstep. The counts are the node's own, from /diagnostics; the live
map is the one it saves at the end.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from _processes import Processes, free_domain
from _saying import saying
from floornav_common.arguments import positive
from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.reporting import Section, Table, UserError
from grid_mapper.config import GridMapperConfig
from grid_mapper.map_files import load_map
from grid_mapper.mapper import GridMapper
from grid_mapper.recordings import open_recording
from grid_mapper.recordings.bag import Bag
from grid_mapper.recordings.bag_choice import choose_scan_topic
from grid_mapper.recordings.events import RecordingError, RecordingOptions, ScanEvent

SCRIPTS = Path(__file__).resolve().parent.parent


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    parser.add_argument("--bag", nargs="+", type=Path, required=True, help="rosbag2 recordings")
    parser.add_argument("--rate", type=positive, default=1.0, metavar="R", help="speed (1)")


def check(args: argparse.Namespace) -> None:
    """Look at the input before anything is made.

    Raises:
        UserError: If a bag is missing, cannot be read or has no scans, or two have one name.
    """
    missing = [str(bag) for bag in args.bag if not bag.exists()]
    if missing:
        raise UserError(f"no such recording: {', '.join(missing)}")
    if len({bag.stem for bag in args.bag}) < len(args.bag):
        raise UserError("two recordings have the same name, and results are named after them")
    try:
        for bag in args.bag:
            _scan_topic(bag)
    except RecordingError as error:
        raise UserError(str(error)) from error


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Map every bag both ways; fills `values["bags"]`."""
    values["bags"] = {}
    for number, bag in enumerate(args.bag, start=1):
        name = f"{bag.name} ({number} of {len(args.bag)})"
        with saying(f"{name}: mapping offline ...", is_quiet=args.quiet):
            offline = _offline(bag)
        with saying(f"{name}: mapping live, x {args.rate:g} ...", is_quiet=args.quiet):
            live = _live(bag, _scan_topic(bag), args.rate, args.out_dir / bag.stem)
        values["bags"][bag.stem] = _compare(offline, live)
    keys = ("scans", "received", "used", "used_share", "dropped", "same_share", "occupied_same")
    rows = [[name, *(_cell(f[k]) for k in keys)] for name, f in values["bags"].items()]
    return [Section("Live beside offline", [__doc__ or "", Table(["bag", *keys], rows)])]


def _cell(value: float | int) -> str:
    return f"{value:.4f}" if isinstance(value, float) else str(value)


def _offline(bag: Path) -> dict[str, Any]:
    recording = open_recording(bag, RecordingOptions())
    mapper = GridMapper(GridMapperConfig())
    num_used = 0
    for event in recording.events():
        if isinstance(event, ScanEvent):
            num_used += 1
            mapper.insert_scan(event.stamp_ns, event.scan, event.T_base_laser, event.T_odom_base)
    return {
        "scans": recording.counts.scans,
        "used": num_used,
        "map": mapper.occupancy(),
    }


def _scan_topic(path: Path) -> str:
    with Bag(path) as bag:
        return choose_scan_topic(bag, RecordingOptions())[0]


def _live(bag: Path, scan_topic: str, rate: float, folder: Path) -> dict[str, Any]:
    """Play a bag into a node and return its counts and its map."""
    folder.mkdir(parents=True)
    domain = free_domain()
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain), "PYTHONUNBUFFERED": "1"}
    with Processes(folder / "logs", env) as processes, _Listener(domain) as listener:
        processes.start("grid_mapper", [
            sys.executable, str(SCRIPTS / "run_node.py"), "grid_mapper", "grid_mapper",
            "--ros-args", "-p", "use_sim_time:=true", "-r", f"scan:={scan_topic}",
            "-p", f"map_file:={folder / 'live'}",
        ])  # fmt: skip
        processes.wait_for_line("grid_mapper", "ready", 120.0, listener.spin)
        started = time.monotonic()
        replay = [sys.executable, str(SCRIPTS / "replay.py"), str(bag), "--rate", str(rate)]
        processes.start("replay", [*replay, "--quiet", "--wait", "10"])
        while processes.exit_code("replay") is None:
            processes.check(may_end=["replay"])
            listener.spin()
            if time.monotonic() - started > 3600.0:
                raise RuntimeError(f"replay of {bag} does not end")
        processes.check(may_end=["replay"])
        for _ in range(20):  # the last scans and one more round of diagnostics
            listener.spin()
        path = listener.save_map()
    return {**listener.counts, "map": load_map(path)}


class _Listener:
    """Hears the node's diagnostics and asks it to save its map."""

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self.counts: dict[str, int] = {}

    def __enter__(self) -> _Listener:
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from std_srvs.srv import Trigger

        rclpy.init(domain_id=self._domain)
        self._node = rclpy.create_node("live_mapping")
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 50)
        self._save = self._node.create_client(Trigger, "grid_mapper/save_map")
        return self

    def __exit__(self, *_: object) -> None:
        import rclpy

        self._node.destroy_node()
        rclpy.try_shutdown()

    def spin(self) -> None:
        """Work for a tenth of a second."""
        import rclpy

        end = time.monotonic() + 0.1
        while time.monotonic() < end:
            rclpy.spin_once(self._node, timeout_sec=0.05)

    def save_map(self) -> Path:
        """Return the path of the map the node saved."""
        from std_srvs.srv import Trigger

        self._save.wait_for_service(10.0)
        future = self._save.call_async(Trigger.Request())
        for _ in range(200):
            self.spin()
            if future.done():
                break
        answer = future.result()
        if answer is None or not answer.success:
            raise RuntimeError(f"save_map failed: {answer.message if answer else 'no answer'}")
        return Path(answer.message)

    def _on_diagnostics(self, msg: Any) -> None:
        wanted = {"received", "delivered", "dropped", "scans", "trusted"}
        for status in msg.status:
            if status.name.startswith("/grid_mapper: "):
                self.counts |= {v.key: int(v.value) for v in status.values if v.key in wanted}


def _compare(offline: dict[str, Any], live: dict[str, Any]) -> dict[str, Any]:
    same, occupied = _overlap(offline["map"], live["map"])
    return {
        "scans": offline["scans"],
        "offline_used": offline["used"],
        "received": live["received"],
        "used": live["scans"],
        "trusted": live["trusted"],
        "dropped": live["dropped"],
        "used_share": live["scans"] / max(1, offline["scans"]),
        "same_share": same,
        "occupied_same": occupied,
    }


def _overlap(a: OccupancyMap, b: OccupancyMap) -> tuple[float, float]:
    """Return the share of equal cells among those known in either map, and of occupied ones.

    Both maps lie on one grid of cells, so that they can be laid over each other without
    resampling.
    """
    corners = np.array([[m.origin.y, m.origin.x] for m in (a, b)]) / a.resolution
    first = np.rint(corners.min(axis=0)).astype(int)
    starts = np.rint(corners).astype(int) - first
    shapes = [np.array(m.cells.shape) for m in (a, b)]
    size = np.max([s + shape for s, shape in zip(starts, shapes, strict=True)], axis=0)
    planes = []
    for m, (row, col) in zip((a, b), starts, strict=True):
        plane = np.full(size, UNKNOWN, np.int8)
        plane[row : row + m.cells.shape[0], col : col + m.cells.shape[1]] = m.cells
        planes.append(plane)
    known = (planes[0] != UNKNOWN) | (planes[1] != UNKNOWN)
    walls = (planes[0] == OCCUPIED) | (planes[1] == OCCUPIED)
    equal = planes[0] == planes[1]
    return float(equal[known].mean()), float(equal[walls].mean())
