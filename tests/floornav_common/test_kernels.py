from __future__ import annotations

import fcntl
import threading

import numba
import pytest

from floornav_common import kernels
from floornav_common.kernels import compile_once, lock_path


@pytest.fixture(autouse=True)
def own_locks(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels.tempfile, "gettempdir", lambda: str(tmp_path))


def test_a_new_kernel_is_told_once_and_a_known_one_not_at_all():
    double, triple = numba.njit(lambda x: 2 * x), numba.njit(lambda x: 3 * x)
    said: list[str] = []

    def call() -> None:
        assert (double(2), triple(2)) == (4, 6)

    assert compile_once(call, "some/node", said.append) == 2
    assert len(said) == 1 and said[0].startswith("compiling its kernels")
    assert compile_once(call, "some/node", said.append) == 0
    assert len(said) == 1


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
