"""Which thing a nameless bearing belongs to: by hand, and what must not be told."""

from __future__ import annotations

import numpy as np
import pytest

from multi_localizer.team_meanings import tell_apart

NOTHING = -4.0


def test_each_bearing_gets_the_thing_that_fits() -> None:
    fits = np.array([[1.0, -9.0], [-9.0, 1.5]])
    assert tell_apart(fits, NOTHING, 20.0).tolist() == [0, 1]


def test_two_bearings_do_not_share_a_thing() -> None:
    fits = np.array([[2.0, -np.inf], [1.0, -np.inf]])
    told = tell_apart(fits, NOTHING, 2.0)
    assert told.tolist() == [0, -1]


def test_the_better_sum_wins_over_the_better_start() -> None:
    fits = np.array([[2.0, 1.9], [2.0, -9.0]])
    assert tell_apart(fits, NOTHING, 5.0).tolist() == [1, 0]


@pytest.mark.parametrize(("gap", "told"), [(np.log(20.0) + 0.1, 0), (np.log(20.0) - 0.1, -1)])
def test_a_rival_has_to_be_so_many_times_less_likely(gap: float, told: int) -> None:
    assert tell_apart(np.array([[1.0, 1.0 - gap]]), -50.0, 20.0).tolist() == [told]


def test_what_fits_worse_than_nothing_is_nothing() -> None:
    assert tell_apart(np.array([[-5.0]]), NOTHING, 1.5).tolist() == [-1]


def test_no_bearings_and_no_things_are_no_answer() -> None:
    assert tell_apart(np.empty((0, 3)), NOTHING, 20.0).shape == (0,)
    assert tell_apart(np.empty((2, 0)), NOTHING, 20.0).tolist() == [-1, -1]
