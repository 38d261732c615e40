"""A lost robot in a map that is there: found where it is, told nothing where places are alike."""

from __future__ import annotations

import numpy as np
import pytest
from loop_builders import ring, round_the_ring
from worlds import box, scan_at, square_room

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.global_search import GlobalSearch
from grid_mapper.layers import LayeredMapper
from grid_mapper.map_surfaces import surfaces_of
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.relocation_messages import Forget, Found, Look, NewMap, NotFound, Prior

HERE = SE2.identity()
CONFIG = GridMapperConfig()
NS = 1_000_000_000
TOL_M, TOL_RAD = 0.05, 0.02


def map_of(walls, poses, config=CONFIG):
    """Return the map of scans taken at true poses; its frame is the world's."""
    mapper = LayeredMapper(config)
    for k, pose in enumerate(poses):
        mapper.place_scan(k * NS, scan_at(pose, walls), HERE, pose)
    return mapper.occupancy()


def looks_at(walls, poses, prior=None):
    rng = np.random.default_rng(3)
    scans = [scan_at(pose, walls, rng=rng, range_max=8.0) for pose in poses]
    odometry = [SE2(7.0, -3.0, 1.0) @ poses[0].between(pose) for pose in poses]
    pairs = enumerate(zip(scans, odometry, strict=True))
    return [Look(k, scan, HERE, odom, prior) for k, (scan, odom) in pairs]


@pytest.fixture(scope="module")
def ring_map():
    return map_of(ring(), round_the_ring(60))


@pytest.fixture
def in_ring(ring_map):
    relocalizer = Relocalizer(CONFIG)
    relocalizer.take(NewMap(ring_map))
    return relocalizer


def is_near(pose, truth):
    off = truth.between(pose)
    return off.distance < TOL_M and abs(off.yaw) < TOL_RAD


def test_a_wall_lies_where_the_laser_saw_it_and_faces_the_free_side():
    cells = np.full((20, 20), UNKNOWN, np.int8)
    cells[:, :10], cells[:, 10:12] = FREE, OCCUPIED  # sampled 5 cm before and behind x = 0.55
    surfaces = surfaces_of(OccupancyMap(cells, 0.05, HERE))
    middle = np.abs(surfaces.points[:, 1] - 0.5) < 0.3
    assert surfaces.points[middle, 0] == pytest.approx(0.55, abs=1e-6)
    assert surfaces.normals[middle] == pytest.approx(np.tile((-1.0, 0.0), (middle.sum(), 1)))
    assert (surfaces.covs[middle, 0] < surfaces.covs[middle, 2]).all()


def test_surfaces_move_with_the_map():
    cells = np.full((20, 20), FREE, np.int8)
    cells[5:8, 5:15] = OCCUPIED
    T = SE2(3.0, -2.0, 0.7)
    here = surfaces_of(OccupancyMap(cells, 0.05, HERE)).moved(T)
    there = surfaces_of(OccupancyMap(cells, 0.05, T))
    np.testing.assert_allclose(here.points, there.points, atol=1e-9)
    np.testing.assert_allclose(here.normals, there.normals, atol=1e-9)


@pytest.mark.parametrize("k", [5, 27, 48])
def test_the_best_place_of_the_whole_map_is_the_true_one(ring_map, k):
    truth = round_the_ring(60)[k] @ SE2(0.13, 0.21, 0.4)
    points = scan_at(truth, ring(), range_max=8.0).points()
    peaks = GlobalSearch(ring_map).find(points, 0.8, 5)
    off = truth.between(peaks[0].pose)
    assert off.distance < 0.1 and abs(off.yaw) < 0.03
    assert [peak.score for peak in peaks] == sorted((p.score for p in peaks), reverse=True)


def test_a_robot_is_found_once_a_second_look_agrees(in_ring):
    truth = round_the_ring(60)[10:18]
    answers = [in_ring.take(look) for look in looks_at(ring(), truth)]
    assert isinstance(answers[0], NotFound) and answers[0].number == 0
    found = [answer for answer in answers if isinstance(answer, Found)]
    assert found and is_near(found[0].T_map_base, truth[found[0].number])
    assert len(found[0].seen) > 100


def test_said_about_where_it_is_one_look_is_enough(in_ring):
    truth = round_the_ring(60)[30]
    prior = Prior(truth @ SE2(0.6, -0.4, 0.3), np.diag([0.5, 0.5, 0.3]) ** 2)
    answer = in_ring.take(looks_at(ring(), [truth], prior)[0])
    assert isinstance(answer, Found) and is_near(answer.T_map_base, truth)


