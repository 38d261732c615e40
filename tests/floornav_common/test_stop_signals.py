"""Signals as a question."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from floornav_common.stop_signals import noticed_stop


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
