"""Numbers on a command line: what is none, or no such number, is refused in one sentence."""

from __future__ import annotations

import argparse

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.arguments import (
    count,
    finite,
    natural,
    not_negative,
    positive,
    share,
    whole,
)

NO_NUMBER = ("", "x", "nan", "inf", "-inf", "1e999", "1,5")
REFUSED = {
    finite: NO_NUMBER,
    positive: (*NO_NUMBER, "0", "-0.0", "-1", "1e-999"),
    not_negative: (*NO_NUMBER, "-1", "-1e-300"),
    share: (*NO_NUMBER, "-0.1", "1.0001"),
    whole: (*NO_NUMBER, "1.5", "1e3"),
    count: (*NO_NUMBER, "0", "-1", "2.0"),
    natural: (*NO_NUMBER, "-1", "0.0"),
}


@pytest.mark.parametrize(
    ("kind", "text"), [(kind, text) for kind, texts in REFUSED.items() for text in texts]
)
def test_what_is_no_such_number_is_refused_with_the_word(kind, text):
    with pytest.raises(argparse.ArgumentTypeError, match=r"^must be a .*number.*, got ") as error:
        kind(text)
    assert str(error.value).endswith(f", got {text}")


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (finite, "-2.5", -2.5), (positive, "1e-300", 1e-300), (not_negative, "0", 0.0),
        (share, "1", 1.0), (share, "0", 0.0), (whole, "-3", -3), (count, "1", 1),
        (natural, "0", 0),
    ],
)  # fmt: skip
def test_numbers_at_the_bounds_are_taken(kind, text, value):
    assert kind(text) == value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_comes_through_as_it_was_written(value):
    assert finite(repr(value)) == value
    for kind, holds in ((positive, value > 0.0), (not_negative, value >= 0.0)):
        if holds:
            assert kind(repr(value)) == value
        else:
            with pytest.raises(argparse.ArgumentTypeError):
                kind(repr(value))


@given(st.integers())
def test_every_whole_number_comes_through(value):
    assert whole(str(value)) == value


def test_a_command_names_the_option_and_ends_with_2(capsys):
    parser = argparse.ArgumentParser()
    parser.add_argument("--rate", type=positive)
    with pytest.raises(SystemExit, match="2"):
        parser.parse_args(["--rate", "nan"])
    assert "argument --rate: must be a number > 0, got nan" in capsys.readouterr().err
