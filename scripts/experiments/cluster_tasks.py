"""Tasks of an experiment over a Dask cluster: the figures of `--jobs`, on more machines.

Each worker is one process of one thread with this very checkout and these libraries, which is
looked at before the first task (`scripts/cluster.py` starts such workers). A task depends on
nothing but itself, so the tasks of a worker that dies are simply done again by another.
`distributed` is imported here and only where a cluster is asked for.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

from experiments.parallel_tasks import one_thread
from floornav_common.reporting import UserError

T = TypeVar("T")
R = TypeVar("R")
ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = ("numpy", "scipy", "opencv-python-headless", "numba", "pybullet")
CONNECT_S = 10
LOOK_S = 10.0  # between looks whether anybody is still at work


def run_on_cluster(
    make: Callable[[T], R], tasks: Sequence[T], address: str
) -> Iterator[tuple[T, R]]:
    """Yield each task and what it gives, in order; what is left is dropped when the caller stops.

    Args:
        make: Does one task; a function of a module that the workers have.
        tasks: Given to it.
        address: Of the scheduler, such as tcp://127.0.0.1:8786.

    Raises:
        UserError: There is no cluster, or its workers are not like this process.
    """
    with _client(address) as client:
        _check_workers(client, address)
        folder = os.getcwd()
        futures = deque(client.submit(_done, make, task, folder, pure=False) for task in tasks)
        try:
            for task in tasks:
                yield task, _result(client, futures[0], address)
                futures.popleft()  # the workers forget it
        finally:
            client.cancel(list(futures))


def versions() -> dict[str, str]:
    """Return what decides the figures: Python, libraries, and a hash of our own code."""
    found = {"python": ".".join(map(str, sys.version_info[:3]))}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    folders = (ROOT / "scripts" / "experiments", ROOT / "ros_ws" / "src")
    code = hashlib.sha256()
    for file in sorted(file for folder in folders for file in folder.rglob("*.py")):
        code.update(str(file.relative_to(ROOT)).encode() + file.read_bytes())
    return {**found, "this checkout": code.hexdigest()[:12]}


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        line = f"{sys.executable} -m pip install distributed"
        raise UserError(f"--cluster needs a library that is not here: {line}") from error
    try:
        return Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise UserError(f"no Dask scheduler answers at {address}") from error


def _check_workers(client: Any, address: str) -> None:
    """Raise UserError unless there are workers, and each would find the same figures."""
    threads = client.nthreads()
    if not threads:
        raise UserError(f"the cluster at {address} has no worker: scripts/cluster.py worker")
    for worker, num in threads.items():
        if num != 1:
            raise UserError(f"worker {worker} has {num} threads; start it with --nthreads 1")
    try:
        everywhere = client.run(versions)
    except ModuleNotFoundError as error:
        text = f"a worker at {address} does not find our code ({error})"
        raise UserError(f"{text}; start it with scripts/cluster.py worker") from error
    for worker, theirs in everywhere.items():
        for name, ours in versions().items():
            if theirs.get(name) != ours:
                text = f"{name} is {theirs.get(name)} there and {ours} here"
                raise UserError(f"worker {worker} would find other figures: {text}")


def _result(client: Any, future: Any, address: str) -> Any:
    """Return what a task gave; says when there is nobody left to do it, and waits on."""
    is_said = False
    while not future.done():
        with contextlib.suppress(TimeoutError):
            future.exception(timeout=LOOK_S)  # waits
        if not future.done() and not client.nthreads() and not is_said:
            print(f"no worker is left at {address}; waiting for one", file=sys.stderr)
            is_said = True
    return future.result()


def _done(make: Callable[[T], R], task: T, folder: str) -> R:
    """Do a task on a worker."""
    one_thread()
    with contextlib.suppress(OSError):  # a file that the user named relatively is the same here
        os.chdir(folder)
    return make(task)
