"""What takes long is said again and again."""

from __future__ import annotations

import time

import pytest

from _saying import saying


def test_a_text_is_said_at_once_and_again_until_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    with saying("drawing ...", is_quiet=False, period=0.05):
        said, end = "", time.monotonic() + 60.0
        while said.count("\n") < 3 and time.monotonic() < end:
            time.sleep(0.02)
            said += capsys.readouterr().out
    first, *again = (said + capsys.readouterr().out).splitlines()
    assert first == "drawing ..."
    assert len(again) >= 2 and all(line.startswith("drawing ... (") for line in again)
    time.sleep(0.2)
    assert capsys.readouterr().out == ""


def test_quiet_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with saying("drawing ...", is_quiet=True, period=0.02):
        time.sleep(0.1)
    assert capsys.readouterr().out == ""
