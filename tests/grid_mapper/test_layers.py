"""Laser and sonars together, and each row of the sonars' table on the map (docs/map-glass.md)."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pane_drives import (
    LASER,
    NUM_STEPS,
    PANE_Y,
    SILENT,
    SONAR,
    STEP_M,
    S,
    blind_to_glass,
    cell,
    drive,
    num_glass,
    pane,
    reading,
    true_echo,
)
from worlds import drive_around, scan_at, square_room

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN
from floornav_common.se2 import SE2
from grid_mapper.bayes_config import BayesConfig
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.sonar_config import SonarConfig
from grid_mapper.waiting_readings import MAX_WAITING


def test_a_pane_that_the_laser_sees_through_is_in_the_map_and_alone_in_its_layer():
    mapper = drive(true_echo)
    assert pane(mapper) == 1.0
    layers = mapper.layers()
    assert cell(layers.laser, 1.0, PANE_Y) == FREE
    assert cell(layers.sonar, 1.0, PANE_Y) == OCCUPIED
    assert cell(layers.glass, 1.0, PANE_Y) == OCCUPIED
    assert cell(layers.occupancy, 1.0, 3.0) == OCCUPIED  # the wall behind, by laser
    assert cell(layers.glass, 1.0, 3.0) == UNKNOWN
    rows, _ = np.nonzero(layers.glass.cells == OCCUPIED)
    ys = layers.glass.to_points(np.argwhere(layers.glass.cells == OCCUPIED))[:, 1]
    assert len(rows) and np.abs(ys - PANE_Y).max() < 0.15


def test_echoes_of_what_the_laser_calls_unknown_or_occupied_change_nothing():
    mapper = drive(lambda step, x: [reading(3.5)])  # half a meter behind the wall
    assert num_glass(mapper) == 0
    np.testing.assert_array_equal(mapper.occupancy().cells, mapper.laser_map().cells)


@pytest.mark.parametrize("name", SILENT)
def test_a_reading_without_echo_makes_no_glass_and_takes_none_away(name):
    mapper = drive(lambda step, x: [SILENT[name]])
    assert num_glass(mapper) == 0
    np.testing.assert_array_equal(mapper.occupancy().cells, mapper.laser_map().cells)
    with_pane = drive(true_echo)
    drive(lambda step, x: [SILENT[name]], mapper=with_pane)
    assert pane(with_pane) == 1.0


def test_a_reading_that_says_nothing_does_not_stand_in_for_one_that_does():
    """Between measurements many drivers send NaN; the next echo counts, at the same place."""
    mapper = drive(lambda step, x: [reading(math.nan), *true_echo(step, x)])
    assert pane(mapper) == 1.0
    assert mapper.sonar_counts.void == mapper.sonar_counts.counted == NUM_STEPS


def test_a_fixed_distance_ranger_that_detects_puts_an_arc_at_its_distance():
    mapper = drive(lambda step, x: [reading(-math.inf, PANE_Y - SONAR.y, PANE_Y - SONAR.y)])
    assert pane(mapper) == 1.0


def test_a_zero_field_of_view_maps_as_twenty_degrees():
    unsaid = drive(lambda step, x: [reading(0.9, fov=0.0)])
    said = drive(true_echo)
    np.testing.assert_array_equal(unsaid.occupancy().cells, said.occupancy().cells)


def test_a_stale_reading_older_than_all_scans_is_left_out_and_counted():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    mapper.insert_range(S, reading(0.9), SONAR, "left")
    for k in range(3):
        mapper.insert_scan((10 + k) * S, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.insert_range(2 * S, reading(0.9), SONAR, "left")
    assert (mapper.sonar_counts.placed, mapper.sonar_counts.unplaced) == (0, 2)


def test_a_missing_sonar_leaves_the_lasers_map_as_it_is():
    mapper = drive(lambda step, x: [])
    layers = mapper.layers()
    np.testing.assert_array_equal(layers.occupancy.cells, layers.laser.cells)
    assert layers.sonar.cells.size == 0 and not (layers.glass.cells != UNKNOWN).any()


def test_cross_talk_that_comes_now_and_then_makes_no_glass():
    """One reading in four is another sonar's echo, at a distance that means nothing."""
    rng = np.random.default_rng(0)

    def values(step, x):
        return [reading(rng.uniform(0.5, 2.5) if step % 4 == 0 else math.inf)]

    assert num_glass(drive(values)) == 0


