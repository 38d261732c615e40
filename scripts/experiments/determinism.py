"""The same recording mapped again and again, partly beside busy processes: the same bytes or not.

Each run is a process of its own: `map_bag RECORDING`. In the last `--loaded` runs `--busy`
processes compute for nothing beside it. Compared are the map, its picture, the trajectory and the
session (the graph with all its loops). Times are not compared, they are shown.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from floornav_common.arguments import count, natural
from floornav_common.reporting import Progress, Section, Table, UserError

RECORDING = Path("../shared/data/intel-lab/intel_keyframes_rawodom_corrected.log.gz")
FILES = ("map.pgm", "map.yaml", "map.png", "trajectory.tum", "run.session")
BUSY = "while True: pass"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what only this experiment takes."""
    add = parser.add_argument
    add("--recording", type=Path, default=RECORDING, metavar="FILE", help=f"({RECORDING})")
    add("--runs", type=count, default=10, metavar="N", help="runs in all (10)")
    add("--loaded", type=natural, default=4, metavar="N", help="of them beside busy processes (4)")
    add("--busy", type=count, default=os.cpu_count() or 1, metavar="N",
        help="busy processes (one a core)")  # fmt: skip
    add("--max-scans", type=count, default=None, metavar="N", help="stop each run after N scans")


def check(args: argparse.Namespace) -> None:
    """Refuse what cannot be done.

    Raises:
        UserError: It cannot.
    """
    if args.runs < 2 or args.loaded > args.runs:
        raise UserError("--runs must be >= 2, and --loaded from 0 to --runs")
    if not args.recording.exists():
        raise UserError(f"there is no recording {args.recording}: name one with --recording")


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Map the recording again and again; fills `values["identical"]` and `values["runs"]`."""
    values |= {"identical": None, "recording": str(args.recording), "runs": []}
    runs = values["runs"]
    with Progress("determinism", args.runs, is_quiet=args.quiet) as progress:
        for number in range(args.runs):
            num_busy = args.busy if number >= args.runs - args.loaded else 0
            runs.append(_one_run(args, number, num_busy))
            progress.update(number + 1, f"{len(differing(runs))} files differ")
    values["differing"] = differing(runs)
    values["identical"] = not values["differing"]
    rows = [[str(k + 1), str(r["busy"]), f"{r['wall_s']:.0f}", r["digests"]["trajectory.tum"][:12],
             r["digests"]["map.pgm"][:12]] for k, r in enumerate(runs)]  # fmt: skip
    header = ["run", "busy processes", "s", "SHA-256 of trajectory.tum", "of map.pgm"]
    found = "Identical bytes." if values["identical"] else f"Differ: {values['differing']}"
    return [Section("Runs", [__doc__ or "", Table(header, rows), found])]


def differing(runs: list[dict[str, Any]]) -> list[str]:
    """Return the files that are not the same in all runs."""
    return [name for name in FILES if len({run["digests"][name] for run in runs}) > 1]


def _one_run(args: argparse.Namespace, number: int, num_busy: int) -> dict[str, Any]:
    out = args.out_dir / f"run-{number + 1}"
    command = [sys.executable, "-m", "grid_mapper.map_bag", str(args.recording), "--quiet",
               "--out", str(out), "--save-session", str(args.out_dir / "run.session")]  # fmt: skip
    if args.max_scans is not None:
        command += ["--max-scans", str(args.max_scans)]
    started = time.monotonic()
    busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(num_busy)]
    try:
        subprocess.run(command, check=True)
    finally:
        for process in busy:
            process.kill()
            process.wait()
    (args.out_dir / "run.session").replace(out / "run.session")
    return {
        "busy": num_busy,
        "wall_s": time.monotonic() - started,
        "digests": {name: _digest(out / name) for name in FILES},
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
