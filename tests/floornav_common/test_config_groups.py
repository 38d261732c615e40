"""Configurations within configurations: their values are named `group.field` everywhere."""

from dataclasses import dataclass, field

import pytest

from floornav_common.config import param, validate
from floornav_common.config_files import (
    config_from_mapping,
    flat_values,
    load_config,
    parameter_names,
)


@dataclass(frozen=True, kw_only=True)
class Inner:
    size_m: float = param(1.0, "A size.", unit="m", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class Outer:
    count: int = param(2, "A count.", ge=0)
    inner: Inner = field(default_factory=Inner)

    def __post_init__(self) -> None:
        validate(self)


def test_values_of_a_group_are_set_by_their_dotted_name():
    config = config_from_mapping(Outer, {"inner.size_m": 3, "count": 5})
    assert config == Outer(count=5, inner=Inner(size_m=3.0))
    assert flat_values(config) == {"count": 5, "inner.size_m": 3.0}


def test_names_carry_the_groups_they_are_in():
    assert parameter_names(Outer, "a") == {"a.count": "count", "a.inner.size_m": "inner.size_m"}


def test_a_bad_value_in_a_group_is_named_in_full():
    with pytest.raises(ValueError, match=r"inner\.size_m must be > 0"):
        config_from_mapping(Outer, {"inner.size_m": -1.0})


def test_a_file_may_nest_groups_or_dot_them(tmp_path):
    path = tmp_path / "c.yaml"
    for text in ("count: 1\ninner:\n  size_m: 2.5\n", "count: 1\ninner.size_m: 2.5\n"):
        path.write_text(text)
        assert load_config(path, Outer) == Outer(count=1, inner=Inner(size_m=2.5))


def test_an_unknown_key_in_a_group_is_refused(tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text("inner:\n  size: 2.5\n")
    with pytest.raises(ValueError, match=r"'inner\.size' \(did you mean 'inner\.size_m'"):
        load_config(path, Outer)
