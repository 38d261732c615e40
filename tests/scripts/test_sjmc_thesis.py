"""Figures of the SJMC thesis's experiments from drives made by hand."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import pytest

from experiments import sjmc_thesis
from experiments.crowd_scenes import ROBOT
from experiments.sjmc_thesis_drives import (
    CROSSING,
    ONCOMING,
    PUBLISHED,
    SLIM,
    STANDING,
    STATIC,
    Outcome,
    Task,
    _method,
    stepped_aside,
)
from experiments.sjmc_thesis_figures import (
    response_rows,
    stable_rows,
    static_figures,
    straight_rows,
)
from sjmc_planner.sjmc_config import SjmcConfig


def outcome(**changes) -> Outcome:
    values = {
        "is_done": True, "time_s": 10.0, "path_m": 6.0, "is_straight": True, "contacts": 0,
        "by_robot": 0, "min_gap_m": 0.5, "heading_changes": 0, "waited_s": 0.0, "has_moved": True,
        "track": np.zeros((2, 4)), "people": np.zeros((2, 3)), **changes,
    }  # fmt: skip
    return Outcome(**values)


def test_times_against_c_are_means_of_those_that_got_past() -> None:
    done = {
        Task(STATIC, PUBLISHED, k, 0, distance=4.7, response=2.7, danger=2.0): outcome(
            time_s=time, is_done=time < 50.0
        )
        for k, time in enumerate((10.0, 12.0, 60.0))
    }
    done[Task(STATIC, PUBLISHED, 0, 0, distance=4.7, response=2.7, danger=1.9)] = outcome()
    (row,) = response_rows(done, danger=2.0)
    assert (row["c"], row["time_s"], row["runs"]) == (2.7, 11.0, 3)


def test_the_ratio_is_of_mean_times_and_the_peer_is_held_to_its_own() -> None:
    done = {
        Task(STATIC, "sjmc", 0, 0, distance=2.7): outcome(time_s=6.0),
        Task(STATIC, "vfh_plus", 0, 0, distance=2.7): outcome(time_s=8.0, path_m=8.33),
    }
    figures = static_figures(done)["start_2.7_m"]
    assert figures["ratio"] == pytest.approx(0.75)
    assert figures["vfh_plus_allowed_s"] == pytest.approx(1.1 * (8.33 / 0.833 + 1.0))
    assert figures["published_ratio"] is None


def test_straight_is_a_share_and_contacts_are_runs() -> None:
    done = {
        Task(CROSSING, "sjmc", k, 0, distance=1.3): outcome(
            is_straight=k != 0, contacts=2 * (k == 1), min_gap_m=0.1 * k
        )
        for k in range(4)
    }
    (row,) = straight_rows(done)
    assert (row["straight"], row["contacts"], row["runs"]) == (0.75, 1, 4)
    assert row["success"] == 0.5  # one was not straight, one touched
    assert row["clear"] == 0.5 and row["min_gap_m"] == 0.0


def test_who_does_not_yield_is_passed_whatever_the_course() -> None:
    done = {
        Task(STANDING, "sjmc", 0, 0, is_yielding=yields): outcome(is_straight=False)
        for yields in (True, False)
    }
    rows = stable_rows(done, STANDING, "sjmc")
    assert rows["yielding"]["success"] == 0.0 and rows["unyielding"]["success"] == 1.0
    none = stable_rows(done, STANDING, "vfh_plus")["yielding"]
    assert none["success"] is None and none["runs"] == 0


def test_aims_are_judged_by_hand() -> None:
    """From 1.3 m on: one touched and came nearer than 0.2 m; 9 of 10 straight is enough."""
    done = {
        Task(CROSSING, "sjmc", k, 0, distance=distance): outcome(
            is_straight=k != 0, contacts=int(k == 1), min_gap_m=0.0 if k == 1 else 0.3
        )
        for k in range(10)
        for distance in (1.1, 1.3)
    }
    done |= {
        Task(STANDING, "sjmc", k, 0, is_yielding=True): outcome(is_straight=k > 1)
        for k in range(10)
    }
    done |= {Task(ONCOMING, "sjmc", 0, 0, is_yielding=False): outcome(contacts=1)}
    done |= {
        Task(STATIC, "sjmc", 0, 0, distance=2.7): outcome(time_s=12.0),
        Task(STATIC, "vfh_plus", 0, 0, distance=2.7): outcome(time_s=10.0, path_m=0.833 * 8.0),
    }
    values: dict[str, Any] = {}
    sjmc_thesis.fill(values, done)
    found = [(row["found"], row["is_met"]) for row in values["aims"]]
    assert found == [
        ("1 of 10 at 1.3 m (0 by the robot)", False), ("90% at 1.3 m", False),
        ("90% at worst", True),
        ("80%", False), ("0%", False), ("1.20", True), ("1.01 of that", False),
    ]  # fmt: skip


def test_of_what_was_not_driven_no_aim_is_judged() -> None:
    values: dict[str, Any] = {}
    sjmc_thesis.fill(values, {})
    assert values["aims"] == []


def test_the_slim_disk_is_told_to_vfh_plus_alone() -> None:
    slim, whole = _method(SLIM, SjmcConfig()), _method("vfh_plus", SjmcConfig())
    assert type(slim) is type(whole)
    assert slim._method._robot.radius_m == 0.45
    assert whole._method._robot.radius_m == ROBOT.radius_m


T = np.linspace(0.0, 10.0, 101)
DRIVE = np.column_stack((5.0 - 0.8 * T, 0.0 * T, np.full_like(T, np.pi)))  # along -x


def person(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.column_stack((T, x, y))


def test_who_comes_and_goes_straight_on_does_not_step_aside() -> None:
    assert not stepped_aside(person(-5.0 + T, 0.0 * T), T, DRIVE)
    assert not stepped_aside(person(-5.0 + T, 0.02 * T), T, DRIVE)  # sways
    assert not stepped_aside(np.zeros((0, 3)), T, DRIVE)  # nobody


def test_who_makes_room_before_the_robot_is_abreast_steps_aside() -> None:
    """They meet at 10 / 1.8 = 5.6 s (coming), and at 6.25 s (standing)."""
    for x in (-5.0 + T, 0.0 * T):
        assert stepped_aside(person(x, np.clip(T - 4.0, 0.0, 0.5)), T, DRIVE)
        assert stepped_aside(person(x, -np.clip(T - 4.0, 0.0, 0.5)), T, DRIVE)
        assert not stepped_aside(person(x, np.clip(T - 7.0, 0.0, 0.5)), T, DRIVE)


def test_aside_is_across_the_robots_way_wherever_that_leads() -> None:
    turned = np.column_stack((DRIVE[:, 1], -DRIVE[:, 0], np.full_like(T, np.pi / 2.0)))  # along +y
    along = np.clip(T - 3.0, 0.0, 0.5)
    assert not stepped_aside(person(0.0 * T, along), T, turned)
    assert stepped_aside(person(along, 0.0 * T), T, turned)


def test_every_part_has_its_drives_and_each_only_once() -> None:
    args = argparse.Namespace(seed=0, runs=2, quick=False, parts=list(sjmc_thesis.PARTS))
    tasks = sjmc_thesis.tasks_of(args)
    assert len(tasks) == len(set(tasks))
    assert {t.kind for t in tasks} == {"static", "crossing", "standing", "oncoming", "hall"}
    args.parts = ["crossing"]
    crossing = sjmc_thesis.tasks_of(args)
    assert len(crossing) == 2 * 4 * len(sjmc_thesis.DISTANCES)
    assert {t.kind for t in crossing} == {CROSSING}
