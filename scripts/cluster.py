"""A Dask cluster for `evaluate.py --cluster`: one scheduler, and workers on as many machines.

Whoever reaches the scheduler's port can run code on every worker: it listens on loopback unless
--host names an address of a network where that is all right.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from _environment import ensure_environment

if __name__ == "__main__":
    ensure_environment()

from floornav_common.arguments import count, natural
from floornav_common.reporting import UserError, run_command  # noqa: E402

PORT = 8786


def main(argv: list[str] | None = None) -> int:
    """Become the scheduler or the workers of this machine; Ctrl-C ends them."""
    args = _parsed(sys.argv[1:] if argv is None else argv)
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        line = f"{sys.executable} -m pip install distributed"
        raise UserError(f"a cluster needs a library that is not here: {line}") from error
    path = [str(Path(__file__).resolve().parent), os.environ.get("PYTHONPATH", "")]
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, path))}
    words = _words(args)
    os.execve(sys.executable, [sys.executable, "-m", *words], environ)


def _words(args: argparse.Namespace) -> list[str]:
    """Return the module of Dask and what it is told."""
    words = ["--host", args.host, "--no-dashboard"]
    if args.part == "scheduler":
        return ["distributed.cli.dask_scheduler", *words, "--port", str(args.port)]
    one_thread = ["--nworkers", str(args.number), "--nthreads", "1", "--memory-limit", "0"]
    return ["distributed.cli.dask_worker", args.address, *words, *one_thread]


def _parsed(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="cluster.py", description=__doc__)
    parts = parser.add_subparsers(dest="part", required=True)
    scheduler = parts.add_parser("scheduler", help="where evaluate.py and the workers meet")
    scheduler.add_argument("--port", type=natural, default=PORT, help=f"(default: {PORT})")
    worker = parts.add_parser("worker", help="the workers of this machine")
    worker.add_argument("address", help="of the scheduler: tcp://HOST:PORT")
    cores = os.cpu_count() or 1
    worker.add_argument("--number", type=count, default=cores, metavar="N", help="(one a core)")
    for part in (scheduler, worker):
        part.add_argument("--host", default="127.0.0.1", help="own address (127.0.0.1)")
    args = parser.parse_args(argv)
    if args.part == "worker" and args.number < 1:
        parser.error(f"--number must be >= 1, got {args.number}")
    return args


if __name__ == "__main__":
    sys.exit(run_command(main))
