"""A robot followed in a map made before: carried off it is doubted, among new things it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from loop_builders import ring, round_the_ring
from test_relocalizer import CONFIG, HERE, map_of
from worlds import box, scan_at

from floornav_common.se2 import SE2
from grid_mapper.fit_watch import NUM_SCANS, PERIOD_NS, FitWatch
from grid_mapper.map_surfaces import surfaces_of
from grid_mapper.match_verdict import ScanResult

WAY = round_the_ring(60)


@pytest.fixture(scope="module")
def surfaces():
    return surfaces_of(map_of(ring(), WAY))


def doubts(surfaces, poses, believed, walls=None, overlap=0.9):
    watch = FitWatch(CONFIG.relocation.max_contradiction)
    said = []
    for k, (pose, claimed) in enumerate(zip(poses, believed, strict=True)):
        scan = scan_at(pose, ring() if walls is None else walls, range_max=8.0)
        result = ScanResult(claimed, np.eye(3), True, "", overlap)
        said.append(watch.doubt(k * PERIOD_NS, scan, HERE, result, surfaces))
    return said


def test_where_it_is_it_is_not_doubted(surfaces):
    assert not any(doubts(surfaces, WAY[5:15], WAY[5:15]))


def test_people_and_boxes_that_came_raise_no_doubt(surfaces):
    things = [box(p.x + 0.5, p.y + 0.35, p.x + 0.9, p.y + 0.7) for p in WAY[4:18:2]]
    assert not any(doubts(surfaces, WAY[5:15], WAY[5:15], np.vstack((ring(), *things))))


def test_where_walls_would_have_to_be_seen_through_it_is_doubted(surfaces):
    across = [SE2(pose.x, pose.y, pose.yaw + np.pi / 2) for pose in WAY[5:15]]
    said = doubts(surfaces, WAY[5:15], across)
    assert not any(said[: NUM_SCANS - 1]) and all(
        "seen through" in words for words in said[NUM_SCANS - 1 :]
    )


def test_scans_that_fit_badly_one_after_the_other_are_doubted(surfaces):
    said = doubts(surfaces, WAY[5:15], WAY[5:15], overlap=0.4)
    assert "40 % of each" in said[-1] and not any(said[: NUM_SCANS - 1])


def test_scans_count_that_are_apart_in_time_and_not_what_was_before(surfaces):
    watch = FitWatch(CONFIG.relocation.max_contradiction)
    result, scan = ScanResult(WAY[5], np.eye(3), True, "", 0.1), scan_at(WAY[5], ring())
    assert watch.is_due(0)
    said = [watch.doubt(k * PERIOD_NS, scan, HERE, result, surfaces) for k in range(NUM_SCANS)]
    assert said[-1] and not watch.is_due((NUM_SCANS - 1) * PERIOD_NS + PERIOD_NS // 2)
    watch.forget()
    assert watch.is_due(0) and not watch.doubt(0, scan, HERE, replace(result), surfaces)
