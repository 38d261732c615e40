"""One thread a node."""

from __future__ import annotations

import os
import sys

import pytest

from floornav_common.ros.threads import limit_threads


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "environ", dict(os.environ))


def test_loaded_libraries_and_later_ones_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    cv2 = pytest.importorskip("cv2")
    before = cv2.getNumThreads()
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    try:
        limit_threads(1)
        assert cv2.getNumThreads() == 1
        assert os.environ["OMP_NUM_THREADS"] == "1"
    finally:
        cv2.setNumThreads(before)


def test_what_the_user_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    limit_threads(1)
    assert os.environ["OMP_NUM_THREADS"] == "3"


def test_numba_is_limited_where_it_is_loaded() -> None:
    numba = pytest.importorskip("numba")
    before = numba.get_num_threads()
    assert "numba" in sys.modules
    try:
        limit_threads(1)
        assert numba.get_num_threads() == 1
        assert numba.njit(lambda x: x + 1)(1) == 2
    finally:
        numba.set_num_threads(before)
