"""The published label grid against the definition of its sectors, cell by cell."""

import math

import numpy as np
import pytest
from worlds import scan_at, square_room

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import LabelGridConfig
from grid_mapper.label_grid import (
    LABEL_FREE,
    LABEL_OCCUPIED,
    LABEL_UNKNOWN,
    LabelGrid,
    remove_noise,
    sample_sectors,
    sector_rays,
)
from grid_mapper.tile_grid import SIDE_CELLS

RESOLUTION = 0.05


def sampled(grid: LabelGrid) -> tuple[dict, dict]:
    """Return labels and points by (row, col), unknown cells left out."""
    labels, corner = grid._grid.dense("labels")
    points, _ = grid._grid.dense("points")
    rows, cols = np.nonzero(labels)
    keys = [(int(r + corner[0]), int(c + corner[1])) for r, c in zip(rows, cols, strict=True)]
    return (
        dict(zip(keys, labels[rows, cols].tolist(), strict=True)),
        dict(zip(keys, points[rows, cols].tolist(), strict=True)),
    )


def by_definition(scan: Scan, pose: SE2, config: LabelGridConfig) -> tuple[dict, dict]:
    """Label every cell centre by the text of section 4.1, one beam and one cell at a time."""
    labels: dict = {}
    points: dict = {}
    given = config.beam_angle_rad
    half = 0.5 * (given if given > 0.0 else scan.angle_increment)
    reach = 5.2
    first = np.floor((np.array([pose.y, pose.x]) - reach) / RESOLUTION).astype(int)
    num = int(2 * reach / RESOLUTION)
    rows, cols = np.mgrid[first[0] : first[0] + num, first[1] : first[1] + num]
    dx, dy = (cols + 0.5) * RESOLUTION - pose.x, (rows + 0.5) * RESOLUTION - pose.y
    distance, bearing = np.hypot(dx, dy), np.arctan2(dy, dx)
    for r, angle, hit in zip(scan.ranges, scan.angles + pose.yaw, scan.is_hit, strict=True):
        off = np.abs((bearing - angle + np.pi) % (2 * np.pi) - np.pi)
        tolerance = config.range_tolerance_m if hit else 0.0
        length = r if hit else config.no_return_free_m
        inside = (off <= half) & (distance <= length + tolerance)
        for k in np.argwhere(inside):
            key = (int(rows[tuple(k)]), int(cols[tuple(k)]))
            if hit and distance[tuple(k)] >= length - tolerance:
                labels[key] = LABEL_OCCUPIED
                points[key] = points.get(key, 0) + 1
            else:
                labels.setdefault(key, LABEL_FREE)
                points.setdefault(key, 0)
    return labels, points


@pytest.mark.parametrize("yaw", [0.0, 0.3, 2.0, -2.9])
@pytest.mark.parametrize("beam_angle", [0.0, math.radians(2.0)])
def test_sectors_hold_the_cells_whose_centres_lie_in_them(yaw, beam_angle):
    pose = SE2(0.513, -0.207, yaw)
    scan = scan_at(pose, square_room(), num_beams=120, rng=np.random.default_rng(1))
    scan.ranges[::17] = np.inf
    config = LabelGridConfig(beam_angle_rad=beam_angle, no_return_free_m=2.0)
    grid = LabelGrid(config, RESOLUTION)
    grid.add_scan(scan, pose)
    labels, points = sampled(grid)
    expected_labels, expected_points = by_definition(scan, pose, config)
    assert labels == expected_labels
    assert points == expected_points


def test_one_beam_along_x_by_hand():
    """A beam of 1 m, 5 cm tolerance: centres 0.025 .. 0.925 free, 0.975 and 1.025 occupied."""
    grid = LabelGrid(LabelGridConfig(beam_angle_rad=0.01), RESOLUTION)
    grid.add_scan(Scan(np.array([1.0]), 0.0, 0.01, 0.1, 5.0), SE2(0.0, 0.025, 0.0))
    labels, points = sampled(grid)
    assert labels == {(0, c): LABEL_FREE for c in range(19)} | {
        (0, 19): LABEL_OCCUPIED, (0, 20): LABEL_OCCUPIED
    }  # fmt: skip
    assert points[0, 19] == points[0, 20] == 1


def test_an_occupied_cell_never_turns_free_and_gains_points():
    grid = LabelGrid(LabelGridConfig(beam_angle_rad=0.01), RESOLUTION)
    for ranges in ([1.0], [3.0], [1.0]):
        grid.add_scan(Scan(np.array(ranges), 0.0, 0.01, 0.1, 5.0), SE2(0.0, 0.025, 0.0))
    labels, points = sampled(grid)
    assert labels[0, 19] == LABEL_OCCUPIED and points[0, 19] == 2
    assert labels[0, 30] == LABEL_FREE


