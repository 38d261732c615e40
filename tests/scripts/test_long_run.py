import argparse

import numpy as np
import pytest
from loop_builders import frames_at, ring

from experiments.corridor_loop import ring_laps
from experiments.long_run import KEYS, check, key_scans, run
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.frame_thinning import emptied
from grid_mapper.loop_closer import LoopCloser


def test_a_lap_is_told_of_with_all_figures():
    values = {}
    args = argparse.Namespace(laps=1, speed=0.5, scans_a_place=2, seed=0, quiet=True)
    run(args, values)
    (row,) = values["laps"]
    assert tuple(row) == KEYS
    assert 55.0 < row["way_m"] < 75.0 and row["hours"] == row["way_m"] / 0.5 / 3600.0
    assert row["ate_m"] < 0.1 and 0 < row["scans_kept"] <= row["nodes"]


def test_only_scans_that_are_held_count():
    here = SE2(0.0, -4.0, 0.0)
    frames = frames_at([here] * 2, [here] * 2, ring())
    closer = LoopCloser(GridMapperConfig())
    closer.frames = [emptied(frames[0]), frames[1]]
    points = len(frames[1].points)
    assert key_scans(closer) == (1, 8 * (7 * points + len(frames[1].scan.ranges)))


def test_laps_of_one_corridor_differ_by_their_drive_alone():
    first, second = (
        ring_laps(8, np.pi, 3, 20, 1, np.random.default_rng(seed)).truth for seed in (0, 1)
    )
    between = [a.between(b) for a, b in zip(first, second, strict=True)]
    assert all(abs(b.x) < 1e-9 and abs(b.yaw) < 1e-9 and 0.0 < abs(b.y) < 0.8 for b in between)


def test_one_scan_a_place_is_refused():
    with pytest.raises(UserError, match="--scans-a-place must be >= 2, got 1"):
        check(argparse.Namespace(laps=1, speed=0.5, scans_a_place=1))
