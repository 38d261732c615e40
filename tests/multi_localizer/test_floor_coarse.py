"""Fits from starts: where they end, and which of them are one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_masks import mask_of, rectangle, small_camera

from floornav_common.se2 import SE2
from multi_localizer.floor_coarse import FINE_PX, fit_starts, is_same, solved
from multi_localizer.floor_rays import BorderScanner
from multi_localizer.floor_walls import NUM_SEEN, wall_ahead, walls_from, walls_of
from multi_localizer.pose_estimate import difference

CAMERA, PLAN = small_camera(), rectangle(2.74, 1.525)
POSE = SE2(0.4, 0.2, 0.3)
MATES = np.array([s.as_array() for s in PLAN.symmetries])
TOL_M = 0.01


def fits_from(starts, first_px=36.0, num_kept=5):
    scanned = BorderScanner(CAMERA, 1.02 * PLAN.reach).scan(mask_of(CAMERA, PLAN, POSE))
    values = np.ascontiguousarray(scanned.values[::4])
    fits = np.empty((num_kept, 5))
    num = fit_starts(values, np.array(starts), walls_of(PLAN), MATES, first_px, fits, 0)
    return fits[:num]


def test_the_wall_ahead_is_the_first_that_a_bearing_meets():
    walls = walls_of(PLAN)
    seen = np.empty((len(walls), NUM_SEEN))
    num = walls_from(walls, 0.37, 0.0, seen)
    assert num == 4
    for way, far in (((1, 0), 1.0), ((0, 1), 0.7625), ((-1, 0), 1.74), ((0, -1), 0.7625)):
        k, near = wall_ahead(seen, num, float(way[0]), float(way[1]))
        assert k >= 0 and near == pytest.approx(1.0 / far)
    assert walls_from(walls, 3.0, 0.0, seen) == 3  # from outside one wall shows its back


@pytest.mark.parametrize("off", [(0.2, -0.1, 0.2), (-0.15, 0.1, -0.25)])
def test_a_start_beside_the_truth_leads_to_it(off):
    (found,) = fits_from([POSE.as_array() + off])
    assert np.abs(difference(SE2(*found[:3]), POSE)).max() < TOL_M
    assert found[4] < 0.1


def test_starts_of_one_pose_and_of_its_mate_make_one_fit():
    near = POSE.as_array() + (0.05, 0.05, 0.1)
    mate = (PLAN.symmetries[1] @ SE2(*near)).as_array()
    assert len(fits_from([near, mate, POSE.as_array()])) == 1


def test_fits_come_out_sorted_and_no_more_than_there_is_room_for():
    rng = np.random.default_rng(0)
    starts = rng.uniform((-1.2, -0.6, -3.0), (1.2, 0.6, 3.0), (20, 3))
    every, few = fits_from(starts, FINE_PX, 20), fits_from([*starts, POSE.as_array()], FINE_PX, 1)
    assert (np.diff(every[:, 4]) >= 0.0).all()
    assert len(few) == 1 and few[0, 4] == pytest.approx(every[0, 4], abs=0.02)


def test_same_is_near_in_place_and_turn_round_the_circle_too():
    none = MATES[:1]
    assert is_same(
        np.array((0.0, 0.0, math.pi - 0.02)), np.array((0.05, 0.0, 0.02 - math.pi)), none
    )
    assert not is_same(np.zeros(3), np.array((0.0, 0.0, 0.2)), none)
    assert not is_same(np.zeros(3), np.array((0.2, 0.0, 0.0)), none)


def test_the_step_solves_the_normal_equations():
    A = np.random.default_rng(0).normal(size=(9, 4))
    H, b = 50.0 * A.T @ A, np.array((1.0, -2.0, 0.5, 3.0))
    want = np.linalg.solve(H + np.diag((0.0, 0.0, 0.0, 1.0)), b)
    assert solved(np.column_stack((np.triu(H), b))) == pytest.approx(want, rel=1e-4)