@pytest.mark.parametrize("value", [math.nan, -math.inf, 0.0, 0.05])
def test_beams_that_measured_nothing_leave_the_map_unchanged(value):
    grid = LabelGrid(LabelGridConfig(), RESOLUTION)
    grid.add_scan(Scan(np.full(10, value), 0.0, 0.1, 0.1, 5.0), SE2.identity())
    assert grid.occupancy().cells.size == 0


def test_a_beam_without_return_frees_no_further_than_asked():
    config = LabelGridConfig(beam_angle_rad=0.01, no_return_free_m=2.0)
    grid = LabelGrid(config, RESOLUTION)
    grid.add_scan(Scan(np.array([math.inf]), 0.0, 0.01, 0.1, 5.0), SE2(0.0, 0.025, 0.0))
    labels, _ = sampled(grid)
    assert set(labels.values()) == {LABEL_FREE}
    assert max(c for _, c in labels) == 39


def test_candidates_on_the_border_stay_and_others_are_cleared():
    """Free on the left, unknown on the right, a wall two cells deep between, and a lone cell."""
    labels = np.full((9, 12), LABEL_FREE, np.int8)
    labels[:, 6:8] = LABEL_OCCUPIED
    labels[:, 8:] = LABEL_UNKNOWN
    labels[4, 2] = LABEL_OCCUPIED
    points = np.where(labels == LABEL_OCCUPIED, 4, 0)
    judged = remove_noise(labels, points, noise_points=4, border_cells=2, hole_cells=0)
    assert (judged[:, 6:8] == LABEL_OCCUPIED).all()
    assert judged[4, 2] == LABEL_FREE


def test_more_points_than_the_threshold_are_no_candidate():
    labels = np.full((9, 9), LABEL_FREE, np.int8)
    labels[4, 4] = LABEL_OCCUPIED
    points = np.zeros((9, 9), int)
    points[4, 4] = 5
    assert remove_noise(labels, points, 4, 2, 25)[4, 4] == LABEL_OCCUPIED
    points[4, 4] = 4
    assert remove_noise(labels, points, 4, 2, 25)[4, 4] == LABEL_FREE


def test_the_map_can_be_asked_for_again_and_judging_changes_nothing():
    grid = LabelGrid(LabelGridConfig(), RESOLUTION)
    pose = SE2(0.1, 0.2, 0.3)
    for _ in range(6):
        first = grid.occupancy()
        assert (grid.occupancy().cells == first.cells).all()
        grid.add_scan(scan_at(pose, square_room()), pose)
    assert set(np.unique(grid.occupancy().cells)) == {UNKNOWN, FREE, OCCUPIED}


def test_a_room_is_free_inside_and_walled():
    grid = LabelGrid(LabelGridConfig(), RESOLUTION)
    pose = SE2(0.013, 0.021, 0.4)
    grid.add_scan(scan_at(pose, square_room(), num_beams=720), pose)
    grid_map = grid.occupancy()
    inside = grid_map.to_cells(np.array([[0.0, 0.0], [2.0, 2.0], [-2.0, -2.0]]))
    walls = grid_map.to_cells(np.array([[4.0, 0.5], [-4.0, -0.5], [0.5, 3.0], [0.5, -3.0]]))
    assert (grid_map.cells[inside[:, 0], inside[:, 1]] == FREE).all()
    assert (grid_map.cells[walls[:, 0], walls[:, 1]] == OCCUPIED).all()


@pytest.mark.parametrize("width", [0.35, 0.6, 1.5])
@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi, -1.0, 0.25 * math.pi])
def test_wide_sectors_at_long_range_label_their_cells_and_no_others(width, yaw):
    """The origin lies near a tile's corner, so that the edges run through tiles of their own."""
    far = 28.0
    grid = LabelGrid(LabelGridConfig(beam_angle_rad=width), RESOLUTION)
    pose = SE2(0.03, -0.04, yaw)
    grid.add_scan(Scan(np.array([far]), 0.0, 0.01, 0.1, 80.0), pose)
    labels, corner = grid._grid.dense("labels")
    rows, cols = np.mgrid[-600:600, -600:600]
    dx, dy = (cols + 0.5) * RESOLUTION - pose.x, (rows + 0.5) * RESOLUTION - pose.y
    distance = np.hypot(dx, dy)
    off = np.abs((np.arctan2(dy, dx) - yaw + np.pi) % (2.0 * np.pi) - np.pi)
    inside = (off <= 0.5 * width) & (distance <= far + 0.05)
    expected = np.where(inside, np.where(distance >= far - 0.05, 2, 1), 0)
    found = np.zeros_like(expected)
    r, c = np.nonzero(labels)
    found[r + corner[0] + 600, c + corner[1] + 600] = labels[r, c]
    # a centre on an edge may fall to either side by rounding
    on_edge = np.abs(np.abs(distance - far) - 0.05) < 1e-9
    on_edge |= np.abs(off - 0.5 * width) < 1e-9
    assert (found == expected)[~on_edge].all()


