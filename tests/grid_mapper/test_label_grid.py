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
)

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
    half = 0.5 * (config.beam_angle_rad or scan.angle_increment)
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
    judged = remove_noise(labels, points, noise_points=4, border_cells=2)
    assert (judged[:, 6:8] == LABEL_OCCUPIED).all()
    assert judged[4, 2] == LABEL_FREE


def test_more_points_than_the_threshold_are_no_candidate():
    labels = np.full((9, 9), LABEL_FREE, np.int8)
    labels[4, 4] = LABEL_OCCUPIED
    points = np.zeros((9, 9), int)
    points[4, 4] = 5
    assert remove_noise(labels, points, 4, 2)[4, 4] == LABEL_OCCUPIED
    points[4, 4] = 4
    assert remove_noise(labels, points, 4, 2)[4, 4] == LABEL_FREE


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