def test_specular_misses_leave_the_pane_where_enough_echoes_remain():
    """Half the readings of the pass hear nothing off the smooth pane; a second pass fills up."""
    mapper = drive(lambda step, x: true_echo(step, x) if step % 2 else [reading(math.inf)])
    assert pane(mapper) < 1.0
    drive(lambda step, x: true_echo(step, x) if step % 2 else [reading(math.inf)], mapper=mapper)
    assert pane(mapper) == 1.0


def test_one_echo_in_n_at_a_place_where_nothing_is_makes_no_glass():
    mapper = drive(lambda step, x: [reading(0.9 if step % 10 == 0 else math.inf)])
    assert num_glass(mapper) == 0


def test_an_obstacle_that_was_removed_stays_in_the_published_map():
    """Points only grow (section 5): this is what `fusion: bayes` is for."""
    mapper = drive(true_echo)
    drive(lambda step, x: [reading(math.inf)], mapper=mapper, passes=3)
    assert pane(mapper) == 1.0


@pytest.mark.parametrize("per_step", [3, 20])
def test_the_map_does_not_depend_on_the_sonars_rate(per_step):
    slow = drive(true_echo)
    fast = drive(lambda step, x: true_echo(step, x) * per_step)
    assert fast.sonar_counts.placed == per_step * slow.sonar_counts.placed
    for name in ("occupancy", "sonar", "glass"):
        a, b = getattr(slow.layers(), name), getattr(fast.layers(), name)
        np.testing.assert_array_equal(a.cells, b.cells)


def test_each_sonar_is_counted_by_itself():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    for k in range(8):
        mapper.place_range(k, reading(1.0), SE2(0.0, 0.0, k * 0.7), f"s{k}", SE2.identity())
    assert mapper.sonar_counts.counted == 8


def test_a_robot_without_laser_drives_by_its_sonars():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    for step in range(NUM_STEPS):
        at = SE2(step * STEP_M, 0.0, 0.0)
        mapper.place_range(step, reading(0.9), SONAR, "left", at)
    grid = mapper.occupancy()
    assert cell(grid, 1.0, PANE_Y) == OCCUPIED and cell(grid, 1.0, 0.5) == FREE
    np.testing.assert_array_equal(grid.cells, mapper.sonar_map().cells)


