"""How fast time goes, in hand-made time."""

import pytest

from sim_bridge.display import has_display
from sim_bridge.real_time import RealTime


def _run(watch: RealTime, factor: float, start: float, end: float, sim: float = 0.0) -> None:
    for k in range(round(10 * (end - start)) + 1):
        watch.look(start + 0.1 * k, sim + factor * 0.1 * k)


def test_half_of_what_was_asked_is_said_with_both_figures() -> None:
    watch = RealTime(window_s=5.0)
    _run(watch, 0.5, 100.0, 106.0)
    assert watch.factor == pytest.approx(0.5)
    assert watch.complaint(1.0) == "runs at 0.50 of real time, 1.00 asked"
    assert watch.complaint(0.5) == ""


def test_nothing_is_said_before_a_window_is_full_nor_without_a_wish() -> None:
    watch = RealTime(window_s=5.0)
    _run(watch, 0.1, 0.0, 4.5)
    assert watch.factor is None and watch.complaint(1.0) == ""
    _run(watch, 0.1, 4.6, 9.0, sim=0.46)
    assert watch.complaint(1.0) and not watch.complaint(0.0)


def test_only_the_last_seconds_count() -> None:
    watch = RealTime(window_s=5.0)
    _run(watch, 0.2, 0.0, 20.0)
    _run(watch, 1.0, 20.1, 30.0, sim=4.1)
    assert watch.factor == pytest.approx(1.0) and watch.complaint(1.0) == ""


def test_a_reset_and_a_pause_start_afresh() -> None:
    watch = RealTime(window_s=5.0)
    _run(watch, 1.0, 0.0, 6.0)
    watch.look(6.1, 0.0)
    assert watch.factor is None
    _run(watch, 1.0, 6.2, 12.0)
    assert watch.factor == pytest.approx(1.0, abs=0.02)
    watch.restart()
    assert watch.factor is None


@pytest.mark.parametrize(
    ("environ", "answer"),
    [({}, False), ({"DISPLAY": ""}, False), ({"DISPLAY": ":0"}, True)],
)  # fmt: skip
def test_a_display_is_what_the_environment_names(environ: dict[str, str], answer: bool) -> None:
    assert has_display(environ) == answer
