"""Tasks over a Dask cluster of processes on loopback: order, figures, a worker that is killed."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from experiments.parallel_tasks import run_tasks
from floornav_common.reporting import UserError

pytest.importorskip("distributed", reason="the optional library of --cluster is not installed")

from experiments import cluster_tasks  # noqa: E402

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "cluster.py"
TASKS = """
import os
import time
from pathlib import Path

import numpy as np


def draw(task):
    folder, seed = task
    if folder is not None:
        Path(folder, f"{seed}-{os.getpid()}").touch()
        time.sleep(0.3)
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(40, 40))
    return np.linalg.solve(matrix, rng.normal(size=40)).tolist()
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Make a module that the workers and this process import."""
    made = tmp_path_factory.mktemp("cluster")
    (made / "drawn_tasks.py").write_text(TASKS)
    sys.path.insert(0, str(made))
    yield made
    sys.path.remove(str(made))


@pytest.fixture(scope="module")
def cluster(folder: Path) -> Iterator[str]:
    """Start a scheduler and two workers; yields its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    environ = {**os.environ, "FLOORNAV_ENV_READY": "1", "PYTHONPATH": str(folder)}
    parts = (["scheduler", "--port", str(port)], *[["worker", address, "--number", "1"]] * 2)
    with open(folder / "log.txt", "w") as log:
        started = [
            subprocess.Popen(
                [sys.executable, str(SCRIPT), *part],
                env=environ,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )  # fmt: skip
            for part in parts
        ]
        try:
            _wait_for_workers(address, 2)
            yield address
        finally:
            for one in started:  # with the process that a worker computes in
                os.killpg(one.pid, signal.SIGKILL)
                one.wait(timeout=60.0)


def _wait_for_workers(address: str, number: int) -> None:
    from distributed import Client

    deadline = time.monotonic() + 180.0
    while True:
        try:
            with Client(address, timeout=5, set_as_default=False) as client:
                client.wait_for_workers(number, timeout=60)
                return
        except (OSError, TimeoutError):
            if time.monotonic() > deadline:
                raise


def test_a_cluster_gives_what_processes_give_to_the_last_bit(cluster: str) -> None:
    from drawn_tasks import draw

    tasks = [(None, seed) for seed in range(6)]
    assert list(run_tasks(draw, tasks, 1, cluster)) == list(run_tasks(draw, tasks, 2))


def test_a_worker_killed_on_the_way_loses_nothing(cluster: str, tmp_path: Path) -> None:
    from drawn_tasks import draw

    tasks = [(str(tmp_path), seed) for seed in range(10)]
    found = run_tasks(draw, tasks, 1, cluster)
    results = [next(found)]
    first = {int(file.name.split("-")[1]) for file in tmp_path.iterdir()}
    victim = max(first)
    os.kill(victim, signal.SIGKILL)
    results += list(found)
    assert results == [(task, draw((None, task[1]))) for task in tasks]
    after = {int(file.name.split("-")[1]) for file in tmp_path.iterdir()}
    assert len(after) >= 2


def test_a_task_that_fails_ends_it_with_its_error(cluster: str, tmp_path: Path) -> None:
    found = run_tasks(os.listdir, [str(tmp_path), str(tmp_path / "none")], 1, cluster)
    assert next(found) == (str(tmp_path), [])
    with pytest.raises(FileNotFoundError, match="none"):
        next(found)


def test_a_worker_with_another_library_is_refused(
    cluster: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = {**cluster_tasks.versions(), "numpy": "0.1"}
    real = cluster_tasks.versions
    client = cluster_tasks._client(cluster)
    with client, monkeypatch.context() as patch:
        patch.setattr(cluster_tasks, "versions", lambda: ours)
        patch.setattr(client, "run", lambda _: {"tcp://one": real()})
        with pytest.raises(UserError, match="tcp://one would find other figures: numpy is"):
            cluster_tasks._check_workers(client, cluster)


def test_an_address_where_nobody_answers_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster_tasks, "CONNECT_S", 1)
    with pytest.raises(UserError, match="no Dask scheduler answers at tcp://127.0.0.1:9"):
        list(run_tasks(abs, [1], 1, "tcp://127.0.0.1:9"))


def test_without_the_library_the_line_that_installs_it_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UserError, match="pip install distributed"):
        list(run_tasks(abs, [1], 1, "tcp://127.0.0.1:9"))


def test_workers_have_one_thread_and_loopback_is_the_default() -> None:
    import cluster as script

    args = script._parsed(["worker", "tcp://h:1", "--number", "3"])
    words = script._words(args)
    assert words[:2] == ["distributed.cli.dask_worker", "tcp://h:1"]
    for option, value in (("--host", "127.0.0.1"), ("--nthreads", "1"), ("--nworkers", "3")):
        assert words[words.index(option) + 1] == value
