"""All experiments, one after another: every table beside its paper on one page.

Faults and soak are left out, as they run in real time. Each experiment is a process of its own, so
that one that fails, or dies, does not take the others along; its results are in the folder of its
name. Those that take `--jobs` are spread over the cores; of the others as many run side by side;
what talks over DDS or is timed runs alone. What needs a recording that is not there is listed as
not run.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import active_children
from pathlib import Path
from typing import Any

from experiments.parallel_tasks import add_spread_options
from experiments.whole_set_list import DATA, SET, Item
from experiments.whole_set_process import Outcome, run_item
from floornav_common.reporting import (
    Figures,
    Progress,
    Section,
    Table,
    write_html,
)

HEADER = ["experiment", "state", "minutes", "processor minutes", "command, or why not"]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what is special to the whole set."""
    add = parser.add_argument
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="few seeds each (the default)")
    size.add_argument("--full", action="store_true", help="all seeds each")
    names = [item.name for item in SET]
    text = f"these alone: {', '.join(names)}"
    add("--only", nargs="+", choices=names, default=names, metavar="NAME", help=text)
    add("--data", type=Path, default=DATA, metavar="DIR", help=f"recordings (default: {DATA})")
    add_spread_options(parser)


def check(args: argparse.Namespace) -> None:
    """Look for the cluster before anything is made.

    Raises:
        UserError: It cannot be used.
    """
    if args.cluster is not None:
        from experiments.cluster_tasks import run_on_cluster

        list(run_on_cluster(abs, [-1], args.cluster))


def run(args: argparse.Namespace, values: dict[str, Any]) -> list[Section]:
    """Run the set; fills a key of `values` for each experiment, and `experiments`, a row each."""
    items = [item for item in SET if item.name in args.only]
    values.update(
        is_full=args.full, jobs=args.jobs, experiments=[], **{i.name: None for i in items}
    )
    outcomes: dict[str, Outcome] = {}
    sections: list[Section] = []
    try:
        with Progress("all", len(items), is_quiet=args.quiet) as progress:
            for outcome in _outcomes(items, args):
                outcomes[outcome.name] = outcome
                progress.update(len(outcomes), _line(outcome), is_last=True)
                known = [outcomes[item.name] for item in items if item.name in outcomes]
                sections = report(known, values, args)
                write_html(args.out_dir, "floornav: all", sections, "so far")
    except BaseException:
        _end_children()
        raise
    failed = [name for name, outcome in outcomes.items() if outcome.state == "failed"]
    values["ok"] = not failed
    if failed:
        print(f"error: failed: {', '.join(failed)}", file=sys.stderr)
    return sections


def _outcomes(items: list[Item], args: argparse.Namespace) -> Iterator[Outcome]:
    """Yield what comes of each: first those of one core, as many as may run, then one by one."""
    ready: list[Item] = []
    for item in items:
        missing = item.missing(args.data)
        if missing is None:
            ready.append(item)
        else:
            yield Outcome(item.name, "not run", f"no recording {missing}", None, [], None, None)
    with ThreadPoolExecutor(args.jobs) as side_by_side:
        try:
            alone = [item for item in ready if item.kind == "one"]
            yield from side_by_side.map(lambda item: _run(item, args), alone)
        except BaseException:  # what has begun would be waited for
            side_by_side.shutdown(wait=False, cancel_futures=True)
            _end_children()
            raise
    for kind in ("spread", "alone"):
        yield from (_run(item, args) for item in ready if item.kind == kind)


def _end_children() -> None:
    for process in active_children():
        process.terminate()


def _run(item: Item, args: argparse.Namespace) -> Outcome:
    words = item.words(args.data, is_full=args.full)
    words += ["--seed", str(args.seed)] if args.seed else []  # 0: each experiment's own
    if item.kind == "spread":
        words += ["--jobs", str(args.jobs)]
        words += [] if args.cluster is None else ["--cluster", args.cluster]
    return run_item(item.name, words, args.out_dir / item.name)


def _line(outcome: Outcome) -> str:
    if outcome.state == "not run":
        return f"{outcome.name}: not run, {outcome.reason}"
    took = f"{outcome.wall_s:.0f} s" if outcome.wall_s is not None else ""
    why = f": {outcome.reason}" if outcome.state == "failed" else ""
    return f"{outcome.name}: {outcome.state} after {took}{why}"


def report(
    outcomes: list[Outcome], values: dict[str, Any], args: argparse.Namespace
) -> list[Section]:
    """Return the page: what was run and what it took, then every experiment's own sections."""
    processor_s = sum(outcome.cpu_s or 0.0 for outcome in outcomes)
    wall_s = sum(outcome.wall_s or 0.0 for outcome in outcomes)
    values["experiments"] = [outcome.row() for outcome in outcomes]
    values.update({outcome.name: outcome.values for outcome in outcomes})
    values.update(processor_s=round(processor_s, 1), sum_wall_s=round(wall_s, 1))
    count = {
        state: sum(o.state == state for o in outcomes) for state in ("done", "failed", "not run")
    }
    figures: list[tuple[str, ...]] = [
        ("done", str(count["done"]), "good"),
        ("failed", str(count["failed"]), "bad" if count["failed"] else "good"),
        ("not run", str(count["not run"])),
        ("processor minutes", f"{processor_s / 60.0:.1f}"),
        ("processor minutes / 2 cores", f"{processor_s / 120.0:.1f}"),
    ]
    texts = ["All seeds." if args.full else "The quick choice of seeds."]
    if args.cluster is not None:
        texts.append("Processor time is this machine's alone, without the cluster's workers.")
    rows = [_row(outcome) for outcome in outcomes]
    overview = Section("What was run", [Figures(figures), *texts, Table(HEADER, rows)])
    return [overview, *(section for outcome in outcomes for section in _titled(outcome))]


def _row(outcome: Outcome) -> list[str]:
    minutes = [
        "-" if spent is None else f"{spent / 60.0:.2f}" for spent in (outcome.wall_s, outcome.cpu_s)
    ]
    command = f"evaluate.py {' '.join(outcome.words)}" if outcome.words else ""
    said = " | ".join(filter(None, [outcome.reason, command]))
    return [outcome.name, outcome.state, *minutes, said]


def _titled(outcome: Outcome) -> list[Section]:
    if not outcome.sections:
        return [Section(f"{outcome.name}: {outcome.state}", [outcome.reason])]
    return [
        Section(f"{outcome.name}: {section.title}", section.blocks) for section in outcome.sections
    ]
