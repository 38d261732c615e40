"""What is kept to make maps anew: nothing lost that counts, and no more for standing there long."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.corrections import Corrections
from grid_mapper.kept_archive import READINGS_A_CELL, SCANS_A_CELL, KeptArchive
from grid_mapper.kept_events import KeptReading, KeptScan, ReadingsToKeep

HERE = SE2.identity()
NOTHING_KNOWN = Corrections.of([], [])


def scan_of(ranges, range_max=30.0):
    return Scan(np.array(ranges, float), -1.0, 0.01, 0.1, range_max)


def kept_scan(number, pose=HERE, ranges=(1.0,), node=-1):
    return KeptScan(number, number, scan_of(ranges), HERE, pose, node, False, None)


def kept_reading(number, pose=HERE, sensor="left"):
    return KeptReading(number, number, RangeReading(1.0, 0.3, 0.1, 4.0), HERE, pose, -1, sensor)


def all_of(archive):
    return list(archive.from_index(0, len(archive)))


@given(st.lists(st.floats(0.0, 30.0) | st.sampled_from([np.nan, np.inf, -np.inf]), max_size=30))
def test_ranges_come_back_to_a_millimeter_and_what_is_no_number_as_it_was(ranges):
    archive = KeptArchive()
    archive.add(kept_scan(0, ranges=ranges))
    back = all_of(archive)[0].scan
    np.testing.assert_allclose(back.ranges, ranges, atol=0.0006)
    assert (back.angle_min, back.range_max) == (-1.0, 30.0)


def test_of_one_place_and_direction_the_newest_stay():
    archive = KeptArchive()
    num = 3 * SCANS_A_CELL
    for k in range(num):
        archive.add(kept_scan(2 * k, SE2(0.1, 0.1, 0.1)))
        archive.add(kept_reading(2 * k + 1, SE2(0.05, 0.05, 0.1)))
    archive.add(kept_scan(2 * num, SE2(0.1, 0.1, 2.0)))
    archive.add(kept_reading(2 * num + 1, SE2(0.05, 0.05, 0.1), "right"))
    archive.thin(NOTHING_KNOWN)
    numbers = [event.number for event in all_of(archive)]
    assert numbers == sorted(numbers)
    scans = [k for k in range(0, 2 * num, 2)][-SCANS_A_CELL:] + [2 * num]
    readings = [k for k in range(1, 2 * num, 2)][-READINGS_A_CELL:] + [2 * num + 1]
    assert numbers == sorted(scans + readings)


def test_places_are_those_of_the_corrected_poses():
    archive = KeptArchive()
    for k in range(2 * SCANS_A_CELL):
        archive.add(kept_scan(k, SE2(0.1 + 3.0 * (k % 2), 0.1, 0.1), node=k % 2))
    apart = Corrections.of([SE2(0.1, 0.1, 0.1), SE2(3.1, 0.1, 0.1)], [HERE, SE2(3.0, 0.0, 0.0)])
    archive.thin(apart)
    assert len(archive) == 2 * SCANS_A_CELL
    archive.thin(Corrections.of([SE2(0.1, 0.1, 0.1), SE2(3.1, 0.1, 0.1)], [HERE, HERE]))
    assert len(archive) == SCANS_A_CELL


def test_hours_at_one_place_fill_no_more_than_the_place():
    archive = KeptArchive()
    sizes = []
    for k in range(20_000):
        archive.add(kept_scan(k, SE2(0.1, 0.1, 0.1)))
        if archive.is_full:
            archive.thin(NOTHING_KNOWN)
        sizes.append(len(archive))
    assert max(sizes) < 3000


def test_a_robot_that_stands_keeps_as_many_readings_as_weigh():
    keep = ReadingsToKeep(GridMapperConfig().bayes)
    same = RangeReading(1.0, 0.3, 0.1, 4.0)
    taken = [keep.take(k, same, HERE, "left") for k in range(10)]
    assert taken == [True, True, True] + 7 * [False]
    assert keep.take(10, RangeReading(1.5, 0.3, 0.1, 4.0), HERE, "left")
    assert keep.take(11, same, SE2(0.03, 0.0, 0.0), "left")
    assert keep.take(12, same, HERE, "right")


def test_the_motion_of_a_sweep_is_kept():
    archive = KeptArchive()
    seen = Scan(np.array([1.0, 2.0]), 0.0, 0.1, 0.1, 30.0, -0.01, (0.1, 0.2, 0.3))
    archive.add(KeptScan(0, 0, seen, HERE, HERE, -1, False, None))
    back = all_of(archive)[0].scan
    assert (back.time_increment, back.twist) == (-0.01, (0.1, 0.2, 0.3))
