"""The judge of free space: truth by hand, and verdicts on ranges made up."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from painted_floors import upright_camera

from experiments.floor_scenes import CUBE_M, Scene, true_ranges, truth_of
from experiments.free_space import Tally, is_missed
from floor_perception.config import TemplateConfig
from floor_perception.polar_template import make_template
from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

COLOR = (0.5, 0.5, 0.5)
CONFIG = TemplateConfig()
TEMPLATE = make_template(upright_camera(), CONFIG)
AHEAD = 90  # the direction straight ahead of 180


def cube(x: float, y: float) -> Solid:
    return Solid("cube", SE2(x, y, 0.0), (CUBE_M,) * 3, 0.0, False, COLOR)


def scene(*solids: Solid, pose: SE2 | None = None) -> Scene:
    black = np.zeros((220, 256, 3), dtype=np.uint8)
    return Scene(SE2.identity() if pose is None else pose, solids, black, None, black)


def test_the_truth_is_the_nearest_face_in_the_sector() -> None:
    ranges = true_ranges(scene(cube(1.0, 0.0), cube(2.0, 0.0)), 180)
    assert ranges[AHEAD] == pytest.approx(1.0 - CUBE_M / 2)
    assert np.isinf(ranges[0])
    half = math.atan2(CUBE_M / 2, 1.0 - CUBE_M / 2)
    hit = np.isfinite(ranges).sum() * math.radians(2.0)
    assert 2 * half <= hit <= 2 * half + 2 * math.radians(2.0)


def test_a_round_thing_and_a_turned_robot() -> None:
    pillar = Solid("r1", SE2(0.0, 1.0, 0.0), (0.17, 0.17, 0.2), 0.0, True, COLOR)
    ranges = true_ranges(scene(pillar, pose=SE2(0.0, 0.0, math.pi / 2)), 180)
    assert ranges[AHEAD] == pytest.approx(1.0 - 0.085)


def test_a_cube_behind_another_is_not_to_be_seen() -> None:
    views = truth_of(scene(cube(0.5, 0.0), cube(0.9, 0.0)), {180}).cubes
    assert [view.near for view in views] == pytest.approx([0.5 - CUBE_M / 2])


def test_a_cube_is_missed_when_all_its_middle_says_free() -> None:
    (view,) = truth_of(scene(cube(0.6, 0.0)), {180}).cubes
    ranges = np.full(180, np.inf)
    assert is_missed(view, ranges, TEMPLATE)
    ranges[AHEAD] = 0.5
    assert not is_missed(view, ranges, TEMPLATE)
    ranges[AHEAD] = np.nan
    assert is_missed(view, ranges, TEMPLATE)


def test_no_floor_anywhere_is_phantoms_and_a_floor_without_end_misses_all() -> None:
    truth = truth_of(scene(cube(0.6, 0.0)), {180})
    blind, blithe = Tally(CONFIG, TEMPLATE), Tally(CONFIG, TEMPLATE)
    blind.add(truth, np.zeros((220, 256), dtype=np.uint8))
    blithe.add(truth, np.full((220, 256), 255, dtype=np.uint8))
    assert blind.summary()["phantom_share"] == 1.0
    assert blind.summary()["missed_within_1m"] == 0
    assert blithe.summary()["phantom_share"] == 0.0
    assert blithe.summary()["missed_within_1m"] == blithe.summary()["cubes_within_1m"] == 1