@pytest.mark.parametrize("yaw", [0.25 * math.pi, 0.75 * math.pi, -0.25 * math.pi, 100.0])
def test_the_widest_sector_ends_whatever_its_direction(yaw):
    config = LabelGridConfig(beam_angle_rad=math.nextafter(0.5 * math.pi, 0.0))
    grid = LabelGrid(config, RESOLUTION)
    grid.add_scan(Scan(np.full(4, 2.0), 0.0, 0.5 * math.pi, 0.1, 5.0), SE2(0.01, 0.02, yaw))
    num_cells = np.count_nonzero(grid._grid.dense("labels")[0])
    assert num_cells == pytest.approx(math.pi * (2.05 / RESOLUTION) ** 2, rel=0.02)


def test_a_coarse_scan_is_refused_by_its_numbers_and_taken_with_a_beam_angle():
    scan = Scan(np.full(4, 2.0), 0.25 * math.pi, 0.5 * math.pi, 0.1, 5.0)
    with pytest.raises(ValueError, match="0.7854.*beam_angle_rad 0.0, angle_increment 1.5708"):
        LabelGrid(LabelGridConfig(), RESOLUTION).add_scan(scan, SE2.identity())
    grid = LabelGrid(LabelGridConfig(beam_angle_rad=0.02), RESOLUTION)
    grid.add_scan(scan, SE2.identity())
    assert (grid.occupancy().cells == OCCUPIED).any()


def test_a_beam_angle_of_a_right_angle_is_refused():
    with pytest.raises(ValueError, match="beam_angle_rad"):
        LabelGridConfig(beam_angle_rad=0.5 * math.pi)


def test_cells_without_a_tile_are_skipped():
    labels, points = np.zeros((2, 64, 64), np.int8), np.zeros((2, 64, 64), np.uint16)
    table, corner = np.array([[0]], np.int32), np.zeros(2, np.int64)
    origins, ranges = np.array([[0.5, 0.5]]), np.array([100.0])
    hit = np.array([True])
    sample_sectors(origins, np.zeros(1), ranges, hit, 0.1, 1.0, labels, points, table, corner)
    assert labels[0].any()
    assert not labels[1].any() and not points[1].any()


def test_rays_of_a_sector_leave_no_point_of_it_aside():
    origins = np.array([[1.0, 2.0], [3.0, 4.0]])
    rays = sector_rays(origins, np.array([0.3, 1.0]), np.array([10.0, 500.0]), 0.15)
    begins, angles, lengths = rays
    assert angles[0] == pytest.approx(0.3) and lengths[0] == 10.0
    assert begins[0].tolist() == [1.0, 2.0] and (begins[1:] == [3.0, 4.0]).all()
    second, reach = angles[1:], SIDE_CELLS / 500.0
    assert np.diff(second).max() <= 2.0 * reach
    assert second[0] - 0.85 <= reach and 1.15 - second[-1] <= reach


def labels_with_hole(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return free labels with a square hole, a candidate beside it, and the candidate's points."""
    labels = np.full((40, 40), LABEL_FREE, np.int8)
    labels[20 : 20 + size, 20 : 20 + size] = LABEL_UNKNOWN
    labels[20, 19] = LABEL_OCCUPIED
    return labels, np.where(labels == LABEL_OCCUPIED, 1, 0)


@pytest.mark.parametrize(
    ("size", "hole_cells", "label"),
    [(4, 25, LABEL_FREE), (5, 25, LABEL_OCCUPIED), (1, 0, LABEL_OCCUPIED), (1, 2, LABEL_FREE)],
)
def test_only_unknown_regions_make_a_border(size, hole_cells, label):
    labels, points = labels_with_hole(size)
    assert remove_noise(labels, points, 4, 2, hole_cells)[20, 19] == label


def test_gaps_that_touch_at_corners_are_no_region():
    labels, points = labels_with_hole(0)
    for k in range(15):
        labels[20 + 2 * k % 20, 20] = LABEL_UNKNOWN
        labels[21 + k, 21 + k] = LABEL_UNKNOWN
    assert remove_noise(labels, points, 4, 2, 25)[20, 19] == LABEL_FREE


def test_what_lies_outside_is_a_border_however_small_the_map():
    labels = np.full((3, 3), LABEL_FREE, np.int8)
    labels[0, 1] = LABEL_OCCUPIED
    points = np.where(labels == LABEL_OCCUPIED, 1, 0)
    assert remove_noise(labels, points, 4, 1, 1000)[0, 1] == LABEL_OCCUPIED
