"""Make again what is generated under docs/: `make_docs.py [parameters] [recordings] [demo]`.

Without a name all three are made. Recordings that are not there are passed over and keep their
picture and their row.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from _environment import ROOT, ensure_environment

if __name__ == "__main__":
    ensure_environment()

from _docs_parameters import parameter_page
from _docs_pictures import make_demo
from _docs_recordings import make_recordings
from floornav_common.reporting import UserError, run_command, say, write_atomic

DOCS = ROOT / "docs"
PARAMETERS = DOCS / "parameters.md"
DATA = ROOT.parent / "shared" / "data"
PARTS = ("parameters", "recordings", "demo")


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    unknown = [part for part in args.parts if part not in PARTS]
    if unknown:
        raise UserError(f"unknown part {', '.join(unknown)}; there are: {', '.join(PARTS)}")
    if args.check:
        return check()
    parts = args.parts or list(PARTS)
    if "parameters" in parts:
        write_atomic(PARAMETERS, parameter_page())
        say(f"written: {PARAMETERS.relative_to(ROOT)}")
    if "recordings" in parts:
        make_recordings(DOCS, args.data)
    if "demo" in parts:
        make_demo(DOCS / "pictures")
    return 0


def check() -> int:
    """Tell whether docs/parameters.md is what the code says; 1 if it is not."""
    there = PARAMETERS.read_text(encoding="utf-8") if PARAMETERS.exists() else ""
    if there == parameter_page():
        return 0
    name = PARAMETERS.relative_to(ROOT)
    print(f"{name} is out of date: run python3 scripts/make_docs.py parameters", file=sys.stderr)
    return 1


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="make_docs.py", description=__doc__)
    add = parser.add_argument
    add("parts", nargs="*", metavar="PART", help=f"what to make: {', '.join(PARTS)} (default: all)")
    add("--check", action="store_true", help="exit 1 if docs/parameters.md is out of date")
    add("--data", type=Path, default=DATA, metavar="DIR",
        help="folder of the recordings (default: ../shared/data beside the checkout)")  # fmt: skip
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
