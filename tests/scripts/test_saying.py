"""What takes long is said again and again."""

from __future__ import annotations

import time

import pytest

from _saying import saying


def test_a_text_is_said_at_once_and_again_until_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    with saying("drawing ...", is_quiet=False, period=0.1):
        assert capsys.readouterr().out == "drawing ...\n"
        time.sleep(0.35)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) >= 2 and all(line.startswith("drawing ... (") for line in lines)
    time.sleep(0.2)
    assert capsys.readouterr().out == ""


def test_quiet_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with saying("drawing ...", is_quiet=True, period=0.02):
        time.sleep(0.1)
    assert capsys.readouterr().out == ""
