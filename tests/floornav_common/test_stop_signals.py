"""Signals as a question."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator

import pytest

from floornav_common.stop_signals import StopSignals, noticed_stop


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_noticed_and_raises_nothing(sign: signal.Signals) -> None:
    with noticed_stop() as should_stop:
        assert not should_stop()
        os.kill(os.getpid(), sign)
        assert should_stop()


def test_a_second_signal_raises() -> None:
    with noticed_stop() as should_stop:
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        assert should_stop()


def test_handlers_of_before_are_there_again_afterwards() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with noticed_stop():
        assert signal.getsignal(signal.SIGINT) is not before[0]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_another_thread_may_use_it_too() -> None:
    answers: list[bool] = []

    def work() -> None:
        with noticed_stop() as should_stop:
            answers.append(should_stop())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert answers == [False]


@pytest.fixture
def signals() -> Iterator[StopSignals]:
    before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}
    hook = sys.unraisablehook
    yield StopSignals()
    sys.unraisablehook = hook
    for signum, handler in before.items():
        signal.signal(signum, handler)


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_outside_the_block_signals_are_only_noticed(
    signals: StopSignals, sign: signal.Signals
) -> None:
    assert not signals.have_come
    os.kill(os.getpid(), sign)
    os.kill(os.getpid(), sign)
    assert signals.have_come


def test_inside_the_block_the_first_signal_is_raised_and_no_other(signals: StopSignals) -> None:
    with pytest.raises(KeyboardInterrupt), signals.raised():
        os.kill(os.getpid(), signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt), signals.raised():
        pytest.fail("a signal came before the block")
    assert signals.have_come


def test_a_signal_that_is_swallowed_in_the_block_is_known_and_not_raised_again(
    signals: StopSignals,
) -> None:
    with signals.raised():
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)
    assert signals.have_come


class Stubborn:
    """Is sent a signal in a place that no exception leaves."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


class Broken:
    """Fails in a place that no exception leaves."""

    def __del__(self) -> None:
        raise ValueError


def test_a_signal_that_python_loses_in_the_block_comes_again_and_is_not_printed(
    signals: StopSignals, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(KeyboardInterrupt), signals.raised():
        Stubborn()
        threading.Event().wait(30.0)
        pytest.fail("the signal did not come again")
    Broken()  # as what was left half done would be
    assert signals.have_come
    assert capfd.readouterr().err == ""


def test_other_exceptions_that_python_loses_in_the_block_are_told_as_before(
    signals: StopSignals, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[type[BaseException] | None] = []

    def tell(lost: sys.UnraisableHookArgs) -> None:
        told.append(lost.exc_type)

    monkeypatch.setattr(sys, "unraisablehook", tell)

    with signals.raised():
        Broken()
    assert told == [ValueError] and sys.unraisablehook is tell


def test_nodes_may_run_in_another_thread() -> None:
    have_come: list[bool] = []
    thread = threading.Thread(target=lambda: have_come.append(StopSignals().have_come))
    thread.start()
    thread.join()
    assert have_come == [False]