def test_a_reading_is_placed_between_the_scans_round_its_own_stamp():
    """The robot drives 1 m/s; the reading is stamped halfway between two scans 0.1 s apart."""
    config = GridMapperConfig(fusion="overlay", sonar=SonarConfig(min_points=1.0))
    mapper = LayeredMapper(config)
    for k, x in enumerate((0.0, 0.1)):
        if k:
            mapper.insert_range(S // 20, reading(1.0), SE2(0.0, 0.0, 0.0), "front")
            assert mapper.sonar_counts.placed == 0  # its pose is not known yet
        mapper.insert_scan(k * S // 10, blind_to_glass(x), LASER, SE2(x, 0.0, 0.0))
    assert mapper.sonar_counts.placed == 1
    points, origin = mapper.sonar_points()
    cols = np.nonzero(points.sum(axis=0))[0]
    assert np.mean(cols + 0.5) * 0.05 + origin.x == pytest.approx(1.05, abs=0.03)


def test_readings_that_come_late_or_in_any_order_give_the_same_map():
    poses = drive_around(30)
    maps = []
    for is_late in (False, True):
        mapper = LayeredMapper(
            GridMapperConfig(fusion="overlay", sonar=SonarConfig(min_points=1.0))
        )
        late = []
        for k, pose in enumerate(poses):
            each = (k * S // 10 - S // 30, reading(0.8), SONAR, f"s{k % 3}")
            if is_late:
                late.append(each)
            else:
                mapper.insert_range(*each)
            scan = scan_at(pose @ LASER, square_room())
            mapper.insert_scan(k * S // 10, scan, LASER, poses[0].between(pose))
        for each in sorted(late):
            mapper.insert_range(*each)
        assert mapper.sonar_counts.placed == 29
        maps.append(mapper.layers())
    np.testing.assert_array_equal(maps[0].sonar.cells, maps[1].sonar.cells)
    np.testing.assert_array_equal(maps[0].glass.cells, maps[1].glass.cells)


def test_scans_too_far_apart_in_time_place_no_reading_between_them():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    for stamp_ns in (0, 7 * S):
        mapper.insert_scan(stamp_ns, blind_to_glass(0.0), LASER, SE2.identity())
        mapper.insert_range(stamp_ns + S, reading(0.9), SONAR, "left")
    assert (mapper.sonar_counts.placed, mapper.sonar_counts.unplaced) == (0, 1)
    slow = LayeredMapper(GridMapperConfig(fusion="overlay", sonar=SonarConfig(max_pose_gap_s=7.5)))
    for stamp_ns in (0, 7 * S):
        slow.insert_scan(stamp_ns, blind_to_glass(0.0), LASER, SE2.identity())
        slow.insert_range(stamp_ns + S, reading(0.9), SONAR, "left")
    assert slow.sonar_counts.placed == 1


def test_a_pose_told_from_outside_is_not_joined_with_the_one_before():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    mapper.insert_scan(0, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.relocate(SE2(1.0, 0.0, 0.0))
    mapper.insert_range(S // 20, reading(0.9), SONAR, "left")
    mapper.insert_scan(S // 10, blind_to_glass(1.0), LASER, SE2.identity())
    assert (mapper.sonar_counts.placed, mapper.sonar_counts.unplaced) == (0, 1)


def test_readings_that_wait_are_bounded_and_a_break_drops_them():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    for k in range(MAX_WAITING + 10):
        mapper.insert_range(k, reading(0.9), SONAR, "left")
    assert mapper.sonar_counts.unplaced == 10
    mapper.break_motion()
    assert mapper.sonar_counts.unplaced == MAX_WAITING + 10


def test_a_sonar_whose_clock_is_ahead_takes_no_room_from_the_others():
    for is_started in (False, True):
        mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
        if is_started:
            mapper.insert_scan(0, blind_to_glass(0.0), LASER, SE2.identity())
        for k in range(2 * MAX_WAITING):
            mapper.insert_range(3600 * S + k, reading(0.9), SONAR, "ahead")
        for k in range(1, 5):
            mapper.insert_range(k * S // 10 - 1, reading(0.9), SONAR, "right")
        for k in range(5):
            mapper.insert_scan(k * S // 10 + 1, blind_to_glass(0.0), LASER, SE2.identity())
        assert mapper.sonar_counts.placed == 4
        expected = 2 * MAX_WAITING if is_started else MAX_WAITING
        assert mapper.sonar_counts.unplaced == expected


@pytest.mark.parametrize("seconds", [4.9, 5.1])
def test_a_reading_may_be_five_seconds_ahead_of_the_scans(seconds):
    config = GridMapperConfig(fusion="overlay", sonar=SonarConfig(max_pose_gap_s=20.0))
    mapper = LayeredMapper(config)
    mapper.insert_scan(0, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.insert_range(round(seconds * S), reading(0.9), SONAR, "left")
    mapper.insert_scan(10 * S, blind_to_glass(0.0), LASER, SE2.identity())
    assert mapper.sonar_counts.placed == (seconds < 5.0)


def test_after_a_break_no_reading_is_placed_between_the_poses_on_both_sides_of_it():
    mapper = LayeredMapper(GridMapperConfig(fusion="overlay"))
    mapper.insert_scan(0, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.break_motion()
    mapper.insert_range(S // 20, reading(0.9), SONAR, "left")
    for k in range(8):  # believed again once scans have gone on fitting for half a meter
        x = 0.1 * k
        mapper.insert_scan((k + 1) * S // 10, blind_to_glass(x), LASER, SE2(x, 0.0, 0.0))
    assert (mapper.sonar_counts.placed, mapper.sonar_counts.unplaced) == (0, 1)


@pytest.mark.parametrize("fusion", ["overlay", "bayes", "none"])
@pytest.mark.parametrize(
    ("said", "is_weighed"),
    [
        (reading(math.nan), False),
        (reading(4.5), False),
        (reading(math.inf, high=math.inf), False),
        (reading(math.inf), True),
        (reading(0.9), True),
    ],
)
def test_a_robot_that_stands_changes_maps_only_by_what_its_panes_weigh(fusion, said, is_weighed):
    mapper = LayeredMapper(GridMapperConfig(fusion=fusion))
    mapper.place_scan(0, blind_to_glass(0.0), LASER, SE2.identity())
    mapper.place_range(0, said, SONAR, "left", SE2.identity())
    before = mapper.num_changes
    for k in range(1, 6):
        mapper.place_range(k, said, SONAR, "left", SE2.identity())
    assert mapper.num_changes - before == (5 if fusion == "bayes" and is_weighed else 0)
    assert mapper.sonar_counts.placed == 6


def test_reset_forgets_glass_and_counts():
    mapper = drive(true_echo)
    mapper.reset()
    assert mapper.num_changes == 0 and mapper.layers().sonar.cells.size == 0


def test_no_fusion_leaves_the_sonars_out_of_the_map():
    mapper = drive(true_echo, config=GridMapperConfig(fusion="none"))
    assert pane(mapper) == 0.0 and num_glass(mapper) == 0
    assert cell(mapper.sonar_map(), 1.0, PANE_Y) == OCCUPIED


def test_values_changed_on_the_way_count_from_the_next_map_on():
    mapper = drive(true_echo)
    assert num_glass(mapper) > 0
    mapper.reconfigure(GridMapperConfig(fusion="overlay", sonar=SonarConfig(min_points=1e6)))
    assert num_glass(mapper) == 0


def test_values_changed_on_the_way_reach_the_fusion():
    mapper = drive(true_echo, config=GridMapperConfig(fusion="bayes"))
    assert num_glass(mapper) > 0 and mapper.num_bytes > mapper.laser.num_bytes
    mapper.reconfigure(GridMapperConfig(fusion="bayes", bayes=BayesConfig(pane_views=1e6)))
    assert num_glass(mapper) == 0


@pytest.mark.parametrize("fusion", ["overlay", "bayes", "none"])
def test_a_moment_gives_the_layers_of_then_whatever_comes_later(fusion):
    config = GridMapperConfig(fusion=fusion)
    mapper, same = drive(true_echo, config=config), drive(true_echo, config=config)
    before, moment = same.layers(), mapper.moment()
    mapper.reset()
    drive(lambda step, x: [reading(0.5)], mapper=mapper)
    mapper.reconfigure(GridMapperConfig(fusion=fusion, sonar=SonarConfig(min_points=1e6)))
    for name in ("occupancy", "laser", "sonar", "glass"):
        then, now = getattr(before, name), getattr(moment.layers(), name)
        np.testing.assert_array_equal(then.cells, now.cells)
        assert then.origin == now.origin


@pytest.mark.parametrize("fusion", ["overlay", "bayes"])
def test_layers_made_in_a_thread_while_mapping_goes_on_change_nothing_of_it(fusion):
    config = GridMapperConfig(fusion=fusion)
    alone, watched = LayeredMapper(config), LayeredMapper(config)
    with ThreadPoolExecutor(1) as thread:
        asked = []
        for mapper in (alone, watched):
            for step in range(NUM_STEPS):
                here = SE2(step * STEP_M, 0.0, 0.0)
                mapper.place_scan(step * S // 10, blind_to_glass(here.x), LASER, here)
                mapper.place_range(step * S // 10, true_echo(0, 0.0)[0], SONAR, "left", here)
                if mapper is watched:
                    asked.append(thread.submit(mapper.moment().layers))
        assert all(len(one.result().occupancy.cells) for one in asked)
    np.testing.assert_array_equal(
        asked[-1].result().occupancy.cells, alone.layers().occupancy.cells
    )
    np.testing.assert_array_equal(watched.occupancy().cells, alone.occupancy().cells)
