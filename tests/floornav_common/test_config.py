"""Configuration values: ranges are enforced and can be told in words."""

import math
from dataclasses import dataclass, fields

import pytest

from floornav_common.config import param, range_text, validate


@dataclass(frozen=True, kw_only=True)
class Example:
    share: float = param(0.5, "A share.", gt=0.0, le=1.0)
    count: int = param(3, "A count.", ge=1, lt=10)
    mode: str = param("a", "A mode.", choices=("a", "b"))
    lengths: tuple[float, ...] = param((1.0, 2.0), "Lengths.", unit="m", ge=0.0)

    def __post_init__(self) -> None:
        validate(self)


def test_defaults_are_valid():
    assert Example().share == 0.5


@pytest.mark.parametrize(
    ("name", "value"),
    [("share", 0.0), ("share", 1.1), ("share", math.nan), ("share", math.inf), ("count", 0),
     ("count", 10), ("mode", "c"), ("lengths", (1.0, -1.0))],
)  # fmt: skip
def test_values_outside_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        Example(**{name: value})


@pytest.mark.parametrize(("name", "value"), [("share", 1.0), ("count", 9), ("mode", "b")])
def test_closed_bounds_are_allowed(name, value):
    assert getattr(Example(**{name: value}), name) == value


def test_ranges_are_told_in_words():
    texts = [range_text(f) for f in fields(Example)]
    assert texts == ["> 0, <= 1", ">= 1, < 10", "one of a, b", ">= 0"]
