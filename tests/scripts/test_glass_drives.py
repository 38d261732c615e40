"""Glass drives: places by seed, the judge, the figures, and a pane that nothing leads around."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

import evaluate
from experiments import glass_drives_runs
from experiments.glass_drives_runs import ROWS, Outcome, Task, figures, run_task, shortest
from experiments.glass_drives_worlds import Place, place_of
from experiments.glass_paths import crossings
from experiments.glass_truth import pane_lines
from sim_bridge.glass import Glass
from sim_bridge.solids import solids_of
from sim_bridge.world import RobotPlacement, Wall, World


@pytest.mark.parametrize("number", range(4))
def test_a_place_has_a_goal_behind_glass_that_can_be_reached(number: int) -> None:
    place = place_of(7, number)
    start = np.array(place.world.robots[0].position_m)
    solids = solids_of(place.world)
    assert len(crossings(np.array([start, place.goals[0]]), pane_lines(solids))) > 0
    assert math.isfinite(shortest(place)) and shortest(place) > 4.0
    for point in (start, *place.goals):
        assert min(s.signed_distance(np.array([point]))[0] for s in solids) >= 0.94
    assert place.kind == ("office" if number % 2 else "room")


def test_the_default_seed_is_not_one_that_values_were_chosen_on() -> None:
    assert evaluate._parsed(["glass-drives"]).seed == 1
    assert evaluate._parsed(["glass-drives", "--seed", "0"]).seed == 0
    assert evaluate._parsed(["crowd"]).seed == 0


def test_a_number_gives_the_same_place_again_and_another_number_another() -> None:
    assert place_of(3, 2) == place_of(3, 2)
    assert place_of(3, 2).goals != place_of(3, 4).goals != place_of(4, 2).goals


def closed_off() -> Place:
    """Return a room that a pane without posts divides whole: the goal behind it has no way."""
    corners = [(0.0, 0.0), (7.0, 0.0), (7.0, 4.0), (0.0, 4.0)]
    walls = [
        Wall(from_m=a, to_m=b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    pane = Wall(from_m=(4.0, 0.06), to_m=(4.0, 3.94), glass=Glass(scatter_share=0.0))
    robot = RobotPlacement(model="segway_rmp50", position_m=(1.2, 2.6), yaw_deg=0.0)
    world = World(name="closed off", walls=(*walls, pane), robots=(robot,))
    return Place(world, ((5.5, 1.4),), "room")


@pytest.mark.parametrize("row", ["sjmc", "vfh_plus"])
def test_before_a_pane_without_a_way_round_it_the_robot_comes_near_and_never_touches(
    monkeypatch: pytest.MonkeyPatch, row: str
) -> None:
    monkeypatch.setattr(glass_drives_runs, "LIMIT_S", 15.0)
    monkeypatch.setattr(glass_drives_runs, "place_of", lambda seed, number: closed_off())
    outcome = run_task(Task(0, row, 0))
    assert outcome.touched == "" and not outcome.is_reached
    assert outcome.path_m > 0.8 and 0.03 < outcome.min_glass_m < 2.0


def test_a_robot_whose_map_does_not_reach_to_the_goal_looks_round_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A long room; the goal is far behind the robot, where its laser is blind."""
    corners = [(0.0, 0.0), (11.0, 0.0), (11.0, 4.0), (0.0, 4.0)]
    walls = [
        Wall(from_m=a, to_m=b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    robot = RobotPlacement(model="segway_rmp50", position_m=(9.6, 2.0), yaw_deg=0.0)
    world = World(name="long", walls=tuple(walls), robots=(robot,))
    behind = Place(world, ((1.2, 2.0),), "room")
    monkeypatch.setattr(glass_drives_runs, "LIMIT_S", 40.0)
    monkeypatch.setattr(glass_drives_runs, "place_of", lambda seed, number: behind)
    outcome = run_task(Task(0, "sjmc", 0))
    assert outcome.is_reached and outcome.touched == ""


def test_the_judge_ends_a_run_at_a_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot that only drives ahead, whatever it is asked."""
    from sim_bridge.drive import Velocity

    monkeypatch.setattr(glass_drives_runs, "place_of", lambda seed, number: closed_off())
    robot = glass_drives_runs.MappingRobot
    monkeypatch.setattr(robot, "command", lambda self, stamp_ns: Velocity(0.6, 0.0, 0.0))
    monkeypatch.setattr(robot, "take", lambda self, stamp_ns, seen: None)
    outcome = run_task(Task(0, "sjmc", 0))
    assert outcome.touched == "glass" and outcome.num_reached == 0
    assert outcome.track[-1, 0] == pytest.approx(4.0 - 0.2, abs=0.05)


def test_the_figures_of_runs_that_ended_each_way() -> None:
    nothing = np.zeros((0, 2))
    there = Outcome("room", "", True, 2, 30.0, 12.0, 1.2, 0.3, 0.01, ("", ""), nothing, nothing)
    glass = replace(there, touched="glass", is_reached=False, num_reached=1, min_glass_m=-0.01)
    late = replace(there, is_reached=False, num_reached=0, path_ratio=math.nan, pose_error_m=0.1)
    own = figures([there, replace(there, time_s=50.0, path_ratio=1.4), glass, late])
    assert own == {
        "runs": 4, "touched_glass": 1, "touched_things": 0, "reached": 2, "goals_reached": 5,
        "time_s": 40.0, "path_ratio": pytest.approx(1.3), "least_glass_m": 0.0,
        "pose_error_max_m": 0.1,
    }  # fmt: skip
    assert figures([])["time_s"] is None and set(ROWS) >= {"sjmc", "vfh_plus"}