def test_a_place_elsewhere_that_fits_better_is_no_rival_of_where_it_is_said_to_be():
    rooms = [box(x - 2.0, -1.5, x + 2.0, 1.5) for x in (-3.0, 3.0)]
    niche = box(-3.0 - 1.9, 0.9, -3.0 - 1.3, 1.4)  # tells up from down
    rooms += [niche, niche + (6.0, 0.0, 6.0, 0.0)]
    chest = box(0.2, -1.4, 0.8, -0.4)
    walls = np.vstack((*rooms, chest + (3.0, 0.0, 3.0, 0.0)))
    relocalizer = Relocalizer(CONFIG)
    relocalizer.take(NewMap(map_of(walls, [SE2(x, 0.2, 0.0) for x in (-3.6, -2.4, 2.4, 3.6)])))
    now = np.vstack((*rooms, chest + (-3.0, 0.0, -3.0, 0.0)))  # the chest stands elsewhere by now
    truth = SE2(-3.4, 0.3, 0.2)
    prior = Prior(truth @ SE2(0.1, -0.1, 0.05), np.diag([0.2, 0.2, 0.1]) ** 2)
    answer = relocalizer.take(looks_at(now, [truth], prior)[0])
    assert isinstance(answer, Found) and is_near(answer.T_map_base, truth)
    relocalizer.take(Forget())
    anywhere = relocalizer.take(looks_at(now, [truth])[0])
    assert isinstance(anywhere, NotFound)


def test_a_wrong_word_on_where_it_is_is_not_believed(in_ring):
    truth = round_the_ring(60)
    prior = Prior(truth[45], np.diag([0.3, 0.3, 0.2]) ** 2)
    assert isinstance(in_ring.take(looks_at(ring(), [truth[12]], prior)[0]), NotFound)


def test_in_a_room_that_looks_the_same_turned_round_nothing_is_claimed():
    walls = box(-4, -3, 4, 3)
    relocalizer = Relocalizer(CONFIG)
    relocalizer.take(NewMap(map_of(walls, [SE2(x, 0.3, 0.0) for x in (-2.0, 0.0, 2.0)])))
    truth = [SE2(-2.0 + 0.4 * k, 1.0, 0.1 * k) for k in range(8)]
    answers = [relocalizer.take(look) for look in looks_at(walls, truth)]
    assert all(isinstance(answer, NotFound) for answer in answers)
    assert "other place" in answers[-1].reason


def test_in_a_building_that_is_not_in_the_map_nothing_is_claimed(in_ring):
    truth = [SE2(-1.5 + 0.4 * k, -0.5, 0.3) for k in range(6)]
    answers = [in_ring.take(look) for look in looks_at(square_room(), truth)]
    assert all(isinstance(answer, NotFound) for answer in answers)


def corridor_with(*pillars):
    walls = np.array([[-9.0, -1.2, 9.0, -1.2], [9.0, 1.2, -9.0, 1.2]])
    return np.vstack((walls, *(box(x - 0.2, y - 0.2, x + 0.2, y + 0.2) for x, y in pillars)))


def test_where_moved_furniture_pulls_a_look_nothing_is_claimed():
    stayed, before = ((-2.0, -1.0), (-1.0, 1.0)), ((1.2, -1.0), (2.2, 1.0), (3.4, -1.0))
    truth, shifted = SE2(0.0, 0.0, 0.2), [(x + 0.25, y) for x, y in before]
    relocalizer = Relocalizer(CONFIG)
    way = [SE2(x, 0.0, 0.0) for x in (-1.5, 0.0, 1.5)]
    relocalizer.take(NewMap(map_of(corridor_with(*stayed, *before), way)))
    prior = Prior(truth, np.diag([0.1, 0.1, 0.1]) ** 2)
    same = relocalizer.take(looks_at(corridor_with(*stayed, *before), [truth], prior)[0])
    assert isinstance(same, Found) and is_near(same.T_map_base, truth)
    relocalizer.take(Forget())
    pulled = relocalizer.take(looks_at(corridor_with(*stayed, *shifted), [truth], prior)[0])
    assert isinstance(pulled, NotFound) and "disagree" in pulled.reason


def test_what_was_seen_before_somebody_carried_the_robot_counts_no_longer(in_ring):
    truth = round_the_ring(60)
    in_ring.take(looks_at(ring(), truth[10:11])[0])
    in_ring.take(Forget())
    answers = [in_ring.take(look) for look in looks_at(ring(), truth[40:48])]
    found = [answer for answer in answers if isinstance(answer, Found)]
    assert isinstance(answers[0], NotFound)
    assert found and is_near(found[0].T_map_base, truth[40 + found[0].number])


def test_without_a_map_and_without_points_it_says_so(in_ring):
    look = looks_at(ring(), round_the_ring(60)[:1])[0]
    assert "no map" in Relocalizer(CONFIG).take(look).reason
    blind = scan_at(SE2(0.0, 0.0, 0.0), box(-40, -40, 40, 40), range_max=8.0)
    assert "0 points" in in_ring.take(Look(1, blind, HERE, HERE)).reason
