"""Each row of the sonars' table on the map of `fusion: bayes` (docs/map-glass.md)."""

import math

import numpy as np
import pytest
from pane_drives import (
    LASER,
    NUM_STEPS,
    PANE_Y,
    SILENT,
    SONAR,
    S,
    blind_to_glass,
    cell,
    drive,
    num_glass,
    pane,
    reading,
    true_echo,
)

from floornav_common.grid import FREE, UNKNOWN
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper

BAYES = GridMapperConfig(fusion="bayes")
MISSES = ("+inf", "== max")


def test_echoes_make_a_pane_that_the_laser_looks_through():
    mapper = drive(true_echo, config=BAYES)
    layers = mapper.layers()
    assert pane(mapper) == 1.0
    assert cell(layers.laser, 1.0, PANE_Y) == FREE
    assert cell(layers.glass, 1.0, 3.0) == UNKNOWN  # the wall behind is the laser's


@pytest.mark.parametrize("name", SILENT)
def test_no_reading_without_an_echo_makes_glass(name):
    mapper = drive(lambda step, x: [SILENT[name]], config=BAYES)
    assert num_glass(mapper) == 0
    np.testing.assert_array_equal(mapper.occupancy().cells, mapper.laser_map().cells)


@pytest.mark.parametrize("name", SILENT)
def test_what_was_met_squarely_and_not_heard_again_has_gone_and_no_other_silence_says_so(name):
    mapper = drive(true_echo, config=BAYES)
    drive(lambda step, x: [SILENT[name]], mapper=mapper, passes=4)
    assert pane(mapper) == (0.0 if name in MISSES else 1.0)


def test_a_single_pass_of_void_readings_among_echoes_changes_nothing():
    plain = drive(true_echo, config=BAYES)
    mixed = drive(lambda step, x: [reading(math.nan), *true_echo(step, x)], config=BAYES)
    np.testing.assert_array_equal(plain.occupancy().cells, mixed.occupancy().cells)


def test_a_fixed_distance_ranger_is_left_out_for_it_tells_no_distance():
    near = PANE_Y - SONAR.y
    mapper = drive(lambda step, x: [reading(-math.inf, near, near)], config=BAYES)
    assert num_glass(mapper) == 0


def test_a_zero_field_of_view_maps_as_twenty_degrees():
    unsaid = drive(lambda step, x: [reading(0.9, fov=0.0)], config=BAYES)
    said = drive(true_echo, config=BAYES)
    assert num_glass(said) > 0
    np.testing.assert_array_equal(unsaid.occupancy().cells, said.occupancy().cells)


def test_a_stale_reading_is_left_out_and_counted():
    mapper = LayeredMapper(BAYES)
    for k in range(3):
        mapper.insert_scan((10 + k) * S, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.insert_range(2 * S, reading(0.9), SONAR, "left")
    assert (mapper.sonar_counts.placed, mapper.sonar_counts.unplaced) == (0, 1)


def test_a_missing_sonar_leaves_the_lasers_map_as_it_is():
    layers = drive(lambda step, x: [], config=BAYES).layers()
    np.testing.assert_array_equal(layers.occupancy.cells, layers.laser.cells)
    assert not (layers.glass.cells != UNKNOWN).any()


def test_cross_talk_makes_no_glass_for_its_echoes_share_no_line():
    rng = np.random.default_rng(0)

    def values(step, x):
        return [reading(rng.uniform(0.5, 2.5) if step % 4 == 0 else math.inf)]

    assert num_glass(drive(values, config=BAYES)) == 0


def test_a_pane_that_answers_only_within_its_critical_angle_is_whole_all_the_same():
    """The sonar sways: every other reading meets the pane at 0.4 rad and hears nothing."""
    mapper = LayeredMapper(BAYES)
    for step in range(NUM_STEPS):
        x, stamp_ns = 0.06 * step, step * S // 10
        here = SE2(x, 0.0, 0.4 * (step % 2))
        mapper.place_scan(stamp_ns, blind_to_glass(x), LASER, SE2(x, 0.0, 0.0))
        value = PANE_Y - SONAR.y if step % 2 == 0 else math.inf
        mapper.place_range(stamp_ns, reading(value), SONAR, "left", here)
    assert pane(mapper) == 1.0


def test_one_echo_in_n_at_a_place_where_nothing_is_makes_no_glass():
    sometimes = drive(lambda step, x: [reading(0.9 if step % 10 == 0 else math.inf)], config=BAYES)
    assert num_glass(sometimes) == 0


def test_a_pane_keeps_what_one_reading_in_ten_misses():
    mapper = drive(
        lambda step, x: true_echo(step, x) if step % 10 else [reading(math.inf)], config=BAYES
    )
    assert pane(mapper) == 1.0
