"""What a sonar's message means: every row of the table, and the laws behind it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.readings import RangeReading
from grid_mapper.sonar_config import SonarConfig
from grid_mapper.sonar_reading import Free, Hit, Nothing, classify, opening

LOW, HIGH, FOV = 0.2, 4.0, 0.35
ANY = st.floats(allow_nan=True, allow_infinity=True)


def heard(value, low=LOW, high=HIGH):
    return classify(RangeReading(value, FOV, low, high))


@pytest.mark.parametrize(
    ("value", "expected"),
    [(1.5, Hit(1.5)), (LOW, Hit(LOW)), (math.inf, Free(HIGH)), (HIGH, Free(HIGH)),
     (float(np.float32(HIGH)), Free(HIGH)), (math.nextafter(HIGH, 9.0), Free(HIGH))],
)  # fmt: skip
def test_an_echo_is_where_it_says_and_no_echo_is_free_to_the_end(value, expected):
    assert heard(value) == expected


def test_max_range_rounded_to_32_bits_is_still_no_echo():
    assert heard(float(np.float32(5.11)), high=5.11) == Free(5.11)
    assert heard(5.11, high=float(np.float32(5.11))) == Free(float(np.float32(5.11)))


@pytest.mark.parametrize(
    ("value", "reason"),
    [(math.nan, "NaN"), (-math.inf, "too near"), (0.0, "0 or less"), (-1.0, "0 or less"),
     (0.1, "below min_range"), (4.1, "above max_range")],
)  # fmt: skip
def test_what_says_nothing_is_named(value, reason):
    nothing = heard(value)
    assert isinstance(nothing, Nothing) and reason in nothing.reason


@pytest.mark.parametrize(("value", "expected"), [(-math.inf, Hit(0.3)), (math.inf, Free(0.3))])
def test_a_fixed_distance_ranger_tells_whether_something_is_within_it(value, expected):
    assert heard(value, 0.3, 0.3) == expected


@pytest.mark.parametrize("value", [0.3, 0.1, 0.0, math.nan])
def test_a_number_from_a_fixed_distance_ranger_is_none(value):
    assert isinstance(heard(value, 0.3, 0.3), Nothing)


@pytest.mark.parametrize(
    ("low", "high"), [(1.0, 0.5), (0.0, 0.0), (math.nan, 4.0), (0.2, math.nan), (-1.0, -0.5)]
)
def test_limits_that_leave_no_range_make_every_value_nothing(low, high):
    for value in (0.7, math.inf, -math.inf, high):
        assert isinstance(heard(value, low, high), Nothing)


def test_an_endless_reach_is_free_without_end():
    assert heard(math.inf, 0.2, math.inf) == Free(math.inf)
    assert heard(7.0, 0.2, math.inf) == Hit(7.0)


@given(value=ANY, low=ANY, high=ANY)
def test_a_hit_lies_within_the_limits_and_nothing_ever_raises(value, low, high):
    result = heard(value, low, high)
    if isinstance(result, Hit):
        assert 0.0 < result.range <= high and low <= result.range
    if isinstance(result, Free):
        assert result.range == high


def test_the_opening_is_the_messages_unless_it_is_set_or_unsaid():
    said = RangeReading(1.0, 0.5, LOW, HIGH)
    assert opening(said, SonarConfig()) == 0.5
    assert opening(said, SonarConfig(aperture_rad=0.2)) == 0.2


@pytest.mark.parametrize("fov", [0.0, -0.1, math.nan, math.inf, 4.0])
def test_a_zero_field_of_view_is_taken_as_twenty_degrees(fov):
    unsaid = RangeReading(1.0, fov, LOW, HIGH)
    assert opening(unsaid, SonarConfig()) == pytest.approx(math.radians(20.0))
    assert opening(unsaid, SonarConfig(unsaid_aperture_rad=0.6)) == 0.6
