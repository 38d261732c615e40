"""A scan falls into the things that it shows."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scans import Circle, Wall, drawn_scan

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.scan_clusters import cluster_beams

ROOM: list[Wall] = [(-3, -3, 3, -3), (3, -3, 3, 3), (3, 3, -3, 3), (-3, 3, -3, -3)]


def things(scan: Scan) -> tuple[int, np.ndarray, np.ndarray]:
    num = len(scan.ranges)
    labels, ends = np.empty(num, dtype=np.int64), np.empty((num, 3), dtype=np.int64)
    count = cluster_beams(
        scan.ranges, scan.range_min, scan.range_max, abs(scan.angle_increment), 0.8, labels, ends
    )
    return count, labels, ends[:count]


def test_nothing_seen_is_no_thing() -> None:
    count, labels, _ = things(drawn_scan())
    assert count == 0
    assert (labels == -1).all()


def test_each_body_in_the_open_is_a_thing_with_all_its_beams() -> None:
    circles: list[Circle] = [(2.0, 0.0, 0.2), (0.0, 3.0, 0.2), (-2.0, -1.0, 0.2)]
    scan = drawn_scan(circles)
    count, labels, ends = things(scan)
    assert count == 3
    assert ends[:, 2].sum() == (labels >= 0).sum() == np.isfinite(scan.ranges).sum()


def test_a_body_across_the_end_of_a_full_turn_is_one_thing() -> None:
    count, labels, ends = things(drawn_scan([(-2.0, 0.0, 0.2)]))
    assert count == 1
    assert ends[0, 0] > ends[0, 1]  # from the last beams on into the first
    assert labels[0] == labels[-1] == 0


def test_a_closed_room_is_one_thing() -> None:
    assert things(drawn_scan(walls=ROOM))[0] == 1


def test_a_slanted_wall_stays_in_one_piece_up_to_a_grazing_angle() -> None:
    # 0.5 m aside, along the way ahead: at 7.5 m neighboring ends are 1 m apart.
    assert things(drawn_scan(walls=[(0.5, 0.5, 8.0, 0.5)], num_beams=720))[0] == 1


@pytest.mark.parametrize("gap", [0.05, 0.3, 1.0])
def test_a_body_before_a_wall_is_apart_from_it(gap: float) -> None:
    away = 3.0 - 0.2 - gap
    scan = drawn_scan([(away, 0.0, 0.2)], [(3, -3, 3, 3)])
    _, labels, _ = things(scan)
    ahead = labels[len(labels) // 2]
    left_of_it = labels[len(labels) // 2 + 60]  # 30 degrees
    assert ahead != left_of_it
    expected = 2.0 * np.arcsin(0.2 / away) / scan.angle_increment
    assert (labels == ahead).sum() == pytest.approx(expected, abs=1.0)


def test_a_lost_beam_does_not_part_a_thing() -> None:
    scan = drawn_scan([(2.0, 0.0, 0.2)])
    scan.ranges[len(scan.ranges) // 2] = np.nan
    assert things(scan)[0] == 1


def test_two_people_shoulder_to_shoulder_are_two() -> None:
    count, labels, _ = things(drawn_scan([(2.0, 0.2, 0.2), (2.0, -0.2, 0.2)]))
    assert count == 2
    assert np.ptp(np.bincount(labels[labels >= 0])) <= 2


def test_a_turned_sensor_sees_the_same_things() -> None:
    circles: list[Circle] = [(2.0, 0.3, 0.2), (-1.0, 2.0, 0.06), (-0.6, 2.2, 0.06)]
    counts = {
        things(drawn_scan(circles, ROOM, SE2(0.0, 0.0, yaw)))[0]
        for yaw in np.linspace(-3.0, 3.0, 13)
    }
    assert len(counts) == 1
