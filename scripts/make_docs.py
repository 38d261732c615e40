"""Make again what is generated under docs/: `make_docs.py [PART ...]`.

Parts are parameters, world-files, recordings, demo and worlds; without a name all are made.
Recordings that are not there are passed over and keep their picture and their row.
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
from _docs_world_files import PAGE as FILES_PAGE
from _docs_world_files import world_files_page
from _docs_worlds import PAGE, make_worlds, pictures_amiss, worlds_page
from floornav_common.reporting import UserError, run_command, say, write_atomic

DOCS = ROOT / "docs"
PARAMETERS = DOCS / "parameters.md"
DATA = ROOT.parent / "shared" / "data"
WORLD_FILES = DOCS / FILES_PAGE
PARTS = ("parameters", "world-files", "recordings", "demo", "worlds")


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    args = make_parser().parse_args(argv)
    unknown = [part for part in args.parts if part not in PARTS]
    if unknown:
        raise UserError(f"unknown part {', '.join(unknown)}; there are: {', '.join(PARTS)}")
    if args.check:
        return check(args.parts)
    parts = args.parts or list(PARTS)
    if "parameters" in parts:
        write_atomic(PARAMETERS, parameter_page())
        say(f"written: {PARAMETERS.relative_to(ROOT)}")
    if "world-files" in parts:
        write_atomic(WORLD_FILES, world_files_page())
        say(f"written: {WORLD_FILES.relative_to(ROOT)}")
    if "recordings" in parts:
        make_recordings(DOCS, args.data)
    if "demo" in parts:
        make_demo(DOCS / "pictures")
    if "worlds" in parts:
        make_worlds(DOCS, args.data)
    return 0


def check(parts: list[str]) -> int:
    """Tell whether the pages made from code alone are what the code says; 1 if one is not."""
    amiss = []
    for part, page, make in (
        ("parameters", PARAMETERS, parameter_page),
        ("world-files", WORLD_FILES, world_files_page),
        ("worlds", DOCS / PAGE, worlds_page),
    ):
        there = page.read_text(encoding="utf-8") if page.exists() else ""
        if (not parts or part in parts) and there != make():
            amiss.append((part, f"{page.relative_to(ROOT)} is out of date"))
    if not parts or "worlds" in parts:
        amiss += [("worlds", text) for text in pictures_amiss(DOCS)]
    for part, text in amiss:
        print(f"{text}: run python3 scripts/make_docs.py {part}", file=sys.stderr)
    return 1 if amiss else 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="make_docs.py", description=__doc__)
    add = parser.add_argument
    add("parts", nargs="*", metavar="PART", help=f"what to make: {', '.join(PARTS)} (default: all)")
    add(
        "--check",
        action="store_true",
        help="exit 1 if a page made from code is out of date",
    )
    add("--data", type=Path, default=DATA, metavar="DIR",
        help="folder of the recordings (default: ../shared/data beside the checkout)")  # fmt: skip
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
