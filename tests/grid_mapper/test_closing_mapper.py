"""Mapping live with loops closed behind its back, without ROS."""

from collections import deque
from dataclasses import fields, replace

import numpy as np
import pytest
from loop_builders import drifted, largest_error, ring, round_the_ring
from worlds import scan_at

from floornav_common.grid import OCCUPIED
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from grid_mapper import loop_link, loop_session
from grid_mapper.background import InlineWorker
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.config import GridMapperConfig, LoopConfig, RelocationConfig
from grid_mapper.corrections import Corrections
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.loop_session import LoopSession
from grid_mapper.map_rebuild import MapRebuild
from grid_mapper.overlay import on_cells_of
from grid_mapper.surface_points import points_of

STEP_NS = 300_000_000
HERE = SE2.identity()
CONFIG = GridMapperConfig(loop=LoopConfig(recent_scans=20))


class LateWorker(InlineWorker):
    """Does the work at once, and gives each answer only after it was asked some times more."""

    def __init__(self, work, late):
        super().__init__(work)
        self._late, self._asked, self._due = late, 0, deque()

    def receive(self):
        self._asked += 1
        while (answer := super().receive()) is not None:
            self._due.append((self._asked + self._late, answer))
        is_due = self._due and self._due[0][0] <= self._asked
        return self._due.popleft()[1] if is_due else None


def closing(late=0, config=CONFIG):
    return ClosingMapper(config, LateWorker(LoopSession(config), late))


