"""Tasks of an experiment over processes of one thread each, or a cluster, in the order given."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

from floornav_common.arguments import count

T = TypeVar("T")
R = TypeVar("R")


def add_spread_options(parser: argparse.ArgumentParser, jobs: int = 2) -> None:
    """Add `--jobs` and `--cluster`; `jobs` is the default of the first."""
    add = parser.add_argument
    add("--jobs", type=count, default=jobs, metavar="N", help=f"processes (default: {jobs})")
    text = "spread over the Dask cluster of this scheduler instead (tcp://HOST:PORT)"
    add("--cluster", default=None, metavar="ADDRESS", help=text)


def run_tasks(
    make: Callable[[T], R], tasks: Sequence[T], jobs: int, cluster: str | None = None
) -> Iterator[tuple[T, R]]:
    """Yield each task and what it gives, in order; what is left is dropped when the caller stops.

    Args:
        make: Does one task; a function of a module, as other processes have to find it.
        tasks: Given to it.
        jobs: Processes; 1 stays in this one.
        cluster: Address of a Dask scheduler, whose workers do the tasks instead.
    """
    if cluster is not None:
        from experiments.cluster_tasks import run_on_cluster

        yield from run_on_cluster(make, tasks, cluster)
        return
    if jobs == 1:
        yield from ((task, make(task)) for task in tasks)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=one_thread) as pool:
        try:
            yield from zip(tasks, pool.map(make, tasks), strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def one_thread() -> None:
    """Let this process compute in one thread: processes share the cores."""
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import cv2

    cv2.setNumThreads(1)
