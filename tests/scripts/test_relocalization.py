"""What `evaluate.py relocalization` makes of a floor, and how it counts."""

import argparse
from itertools import chain, pairwise

import numpy as np
import pytest

from experiments.relocalization import Job, _jobs, shared
from experiments.relocalization_figures import Try, sent_cells, sent_figures, try_figures
from experiments.relocalization_floors import (
    CLEAR_M,
    LASER,
    Cut,
    MappedFloor,
    look_at,
    places,
    walk,
)
from experiments.relocalization_robot import (
    NEAR_M,
    NODE,
    SETTLED_SIGMAS,
    STEP_S,
    Outcome,
    Robot,
    Sent,
    is_right,
    judged_drive,
)
from floornav_common.grid import FREE, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig


def wall(x0, y0, x1, y1):
    return np.array([[x0, y0, x1, y1]], float)


NOTHING = np.zeros((0, 4))
ROOM = np.vstack((wall(-3, -2, 3, -2), wall(3, -2, 3, 2), wall(3, 2, -3, 2), wall(-3, 2, -3, -2)))


@pytest.fixture
def floor():
    """Return a room of 6 x 4 m whose map is bent: turned the more, the further right."""
    cells = np.full((60, 80), UNKNOWN, np.int8)
    cells[5:45, 5:65] = FREE
    driven = [SE2(x, 0.0, 0.0) for x in np.linspace(-2.0, 2.0, 9)]
    mapped = [SE2(p.x + 1.0, p.y, 0.02 * p.x) for p in driven]
    grid = OccupancyMap(cells, 0.1, SE2(-2.5, -2.5, 0.0))
    return MappedFloor("room", Cut(ROOM, NOTHING), grid, driven, mapped)


def test_a_beam_ends_at_the_wall_and_passes_a_pane_that_it_meets_at_a_slant():
    pane = wall(1.0, -1.0, 1.0, 1.0)
    rng = np.random.default_rng(0)
    scan = look_at(Cut(ROOM, pane), SE2(0.0, 0.0, 0.0), rng)
    middle = LASER.num_beams // 2
    ahead = np.nanmedian(scan.ranges[middle - 2 : middle + 3])
    beside = middle + round(np.deg2rad(20.0) / scan.angle_increment)
    at_20_deg = np.nanmedian(scan.ranges[beside - 2 : beside + 3])
    assert ahead == pytest.approx(1.0, abs=0.05)
    assert at_20_deg == pytest.approx(3.0 / np.cos(np.deg2rad(20.0)), abs=0.05)


def test_where_a_place_is_in_the_map_is_told_by_the_nearest_pose_of_the_drive(floor):
    for true, mapped in zip(floor.driven, floor.mapped, strict=True):
        assert floor.in_map(true) == mapped
    there = floor.in_map(SE2(2.0, 1.0, 0.5))
    expected = floor.mapped[-1] @ SE2(0.0, 1.0, 0.5)
    assert there.between(expected).distance < 1e-9


def test_places_are_free_in_the_map_and_in_the_room_and_the_way_stays_clear(floor):
    rng = np.random.default_rng(1)
    found = places(floor, 20, rng)
    assert len(found) == 20
    for pose in found:
        assert abs(pose.x) < 3.0 - CLEAR_M and abs(pose.y) < 2.0 - CLEAR_M
        poses = walk(floor, pose, 3.0, rng)
        assert poses[0] == pose
        assert all(abs(p.x) < 2.7 and abs(p.y) < 1.7 for p in poses)
        assert sum(a.between(b).distance for a, b in zip(poses, poses[1:], strict=False)) > 2.9


def test_a_claim_counts_as_found_or_as_false_and_silence_as_neither():
    near, far = Try(0.05, True, 1.0, 0.6, 0.9, 3), Try(0.2, False, 2.0, 0.9, 1.2, 4)
    turned, silent = Try(0.01, False, 3.0, 1.2, 1.5, 5), Try(None, False, 9.0, 6.0, 9.0, 20)
    figures = try_figures([near, near, far, turned, silent])
    assert figures["found_share"] == pytest.approx(0.4) and figures["false_claims"] == 2
    assert (figures["time_s"], figures["way_m"], figures["looks"]) == (1.0, 0.6, 3.0)
    assert figures["until_found_s"] == pytest.approx(1.9)
    assert try_figures([silent])["time_s"] is None


def test_right_is_within_10_cm_and_3_degrees():
    here = SE2(3.0, 1.0, 2.0)
    assert is_right(here, here @ SE2(0.9 * NEAR_M, 0.0, np.deg2rad(2.9)))
    assert not is_right(here, here @ SE2(1.1 * NEAR_M, 0.0, 0.0))
    assert not is_right(here, here @ SE2(0.0, 0.0, np.deg2rad(-3.1)))


RIGHT, WRONG = SE2(0.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0)


