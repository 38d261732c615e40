"""Obstacles that a map knows beside the scan: corners of cells, near ones, in a scan, hiding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sjmc_scenes import PERIOD, scan_of

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.known_obstacles import hides, merged, near_points, occupied_corners
from sjmc_planner.methods import METHODS, make_method
from sjmc_planner.planning import REACHED, STILL, Goal, Obstacles, RobotState, Velocity
from sjmc_planner.sjmc_scene import SceneReader
from sjmc_planner.tracking_config import TrackingConfig

HERE = SE2(0.0, 0.0, 0.0)
NUM = 360


def open_scan() -> Scan:
    return Scan(np.full(NUM, np.inf), -np.pi, 2.0 * np.pi / NUM, 0.1, 8.0)


def pane(x: float, half: float = 0.6) -> np.ndarray:
    """Return points across the way at x."""
    y = np.arange(-half, half + 1e-9, 0.05)
    return np.column_stack((np.full(len(y), x), y))


def test_two_cells_side_by_side_have_six_corners() -> None:
    cells = np.zeros((3, 4), dtype=np.int8)
    cells[1, 1:3] = 100
    corners = occupied_corners(OccupancyMap(cells, 0.1, SE2(1.0, 2.0, 0.0)), 65)
    assert sorted(map(tuple, corners.round(6).tolist())) == [
        (1.1, 2.1), (1.1, 2.2), (1.2, 2.1), (1.2, 2.2), (1.3, 2.1), (1.3, 2.2),
    ]  # fmt: skip


def test_free_unknown_and_doubtful_cells_are_no_obstacles() -> None:
    cells = np.array([[-1, 0, 64, 65]], dtype=np.int8)
    assert len(occupied_corners(OccupancyMap(cells, 0.1, HERE), 65)) == 4


def test_near_points_are_seen_from_the_robot() -> None:
    points = np.array([[1.0, 3.0], [1.0, 9.0]])
    found = near_points(points, SE2(1.0, 1.0, np.pi / 2.0), 3.0)
    assert found == pytest.approx(np.array([[2.0, 0.0]]))


def test_a_pane_ends_the_beams_that_go_through_it_and_no_others() -> None:
    seen = merged(Obstacles(open_scan(), HERE, known=pane(1.0))).scan
    bearing = np.abs(seen.angles)
    assert seen.ranges[bearing < 0.5] == pytest.approx(1.0 / np.cos(seen.angles[bearing < 0.5]),
                                                       abs=0.03)  # fmt: skip
    assert np.isinf(seen.ranges[bearing > 0.6]).all()


def test_what_stands_before_a_pane_and_what_was_not_looked_at_stay_as_they_were() -> None:
    scan = open_scan()
    scan.ranges[180], scan.ranges[182], scan.ranges[184] = 0.5, np.nan, -np.inf
    seen = merged(Obstacles(scan, HERE, known=pane(1.0))).scan
    assert seen.ranges[180] == 0.5 and np.isnan(seen.ranges[182])
    assert seen.ranges[184] == -np.inf and seen.ranges[186] < 1.1


@given(st.floats(-3.1, 3.1), st.floats(0.3, 3.0), st.floats(-0.3, 0.3), st.floats(-3.1, 3.1))
def test_no_beam_is_ever_lengthened_and_one_at_a_point_ends_there(bearing, r, ahead, yaw) -> None:
    """Wherever the sensor is on the robot."""
    mount = SE2(ahead, 0.0, yaw)
    point = mount @ np.array([[r * np.cos(bearing), r * np.sin(bearing)]])
    seen = merged(Obstacles(open_scan(), mount, known=point)).scan
    assert (seen.ranges <= 8.0).sum() >= 1 and np.nanmin(seen.ranges) == pytest.approx(r)
    hit = seen.angles[np.isfinite(seen.ranges)]
    off = np.abs(np.remainder(hit - bearing + np.pi, 2.0 * np.pi) - np.pi)
    assert off.min() <= 0.5 * open_scan().angle_increment + 1e-9


def test_a_pane_hides_who_is_behind_or_on_it() -> None:
    places = np.array([[2.0, 0.0], [1.05, 0.1], [0.5, 0.0], [2.0, 3.0]])
    found = hides(np.zeros(2), places, pane(1.0), 0.1)
    assert found.tolist() == [True, True, False, False]
    assert not hides(np.zeros(2), places, np.zeros((0, 2)), 0.1).any()


def test_a_laser_spot_on_a_pane_is_a_thing_and_no_person() -> None:
    scenes = SceneReader(TrackingConfig(), 0.5, 0.1, PERIOD)
    bare = SceneReader(TrackingConfig(), 0.5, 0.1, PERIOD)
    state = RobotState(STILL, STILL, HERE)
    for _ in range(10):
        seen = Obstacles(scan_of([(1.2, 0.0, 0.2)]), HERE)
        scene = scenes.read(state, replace(seen, known=pane(1.0)))
        without = bare.read(state, seen)
    assert len(without.people) == 1 and len(scene.people) == 0
    assert len(scene.things) > len(pane(1.0))


def drive_at_a_pane(name: str, known: np.ndarray) -> tuple[float, str]:
    """Drive at a goal behind x = 3 with a scan that shows nothing; return how far it came."""
    robot = RobotConfig(drive="differential", radius_m=0.3, speed_m_s=0.6, accel_m_s2=0.6)
    method = make_method(LocalPlannerConfig(method=name, robot=robot))
    pose, command, farthest, state = HERE, STILL, 0.0, ""
    for _ in range(160):
        goal = (pose.inverse() @ np.array([[5.0, 0.0]]))[0]
        points = pose.inverse() @ known
        moved = SE2(command.x * PERIOD, command.y * PERIOD, command.yaw_rate * PERIOD)
        decision = method.decide(
            RobotState(command, command, moved), Obstacles(open_scan(), HERE, known=points),
            Goal(goal, float(np.hypot(*goal))),
        )  # fmt: skip
        command, state = Velocity(*_limited(command, decision.command)), decision.state
        pose = pose @ SE2(command.x * PERIOD, command.y * PERIOD, command.yaw_rate * PERIOD)
        farthest = max(farthest, pose.x)
        if state == REACHED:
            break
    return farthest, state


def _limited(now: Velocity, wanted: Velocity) -> tuple[float, float, float]:
    step = 0.6 * PERIOD
    return (
        float(np.clip(wanted.x, now.x - step, now.x + step)), 0.0,
        float(np.clip(wanted.yaw_rate, now.yaw_rate - 0.1, now.yaw_rate + 0.1)),
    )  # fmt: skip


@pytest.mark.parametrize("name", sorted(METHODS))
def test_no_method_drives_through_a_pane_that_only_the_map_knows(name: str) -> None:
    known = pane(3.0, half=5.0)
    farthest, _ = drive_at_a_pane(name, known)
    assert 0.5 < farthest < 3.0 - 0.3
    through, state = drive_at_a_pane(name, known[:0])
    assert through > 3.5, state