def drive(mappers, num=150, first=0, on_result=lambda result: None):
    """Drive 1.3 laps with a short-sighted laser and sonars; return the truth and the results."""
    truth = round_the_ring(150, 1.3)[:num]
    odometry = drifted(truth, 0.01, 1.05)
    results = []
    for k, (pose, odom) in enumerate(zip(truth, odometry, strict=True)):
        stamp_ns, rng = (first + k) * STEP_NS, np.random.default_rng(k)
        scan = scan_at(pose, ring(), num_beams=90, rng=rng, sigma=0.03, range_max=4.0)
        for mapper in mappers:
            results.append(mapper.insert_scan(stamp_ns, scan, HERE, odom))
            for side in (-1.0, 1.0):
                reading = RangeReading(0.9, 0.3, 0.02, 4.0)
                T_base_sonar = SE2(0.0, 0.0, side * np.pi / 2.0)
                mapper.insert_range(stamp_ns - STEP_NS // 3, reading, T_base_sonar, str(side))
        on_result(results[-len(mappers)])
    return truth, results


@pytest.fixture(scope="module", params=[0, 25])
def lap(request):
    mapper, offline = closing(request.param), LoopClosingLocalizer(CONFIG)
    followed = []

    def follow(result):
        followed.append((mapper.node, mapper.in_local(result.T_map_base).as_array()))

    truth, results = drive([mapper, offline], on_result=follow)
    return truth, mapper, results[::2], offline, followed


def test_the_way_so_far_is_corrected_and_meets_itself(lap):
    truth, mapper, results, _, followed = lap
    nodes, local = (np.array(column) for column in zip(*followed, strict=True))
    corrected = Corrections.as_poses(mapper.corrections.all_at(nodes, local))
    uncorrected = Corrections.as_poses(local)
    assert mapper.graph.num_loops > 0 and mapper.failure == ""
    assert revisit_error(uncorrected, truth) > 0.25
    assert revisit_error(corrected, truth) < 0.12
    assert results[0].T_map_base == HERE


def test_the_pose_of_now_is_in_the_corrected_map(lap):
    truth, mapper, results, _, followed = lap
    nodes, local = (np.array(column) for column in zip(*followed, strict=True))
    corrected = Corrections.as_poses(mapper.corrections.all_at(nodes, local))
    assert results[-1].T_map_base.between(corrected[-1]).distance < 1e-9


def revisit_error(poses, truth):
    """Return the mean error of the motion from the first lap to the second at the same place."""
    lap = round(len(truth) / 1.3)
    pairs = [(k, k + lap) for k in range(len(truth) - lap)]
    off = [
        truth[i].between(truth[j]).between(poses[i].between(poses[j])).distance for i, j in pairs
    ]
    return float(np.mean(off))


def test_maps_are_those_made_offline_at_the_poses_of_the_graph(lap):
    _, mapper, _, offline, _ = lap
    other = LayeredMapper(CONFIG)
    rebuild = MapRebuild(other, offline.known_poses())
    drive([rebuild])
    cells, expected = (
        on_cells_of(m.layers().occupancy, mapper.layers().occupancy) for m in (mapper, other)
    )
    assert np.mean(cells == expected) > 0.97
    assert np.mean(cells[expected == OCCUPIED] == OCCUPIED) > 0.8
    assert mapper.sonar_counts.placed == other.sonar_counts.placed
    assert mapper.sonar_counts.counted == pytest.approx(other.sonar_counts.counted, rel=0.02)


def test_the_maps_change_count_grows_with_every_swap_and_reset_forgets_all():
    mapper = closing()
    counts = []
    for num in (100, 150):
        drive([mapper], num)
        counts.append(mapper.num_changes)
    mapper.reset()
    assert counts[0] < counts[1] and mapper.layers().occupancy.cells.size == 0
    _, results = drive([mapper], 20, first=10_000)
    assert results[0].T_map_base == HERE and mapper.graph.num_nodes <= 20
    assert results[-1].is_trusted


def test_values_set_while_it_runs_hold_for_maps_made_anew_and_the_loops_are_read_only(monkeypatch):
    made = []
    monkeypatch.setattr(loop_session, "LayeredMapper", lambda c: made.append(c) or LayeredMapper(c))
    mapper = closing()
    drive([mapper], 20)
    label = replace(CONFIG.label, no_return_free_m=0.0)
    mapper.reconfigure(replace(CONFIG, label=label))
    drive([mapper], 150, first=1000)
    assert mapper.num_swaps > 0 and {config.label for config in made} == {label}
    assert all(f.metadata["read_only"] for f in (*fields(LoopConfig), *fields(RelocationConfig)))


def test_a_robot_moved_by_hand_goes_on_where_it_is_said_to_be():
    mapper = closing()
    truth, _ = drive([mapper], 40)
    there = truth[0].between(truth[3])
    rng = np.random.default_rng(5)
    scan = scan_at(truth[3], ring(), num_beams=90, rng=rng, sigma=0.03, range_max=4.0)
    points = points_of(scan, HERE, CONFIG.matcher)
    mapper.relocate(there @ SE2(0.1, -0.1, 0.05), seen=points.moved(there))
    result = mapper.insert_scan(41 * STEP_NS, scan, HERE, SE2(7.0, 0.0, 0.0))
    assert result.is_trusted and result.T_map_base.between(there).distance < 0.05


def test_what_was_said_before_a_jump_in_time_is_found_again_at_the_first_pose():
    config = replace(CONFIG, loop=replace(CONFIG.loop, recent_scans=5))
    mapper = closing(config=config)
    drive([mapper], 60)
    mapper.break_motion()
    truth, results = drive([mapper], 10)
    assert all(r.is_trusted for r in results[2:])
    expected = [truth[0].between(pose) for pose in truth[2:]]
    assert largest_error([r.T_map_base for r in results[2:]], expected) < 0.2


class HeldWorker(InlineWorker):
    """Gives no answer while it is held."""

    is_held, num_begun = True, 0

    def receive(self):
        return None if self.is_held else super().receive()

    def begin_anew(self):
        self.num_begun += 1


class DyingWorker(InlineWorker):
    """Dies when told to; begins anew with work that knows nothing."""

    def begin_anew(self):
        self.failure, self._work = "", LoopSession(CONFIG)


def test_a_background_that_died_begins_anew_at_reset():
    worker = DyingWorker(LoopSession(CONFIG))
    mapper = ClosingMapper(CONFIG, worker)
    drive([mapper], 20)
    worker.failure = "ended with code -9"
    drive([mapper], 20, first=1000)
    assert mapper.failure == "ended with code -9"
    mapper.reset()
    drive([mapper], 20, first=10_000)
    assert mapper.failure == "" and 0 < mapper.graph.num_nodes <= 20


def test_a_background_that_is_too_slow_is_given_up_until_reset_and_mapping_goes_on(monkeypatch):
    monkeypatch.setattr(loop_link, "MAX_PENDING", 60)
    work = LoopSession(CONFIG)
    worker = HeldWorker(work)
    mapper, alone = ClosingMapper(CONFIG, worker), closing(10**9)
    drive([mapper, alone], 110)  # the first lap
    assert "until ~/reset" in mapper.failure and worker.num_begun == 1
    num_known = len(work._closer.frames)
    worker.is_held = False  # it catches up too late
    _, results = drive([mapper, alone], 150, first=1000)
    assert "until ~/reset" in mapper.failure and len(work._closer.frames) == num_known
    cells = on_cells_of(mapper.layers().occupancy, alone.layers().occupancy)
    assert np.array_equal(cells, alone.layers().occupancy.cells)
    assert all(
        a.T_map_base == b.T_map_base for a, b in zip(results[::2], results[1::2], strict=True)
    )
    mapper.reset()
    drive([mapper], 20, first=10_000)
    assert mapper.failure == "" and 0 < mapper.graph.num_nodes <= 20
    assert len(work._closer.frames) == mapper.node + 1
