"""What SJMC knows of its surroundings: people apart from things, and what went out of view."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sjmc_scenes import PERIOD, scan_of

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.planning import STILL, Obstacles, RobotState
from sjmc_planner.sjmc_scene import Scene, SceneReader
from sjmc_planner.tracking_config import TrackingConfig

HERE = SE2.identity()


def reader() -> SceneReader:
    return SceneReader(TrackingConfig(), person_width=0.5, unseen_gap=0.1, period=PERIOD)


def seen(scenes: SceneReader, disks, moved: SE2 = HERE, num: int = 10) -> Scene:
    for _ in range(num):
        scene = scenes.read(RobotState(STILL, STILL, moved), Obstacles(scan_of(disks), HERE))
    return scene


def test_who_is_narrow_is_a_person_and_what_is_wide_is_a_thing() -> None:
    scene = seen(reader(), [(2.0, 1.0, 0.2), (2.5, -1.0, 0.45)])
    assert len(scene.people) == 1 and not scene.is_moving[0]
    assert scene.people[0, :2] == pytest.approx([2.0, 1.0], abs=0.06)
    assert len(scene.things) > 0 and (scene.things[:, 1] < 0.0).all()


def test_who_stands_is_solid_but_no_thing() -> None:
    scene = seen(reader(), [(2.0, 1.0, 0.2)])
    assert len(scene.things) == 0 and len(scene.solids) > 3
    assert np.abs(np.hypot(*(scene.solids - [2.0, 1.0]).T) - 0.2).max() < 0.02


def test_a_scan_that_comes_twice_says_the_same_twice() -> None:
    scenes, disks = reader(), [(2.0, 1.0, 0.2), (2.5, -1.0, 0.45)]
    first = seen(scenes, disks)
    scan = Obstacles(scan_of(disks), HERE)
    state = RobotState(STILL, STILL, HERE)
    first, again = scenes.read(state, scan), scenes.read(state, replace(scan))
    assert len(again.people) == len(first.people) == 1
    assert again.things == pytest.approx(first.things)


def test_what_was_wide_is_no_person_because_its_side_is_hidden() -> None:
    scenes = reader()
    seen(scenes, [(2.5, 0.0, 0.45)])
    scene = seen(scenes, [(2.5, 0.0, 0.45), (1.2, 0.25, 0.12)], num=4)
    assert not any(np.hypot(*(row[:2] - [2.5, 0.0])) < 0.3 for row in scene.people)


def test_what_goes_out_of_view_beside_the_robot_is_kept_and_moved_along() -> None:
    """A post from abreast to 0.9 m behind: the laser does not look back, the scene knows it yet."""
    scenes, step = reader(), SE2(0.05, 0.0, 0.0)
    for k in range(19):
        scan = Obstacles(scan_of([(-0.05 * k, 0.6, 0.3)]), HERE)
        scene = scenes.read(RobotState(STILL, STILL, step if k else HERE), scan)
    bearings = np.arctan2(scene.solids[:, 1], scene.solids[:, 0])
    kept = scene.solids[np.abs(bearings) > np.radians(136.0)]
    assert len(kept) > 3
    assert np.abs(np.hypot(*(kept - [-0.9, 0.6]).T) - 0.3).max() < 0.02
    for _ in range(80):
        scene = scenes.read(RobotState(STILL, STILL, HERE), Obstacles(scan_of([]), HERE))
    assert len(scene.solids) == 0


def test_a_mirrored_scan_has_the_mirrored_things() -> None:
    disks = [(2.5, -1.0, 0.45), (1.5, 2.0, 0.4), (3.0, 0.5, 0.6)]
    left = seen(reader(), disks).things
    right = seen(reader(), [(x, -y, r) for x, y, r in disks]).things * [1.0, -1.0]
    order = np.lexsort(np.round(left, 4).T), np.lexsort(np.round(right, 4).T)
    assert left[order[0]] == pytest.approx(right[order[1]], abs=1e-9)


def camera_scan(wall: float) -> Scan:
    """A full turn that measures from 0.17 m on, beside a wall `wall` m to the left."""
    angles = np.radians(np.arange(-180.0, 180.0, 2.0))
    across = np.sin(angles)
    ranges = np.where(across > 0.2, wall / np.maximum(across, 0.2), np.inf)
    ranges[ranges < 0.17] = -np.inf
    return Scan(
        ranges=ranges, angle_min=float(angles[0]), angle_increment=np.radians(2.0),
        range_min=0.17, range_max=2.5,
    )  # fmt: skip


def test_what_comes_nearer_than_the_sensor_measures_does_not_recede() -> None:
    """Sidling up to a wall, 0.26 to 0.11 m: its beams end in -inf, the scene knows how near."""
    scenes, step = reader(), 0.005
    for k in range(31):
        scan = Obstacles(camera_scan(0.26 - step * k), HERE)
        moved = SE2(0.0, step if k else 0.0, 0.0)
        scene = scenes.read(RobotState(STILL, STILL, moved), scan)
    for nearest in (scene.things, scene.solids):
        assert np.hypot(*nearest.T).min() == pytest.approx(0.11, abs=0.01)
    for _ in range(round(10.0 / PERIOD)):  # it stands: what stands beside it does not go away
        scene = scenes.read(RobotState(STILL, STILL, HERE), scan)
    assert np.hypot(*scene.solids.T).min() == pytest.approx(0.11, abs=0.01)
    gone = Obstacles(camera_scan(0.4), HERE)  # a beam that sees farther forgets
    scene = scenes.read(RobotState(STILL, STILL, HERE), gone)
    assert np.hypot(*scene.solids.T).min() == pytest.approx(0.4, abs=0.01)
