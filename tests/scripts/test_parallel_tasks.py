"""Tasks over processes: the order, what they give, and how many threads they have."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from experiments.parallel_tasks import run_tasks


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_task_comes_with_what_it_gives_in_order(jobs: int) -> None:
    words = ["c/d", "a", "b/e/f", "g/h"]
    assert list(run_tasks(os.path.basename, words, jobs)) == list(
        zip(words, ["d", "a", "f", "h"], strict=True)
    )


def test_other_processes_have_one_thread_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert list(run_tasks(os.getenv, ["OMP_NUM_THREADS"], 2)) == [("OMP_NUM_THREADS", "1")]
    assert os.environ["OMP_NUM_THREADS"] == "3"


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_task_that_fails_ends_it_with_its_error(jobs: int, tmp_path: Path) -> None:
    found = run_tasks(os.listdir, [tmp_path, tmp_path / "none"], jobs)
    assert next(found) == (tmp_path, [])
    with pytest.raises(FileNotFoundError, match="none"):
        next(found)
