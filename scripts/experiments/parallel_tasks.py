"""Tasks of an experiment over processes of one thread each, in the order given."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def run_tasks(make: Callable[[T], R], tasks: Sequence[T], jobs: int) -> Iterator[tuple[T, R]]:
    """Yield each task and what it gives, in order; what is left is dropped when the caller stops.

    Args:
        make: Does one task; a function of a module, as other processes have to find it.
        tasks: Given to it.
        jobs: Processes; 1 stays in this one.
    """
    if jobs == 1:
        yield from ((task, make(task)) for task in tasks)
        return
    with ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_one_thread
    ) as pool:
        try:
            yield from zip(tasks, pool.map(make, tasks), strict=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _one_thread() -> None:
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import cv2

    cv2.setNumThreads(1)
