"""What `evaluate.py relocalization` makes of a floor, and how it counts."""

import numpy as np
import pytest

from experiments.relocalization import NEAR_M, Try, _figures
from experiments.relocalization_floors import (
    CLEAR_M,
    LASER,
    Cut,
    MappedFloor,
    look_at,
    places,
    walk,
)
from floornav_common.grid import FREE, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2


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
    near = Try(0.5 * NEAR_M, 0.01, 1.0, 0.6, 3)
    far, turned = Try(2.0 * NEAR_M, 0.01, 2.0, 0.9, 4), Try(0.01, 0.2, 3.0, 1.2, 5)
    silent = Try(None, None, 9.0, 6.0, 20)
    figures = _figures([near, near, far, turned, silent])
    assert figures["found_share"] == pytest.approx(0.4) and figures["false_claims"] == 2
    assert (figures["time_s"], figures["way_m"], figures["looks"]) == (1.0, 0.6, 3.0)
    assert _figures([silent])["time_s"] is None
