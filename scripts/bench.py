"""Speed of each job beside its peers and its floor, in one run.

Every figure is taken in turns with the peer's, on one thread, on made-up input of one seed.
"""

from __future__ import annotations

import argparse
import importlib
import sys

from _environment import ensure_environment

if __name__ == "__main__":
    ensure_environment(needs="node")

from experiments.timing import Case  # noqa: E402
from floornav_common.reporting import (  # noqa: E402
    Section,
    Table,
    UserError,
    add_common_options,
    open_out_dir,
    run_command,
    say,
    summary,
    write_html,
)

JOBS = {
    "scan_matching": "scan-to-map ICP on a 66 m loop, beside kiss-icp and genz-icp",
    "map_update": "a scan into the map, beside a plain ray trace",
    "sonar_update": "a sonar reading into the map, and a whole update with its scan match",
    "glass_map": "all layers for publishing on a plan of 50 x 50 m",
    "loops": "what closing loops in the background holds a scan up by, over a live session",
    "simulation": "real-time factor by sensor set, and a frame beside the bare pybullet call",
    "floor": "from image to free space, beside bare OpenCV passes",
    "floor_localization": "from the floor mask to the pose, beside the published steps",
    "avoidance": "from a scan to a command, beside the same in plain numpy",
    "planners": "a control step of each planning method among 20 people, beside ORCA and DWA",
    "team": "poses and identities of 4 to 50 robots, beside solvers told who is who",
    "stereo": "disparities of a pair, beside OpenCV's matchers",
    "stereo_localization": "from stereo views to the pose: whole map, and tracking",
    "graph": "the flat's graph: scan to command, processor share and memory of every node",
    "messages": "images and grids to and from messages, and between processes",
}
HEADER = ["case", "median ms", "p99 ms", "peer", "peer ms", "ratio", "floor ms", "more"]


def main(argv: list[str] | None = None) -> int:
    """Run the jobs asked for."""
    args = _parser().parse_args(argv)
    unknown = [job for job in args.jobs if job not in JOBS]
    if unknown:
        raise UserError(f"unknown job {', '.join(unknown)}; there are: {', '.join(JOBS)}")
    jobs = args.jobs or list(JOBS)
    out = open_out_dir("bench", "-".join(jobs) if args.jobs else "all", args.out)
    sections: list[Section] = []
    with summary(out, command="bench", seed=args.seed, values={"jobs": {}}) as values:
        for job in jobs:
            module = importlib.import_module(f"experiments.bench_{job}")
            cases = module.run(args.seed, lambda text: say(text, is_quiet=args.quiet))
            values["jobs"][job] = {case.name: case.as_dict() for case in cases}
            rows = [_row(case) for case in cases]
            say(_as_text(job, rows), is_quiet=args.quiet)
            sections.append(Section(job, [JOBS[job], Table(HEADER, rows)]))
            write_html(out, "floornav: speed", sections, f"seed {args.seed}")
    say(f"results: {out}", is_quiet=args.quiet)
    return 0


def _row(case: Case) -> list[str]:
    def number(value: float | None) -> str:
        return "-" if value is None else f"{value:.4g}"

    more = ", ".join(
        f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in case.extra.items()
    )
    return [
        case.name, number(case.median_ms), number(case.p99_ms), case.peer or "-",
        number(case.peer_median_ms), number(case.ratio), number(case.floor_ms), more,
    ]  # fmt: skip


def _as_text(job: str, rows: list[list[str]]) -> str:
    """Return the table as lines; what is more stands below its row."""
    table = [HEADER[:-1], *(row[:-1] for row in rows)]
    widths = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    lines = [f"\n{job}"]
    for k, row in enumerate(table):
        lines.append(
            "  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
        )
        if k > 0 and rows[k - 1][-1]:
            lines.append(f"      {rows[k - 1][-1]}")
    return "\n".join(lines)


def _parser() -> argparse.ArgumentParser:
    text = "\n".join(f"  {job:14} {what}" for job, what in JOBS.items())
    parser = argparse.ArgumentParser(
        prog="bench.py", description=__doc__, epilog=f"jobs:\n{text}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("jobs", nargs="*", metavar="JOB", help="what to time (default: all)")
    add_common_options(parser, seed=1)
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