def carried_off(*words):
    """Return the outcome of a drive told scan by scan: what was sent, and whether believed."""
    said = {
        "wrong": Sent(WRONG, True, 0.1), "drift": Sent(WRONG, False, 0.1),
        "lost": Sent(None, False, 0.1), "right": Sent(RIGHT, True, 0.1),
    }  # fmt: skip
    return judged_drive((RIGHT, said[word]) for word in words)


def test_a_carried_robot_is_judged_by_what_it_believes_and_when_it_says_that_it_is_lost():
    found = carried_off("drift", "wrong", "drift", "lost", "lost", "right", "wrong")
    assert (found.lost_s, found.found_s) == (3 * STEP_S, 5 * STEP_S)
    assert (found.wrong_s, found.is_false) == (STEP_S, False)
    assert found.search_s == pytest.approx(0.6)
    fooled = carried_off("lost", "wrong", "right")
    assert (fooled.is_false, fooled.found_s, fooled.lost_s) == (True, None, 0.0)
    unaware = carried_off(*5 * ["wrong"])
    assert (unaware.lost_s, unaware.found_s, unaware.is_false) == (None, None, False)
    assert unaware.wrong_s == pytest.approx(5 * STEP_S)
    at_once = carried_off("drift", "right")
    assert (at_once.lost_s, at_once.found_s) == (None, STEP_S)


def test_outcomes_are_counted():
    outcomes = [
        Outcome(2.0, 0.5, False, lost_s=1.0), Outcome(None, 0.5, True, lost_s=3.0, wrong_s=0.3),
        Outcome(None, 0.5, False, wrong_s=0.9), Outcome(4.0, 0.5, False, lost_s=2.0),
    ]  # fmt: skip
    figures = sent_figures(outcomes)
    assert (figures["found_share"], figures["false_claims"], figures["said_lost"]) == (0.5, 1, 3)
    assert (figures["until_found_s"], figures["until_lost_s"]) == (3.5, 2.0)
    assert (figures["believed_wrong"], figures["believed_wrong_s_max"]) == (2, 0.9)
    assert sent_cells(figures)[:3] == ["4", "50.0 %", "1"]
    assert sent_figures([])["until_lost_s"] is None


def test_places_are_shared_among_floors():
    given = {"maps": 2, "places": None, "more": None, "first": 9000, "quick": True}
    jobs = _jobs(argparse.Namespace(**given, seed=0, way=6.0))
    assert jobs == [Job(9000, 6, 3, 6.0), Job(9001, 6, 3, 6.0)]
    assert shared(40, 5) == [8] * 5 and sum(shared(7, 3)) == 7 and shared(1, 2) in ([0, 1], [1, 0])


@pytest.fixture(scope="module")
def corner_room():
    """Return a room with a niche and a pillar, and its map: nothing in it looks like another."""
    niche = (wall(-3, 0.5, -1.5, 0.5), wall(-1.5, 0.5, -1.5, 2))
    corners = [(1, -1), (1.4, -1), (1.4, -0.6), (1, -0.6), (1, -1)]
    pillar = [wall(*a, *b) for a, b in pairwise(corners)]
    walls = np.vstack((ROOM, *niche, *pillar))
    driven = [SE2(x, y, 0.0) for x in np.linspace(-2.0, 2.0, 9) for y in (-1.2, 0.0, 1.2)]
    grid = OccupancyMap(np.full((100, 140), UNKNOWN, np.int8), 0.05, SE2(-3.5, -2.5, 0.0))
    grid.cells[10:90, 10:130] = FREE
    grid.cells[61:90, 10:39] = UNKNOWN  # the niche is closed, and so is the pillar
    grid.cells[31:37, 91:97] = UNKNOWN
    for x1, y1, x2, y2 in walls:
        line = np.linspace((x1, y1), (x2, y2), 400)
        cells = grid.to_cells(line)
        grid.cells[cells[:, 0], cells[:, 1]] = 100
    return MappedFloor("room", Cut(walls, NOTHING), grid, driven, driven)


def test_a_robot_is_followed_in_the_map_and_says_that_it_is_lost_when_carried_off(corner_room):
    robot, rng = Robot(corner_room, GridMapperConfig()), np.random.default_rng(2)
    robot.is_said_at(SE2(-2.0, -1.2, 0.0), SETTLED_SIGMAS)
    way = [SE2(x, -1.2, 0.0) for x in np.arange(-2.0, 0.0, 0.1)]
    sent = [s for _, s in robot.drive(way, rng)]
    assert sent[-1].is_trusted and is_right(way[-1], sent[-1].pose)
    nowhere, back = [SE2(40.0, 40.0, 0.0)] * 30, [SE2(2.2 - 0.05 * k, 1.2, 3.0) for k in range(60)]
    outcome = judged_drive(chain(robot.drive(nowhere, rng), robot.drive(back, rng)))
    assert outcome.lost_s == pytest.approx(NODE.lost_after_s, abs=2.1 * STEP_S)
    assert outcome.wrong_s == 0.0 and not outcome.is_false
    assert outcome.found_s is not None and outcome.found_s > 30 * STEP_S
