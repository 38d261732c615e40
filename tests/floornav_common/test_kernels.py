from __future__ import annotations

import fcntl
import threading
from types import SimpleNamespace

import numba
import pytest

from floornav_common import kernels
from floornav_common.kernels import compile_once, lock_path


@pytest.fixture(autouse=True)
def own_locks(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels.tempfile, "gettempdir", lambda: str(tmp_path))


def test_new_kernels_are_told_before_and_after_and_known_ones_not_at_all():
    double, triple = numba.njit(lambda x: 2 * x), numba.njit(lambda x: 3 * x)
    said: list[str] = []

    def call() -> None:
        assert (double(2), triple(2)) == (4, 6)

    assert compile_once(call, "some/node", said.append) == 2
    assert len(said) == 2
    assert said[0].startswith("compiling its kernels") and said[1].startswith("kernels compiled in")
    assert compile_once(call, "some/node", said.append) == 0
    assert len(said) == 2


def test_what_takes_long_says_how_far_it_is(monkeypatch):
    kernels_of_test = [numba.njit(lambda x, k=k: k + x) for k in range(4)]
    said: list[str] = []
    now = iter(range(0, 10_000, 10))  # every look at the clock is 10 s later
    monkeypatch.setattr(kernels, "time", SimpleNamespace(monotonic=lambda: float(next(now))))
    compile_once(lambda: [k(1.0) for k in kernels_of_test], "node", said.append)
    assert any(line.startswith("still compiling: kernel 3, ") for line in said)
    assert said[-1].startswith("kernels compiled in")


def test_who_comes_second_waits_and_says_so():
    double, said, is_waiting = numba.njit(lambda x: 2 * x), [], threading.Event()

    def say(text: str) -> None:
        said.append(text)
        if "waiting" in text:
            is_waiting.set()

    with lock_path("node").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        thread = threading.Thread(target=compile_once, args=(lambda: double(1), "node", say))
        thread.start()
        assert is_waiting.wait(60.0)
        assert not double.signatures
        fcntl.flock(other, fcntl.LOCK_UN)
        thread.join(60.0)
    assert double.signatures


def test_the_lock_is_free_again_after_an_error():
    double = numba.njit(lambda x: 2 * x)

    def fail() -> None:
        double(1)
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        compile_once(fail, "node", lambda _: None)
    with lock_path("node").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_where_no_lock_can_be_the_kernels_are_compiled_all_the_same(monkeypatch):
    monkeypatch.setattr(kernels.tempfile, "gettempdir", lambda: "/nowhere")
    assert compile_once(lambda: numba.njit(lambda x: x)(1), "node", lambda _: None) == 1
