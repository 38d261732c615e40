"""A robot in a map that was made before: looked for, found, carried off, found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from loop_builders import ring, round_the_ring
from test_relocalizer import HERE, NS, is_near, map_of
from worlds import box, scan_at

from floornav_common.grid import OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.se2 import SE2
from grid_mapper.background import InlineWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, GridMapperNodeConfig
from grid_mapper.glass_files import GLASS
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_session import LoopSession
from grid_mapper.map_files import save_map
from grid_mapper.match_verdict import found_words
from grid_mapper.nodes.lost_robot import LostRobot
from grid_mapper.overlay import on_cells_of
from grid_mapper.recovery import Recovery
from grid_mapper.relocalizer import Relocalizer
from grid_mapper.relocation_messages import Prior
from grid_mapper.start_map import StartMap, load_start_map

CONFIG = GridMapperConfig()
STEP_NS = NS // 4
WALLS = ring()


@pytest.fixture(scope="module")
def grid():
    return map_of(WALLS, round_the_ring(60))


def recovery_in(grid):
    return Recovery(CONFIG, lambda: InlineWorker(Relocalizer(CONFIG)), lambda: grid)


class Robot:
    """Drives in the map as the node has it: looked for while lost, else followed."""

    def __init__(self, grid, is_frozen, config=CONFIG):
        self.mapper = LayeredMapper(config, start=StartMap(grid, grid), is_frozen=is_frozen)
        self.recovery = recovery_in(grid)
        self.odometry, self.step = SE2(4.0, 4.0, 2.0), 0

    def drive(self, poses, walls=WALLS, lost=None):
        """Drive through true poses; return the results, and at which steps it was found."""
        results, found_at, last = [], [], poses[0]
        rng = np.random.default_rng(self.step)
        for k, pose in enumerate(poses):
            self.odometry @= last.between(pose)
            last = pose
            scan = scan_at(pose, walls, rng=rng, range_max=8.0)
            if lost is not None:
                lost.is_jump(self.step * STEP_NS, self.odometry)
            if self.recovery.is_active:
                found = self.recovery.look(scan, HERE, self.odometry)
                if found is not None:
                    self.mapper.relocate(found.T_map_base, found.cov, found.seen)
                    found_at.append(k)
            self.step += 1
            results.append(self.mapper.insert_scan(self.step * STEP_NS, scan, HERE, self.odometry))
        return results, found_at


def test_from_anywhere_it_is_found_followed_and_found_again_when_carried_off(grid):
    robot, way = Robot(grid, is_frozen=True), round_the_ring(120)
    assert robot.recovery.start()
    results, found_at = robot.drive(way[20:34])
    assert len(found_at) == 1
    assert not any(r.is_trusted for r in results[: found_at[0]])
    for result, truth in zip(results[found_at[0] :], way[20 + found_at[0] :], strict=False):
        assert result.is_trusted and is_near(result.T_map_base, truth)

    results, _ = robot.drive(way[70:86])  # carried there: odometry felt nothing
    assert not any(r.is_trusted for r in results[-3:])
    robot.mapper.lose()
    assert robot.recovery.start()
    results, found_at = robot.drive(way[86:105])
    assert len(found_at) == 1 and robot.recovery.num_found == 2
    assert is_near(results[-1].T_map_base, way[104])


def test_near_where_it_is_said_to_be_it_is_found_without_moving(grid):
    robot, truth = Robot(grid, is_frozen=True), round_the_ring(60)[20]
    robot.recovery.start(Prior(truth @ SE2(0.5, 0.5, -0.2), np.zeros((3, 3))))
    results, found_at = robot.drive([truth] * 4)
    assert found_at == [1] and is_near(results[-1].T_map_base, truth)


def test_a_wrong_word_is_given_up_for_the_whole_map(grid):
    robot, way = Robot(grid, is_frozen=True), round_the_ring(120)
    robot.recovery.start(Prior(way[90], np.diag([0.3, 0.3, 0.2]) ** 2))
    results, found_at = robot.drive(way[20:45])
    assert len(found_at) == 1 and is_near(results[-1].T_map_base, way[44])


def test_a_robot_that_stands_is_looked_at_once(grid):
    robot = Robot(grid, is_frozen=True)
    robot.recovery.start()
    results, found_at = robot.drive([round_the_ring(60)[20]] * 10)
    assert found_at == [] and "second look" in robot.recovery.reason
    assert not any(r.is_trusted for r in results)


def test_before_there_is_a_map_nothing_is_looked_for():
    recovery = Recovery(CONFIG, lambda: pytest.fail("not needed"), lambda: None)
    assert not recovery.start() and not recovery.is_active


@pytest.mark.parametrize("rule", ["label", "log_odds"])
def test_the_map_begun_with_is_kept_or_goes_on(grid, rule):
    config, way = replace(CONFIG, grid=rule), round_the_ring(120)
    cells = {}
    cut = np.where(np.arange(grid.cells.shape[1]) < 150, grid.cells, UNKNOWN).astype(np.int8)
    half = OccupancyMap(cut, grid.resolution, grid.origin)
    for is_frozen in (True, False):
        robot = Robot(half, is_frozen, config)
        robot.mapper.relocate(way[5], np.diag([0.05, 0.05, 0.02]) ** 2)
        robot.drive(way[5:40])
        cells[is_frozen] = on_cells_of(robot.mapper.occupancy(), grid)
    seeded = half.cells != UNKNOWN
    is_wall = cells[True] > 50
    assert np.array_equal(is_wall[seeded], half.cells[seeded] == OCCUPIED)
    assert (cells[True][~seeded] == UNKNOWN).all()
    agrees = (cells[False] > 50) == (grid.cells == OCCUPIED)
    known = (cells[False] != UNKNOWN) & (grid.cells != UNKNOWN) & ~seeded
    assert known.sum() > 5000 and agrees[known].mean() > 0.95


def test_a_map_of_other_resolution_and_turn_is_taken(grid):
    T = SE2(1.0, 2.0, 0.4)
    moved = OccupancyMap(grid.cells, grid.resolution, T @ grid.origin)
    robot, way = Robot(moved, is_frozen=True), round_the_ring(120)
    robot.recovery.start()
    results, found_at = robot.drive(way[20:34])
    assert len(found_at) == 1 and is_near(results[-1].T_map_base, T @ way[33])


def test_glass_of_the_layer_beside_the_map_is_nothing_a_laser_sees(tmp_path, grid):
    glass = np.full(grid.cells.shape, UNKNOWN, np.int8)
    glass[40:60, 100] = OCCUPIED
    both = np.where(glass == OCCUPIED, np.int8(OCCUPIED), grid.cells)
    path = save_map(tmp_path / "floor", OccupancyMap(both, grid.resolution, grid.origin))
    save_map(tmp_path / f"floor{GLASS}", OccupancyMap(glass, grid.resolution, grid.origin))
    start = load_start_map(path)
    assert (start.occupancy.cells[40:60, 100] == OCCUPIED).all()
    assert not (start.laser.cells[40:60, 100] == OCCUPIED).any()


def test_a_map_without_obstacles_is_refused(tmp_path):
    empty = OccupancyMap(np.zeros((9, 9), np.int8), 0.05, HERE)
    with pytest.raises(ValueError, match="no obstacle"):
        load_start_map(save_map(tmp_path / "empty", empty))


def test_walls_that_are_elsewhere_are_not_taken_for_the_map(grid):
    robot = Robot(grid, is_frozen=True)
    robot.recovery.start()
    room = np.vstack((box(-3.0, -2.0, 3.0, 2.5), box(0.5, 0.5, 1.0, 1.5)))
    poses = [SE2(-2.0 + 0.25 * k, -1.0, 0.05 * k) for k in range(14)]
    results, found_at = robot.drive(poses, room)
    assert found_at == [] and not any(r.is_trusted for r in results)


def test_a_robot_lost_in_the_map_it_makes_is_found_there_and_maps_on():
    pytest.importorskip("gtsam")
    mapper = ClosingMapper(CONFIG, InlineWorker(LoopSession(CONFIG)))
    way, T_map_world = round_the_ring(120), round_the_ring(120)[0].inverse()
    rng = np.random.default_rng(2)

    def insert(step, pose, odom):
        scan = scan_at(pose, WALLS, rng=rng, range_max=8.0)
        return scan, mapper.insert_scan(step * STEP_NS, scan, HERE, odom)

    for k, pose in enumerate(way[:70]):
        insert(k, pose, pose)
    recovery = recovery_in(mapper.layers().laser)
    mapper.lose()
    recovery.start()
    nodes = mapper.graph.num_nodes
    found_at = None
    for k, truth in enumerate(way[20:50]):  # carried back; odometry goes on from where it was
        odom = way[69] @ way[20].between(truth)
        scan = scan_at(truth, WALLS, rng=rng, range_max=8.0)
        if recovery.is_active and (found := recovery.look(scan, HERE, odom)) is not None:
            mapper.relocate(found.T_map_base, found.cov, found.seen)
            found_at = k
        result = mapper.insert_scan((100 + k) * STEP_NS, scan, HERE, odom)
        assert result.is_trusted == (found_at is not None)
    assert found_at is not None and is_near(result.T_map_base, T_map_world @ way[49])
    assert mapper.graph.num_nodes > nodes


@pytest.mark.parametrize("use_odom", [True, False])
def test_said_where_it_is_it_goes_on_at_a_place_that_no_recent_scan_shows(use_odom):
    pytest.importorskip("gtsam")
    config = replace(CONFIG, loop=replace(CONFIG.loop, recent_scans=10))
    mapper = ClosingMapper(config, InlineWorker(LoopSession(config)))
    way, rng, step = round_the_ring(120), np.random.default_rng(3), 0

    def insert(truth, odom):
        nonlocal step
        step += 1
        scan = scan_at(truth, WALLS, rng=rng, range_max=8.0)
        lost.look(scan, HERE, odom)
        return mapper.insert_scan(step * STEP_NS, scan, HERE, odom)

    node_config = GridMapperNodeConfig(use_odom=use_odom)
    lost = LostRobot(mapper, recovery_in(None), node_config)
    for pose in way[:45]:
        insert(pose, pose if use_odom else None)
    lost = LostRobot(mapper, recovery_in(mapper.layers().laser), node_config)
    truth = way[0].between(way[4])
    lost.is_said_at(truth @ SE2(0.2, -0.2, 0.1), np.diag([0.25, 0.25, 0.07]))
    results = [insert(way[4], way[44] if use_odom else None) for _ in range(3)]
    assert results[-1].is_trusted and is_near(results[-1].T_map_base, truth)


def test_when_odometry_jumps_a_word_on_where_the_robot_is_still_counts(grid):
    robot, truth = Robot(grid, is_frozen=True), round_the_ring(60)[20]
    node_config = GridMapperNodeConfig(start_map="ring", keep_start_map=True)
    lost = LostRobot(robot.mapper, robot.recovery, node_config)
    lost.is_said_at(truth, np.diag([0.2, 0.2, 0.1]) ** 2)
    blind, scan = scan_at(SE2(50.0, 0.0, 0.0), WALLS), scan_at(truth, WALLS, range_max=8.0)
    assert not lost.is_jump(0, HERE)
    assert lost.look(blind, HERE, HERE) is None  # of before the simulator began anew
    far = SE2(4.0, 0.0, 2.0)
    assert lost.is_jump(NS // 10, far)
    found = [lost.look(scan, HERE, far) for _ in range(2)]
    assert found[0] is None and is_near(found[1], truth)
    assert lost.looked_for_s(2 * NS) == pytest.approx(2.0)
    assert (
        found_words(SE2(1.0, -2.0, np.pi), 2.04)
        == "found at x 1.00 m, y -2.00 m, yaw 180 deg after 2.0 s"
    )


@pytest.mark.parametrize("goes_on", [True, False])
def test_after_a_jump_of_time_it_is_looked_for_where_odometry_jumped_too(grid, goes_on):
    robot, way = Robot(grid, is_frozen=True), round_the_ring(120)
    lost = LostRobot(robot.mapper, robot.recovery, GridMapperNodeConfig(start_map="ring"))
    _, found_at = robot.drive(way[20:34], lost=lost)
    assert len(found_at) == 1
    lost.restart()
    robot.step -= 10
    if not goes_on:
        robot.odometry = SE2(-2.0, 1.0, 0.5) @ robot.odometry
    results, found_at = robot.drive(way[33:50], lost=lost)
    assert len(found_at) == (0 if goes_on else 1)
    first = 0 if goes_on else found_at[0]
    assert not any(r.is_trusted for r in results[:first])
    assert results[first].is_trusted and is_near(results[-1].T_map_base, way[49])


def test_time_that_jumps_while_lost_begins_no_search_anew(grid):
    robot, way = Robot(grid, is_frozen=True), round_the_ring(120)
    lost = LostRobot(robot.mapper, robot.recovery, GridMapperNodeConfig(start_map="ring"))
    results, found_at = robot.drive(way[20:22], lost=lost)
    assert not found_at and not any(r.is_trusted for r in results)
    lost.restart()
    results, found_at = robot.drive(way[21:36], lost=lost)
    assert len(found_at) == 1 and is_near(results[-1].T_map_base, way[35])
    assert not any(r.is_trusted for r in results[: found_at[0]])


def test_a_search_whose_process_died_begins_anew(grid):
    class Dying(InlineWorker):
        def begin_anew(self):
            self.failure, self._work = "", Relocalizer(CONFIG)

    worker, truth = Dying(Relocalizer(CONFIG)), round_the_ring(60)[20]
    recovery = Recovery(CONFIG, lambda: worker, lambda: grid)
    recovery.start()
    worker.failure = "ended with code -9"
    assert recovery.look(scan_at(truth, WALLS, range_max=8.0), HERE, SE2.identity()) is None
    assert recovery.reason == "ended with code -9"
    recovery.start(Prior(truth, np.diag([0.3, 0.3, 0.2]) ** 2))  # the map has to be sent again
    found = [
        recovery.look(scan_at(truth, WALLS, range_max=8.0), HERE, SE2.identity()) for _ in range(4)
    ]
    assert any(f is not None and is_near(f.T_map_base, truth) for f in found)


def test_a_search_begins_anew_in_the_map_that_was_corrected_meanwhile():
    """A place in the map of before is none in that of now, till then nothing is believed."""
    mapper = ClosingMapper(CONFIG, InlineWorker(LoopSession(CONFIG)))
    maps = [map_of(WALLS, round_the_ring(60)) for _ in range(2)]
    shown = [maps[0]]
    recovery = Recovery(CONFIG, lambda: InlineWorker(Relocalizer(CONFIG)), lambda: shown[0])
    lost, truth = LostRobot(mapper, recovery, GridMapperNodeConfig()), round_the_ring(60)[20]
    scan = scan_at(truth, WALLS, range_max=8.0)
    lost.is_said_at(truth, np.diag([0.3, 0.3, 0.2]) ** 2)
    assert lost.look(scan, HERE, SE2.identity()) is None  # sent; its answer is there at the next
    mapper.num_swaps += 1
    for _ in range(3):
        assert lost.look(scan, HERE, SE2.identity()) is None and lost.is_looked_for
    shown[0] = maps[1]  # published
    found = [lost.look(scan, HERE, SE2.identity()) for _ in range(4)]
    assert found[0] is None and any(f is not None and is_near(f, truth) for f in found[1:])
    assert recovery.current_map is maps[1] and lost.num_found == 1
