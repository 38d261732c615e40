"""The crowd experiment: its scenes, and its figures by hand."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from experiments import crowd, crowd_runs
from experiments.crowd_recorded import recorded
from experiments.crowd_runs import Outcome, Task, beside, figures, run_task
from experiments.crowd_scenes import ROBOT, SCENES
from experiments.crowd_words import BESIDE, SHOWN, glossary
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from sim_bridge.robot_model import load_robot
from sim_bridge.simulation import check_world
from sjmc_planner.sjmc import Sjmc

GOOD = Outcome(
    is_success=True, is_reached=True, caused=0, theirs=0, things=0, time_s=20.0, path_ratio=1.1,
    min_distance_m=0.5, not_moving_s=1.0, longest_stop_s=1.0, heading_changes=2, intimate_s=0.0,
    personal_s=3.0, all_yield=True, track=np.zeros((0, 3)), people={},
)  # fmt: skip
BAD = replace(
    GOOD, is_success=False, is_reached=False, caused=2, theirs=1, time_s=60.0, path_ratio=3.0,
    min_distance_m=-0.1, not_moving_s=31.0, longest_stop_s=30.0, heading_changes=6,
)  # fmt: skip


def test_figures_by_hand() -> None:
    found = figures([GOOD, BAD])
    assert found["runs"] == 2
    assert found["success"] == 0.5
    assert found["collisions_caused"] == 2
    assert found["collisions_theirs"] == 1
    assert found["time_s"] == 20.0  # of the one that was there
    assert found["path_ratio"] == pytest.approx(1.1)
    assert found["min_distance_m"] == 0.25  # within somebody is 0
    assert found["time_not_moving_s"] == 16.0
    assert found["heading_changes"] == 4.0
    assert found["long_stops_where_all_yield"] == 1


def test_a_stop_before_somebody_who_never_notices_is_not_held_against_it() -> None:
    found = figures([GOOD, replace(BAD, all_yield=False)])
    assert found["long_stops_where_all_yield"] == 0
    assert found["runs_where_all_yield"] == 1
    assert found["longest_stop_s"] == 30.0


def test_figures_of_nothing_are_none_and_not_absent() -> None:
    assert figures([])["time_s"] is None
    assert figures([BAD])["time_s"] is None


def test_methods_are_held_beside_each_other_on_the_same_runs_and_failing_is_no_gain() -> None:
    """14 s and 20 s of ours beside 20 s and a failure; then our failure, a contact, beside 20 s."""
    ours = {0: replace(GOOD, time_s=14.0, heading_changes=1), 1: GOOD, 2: GOOD}
    theirs = {0: GOOD, 1: BAD, 3: GOOD}
    expected = {"runs": 2, "runs_both": 1, "time": 34.0 / 80.0, "time_both": 0.7,
                "heading_changes": 0.5}  # fmt: skip
    assert beside(ours, theirs) == expected
    touched = replace(GOOD, is_success=False, caused=1, time_s=5.0)
    assert beside({0: touched}, {0: GOOD})["time"] == 3.0
    assert beside({}, theirs)["time"] is None


def test_the_report_says_which_aims_are_met() -> None:
    """No contact, one long stop, 0.65 of VFH+'s time; turns were not held beside anything."""
    own = figures([GOOD, replace(BAD, caused=0)])
    own["beside_vfh_plus"] = {"time": 0.65, "heading_changes": None}
    (table,) = crowd._aims({"corridor": {"methods": {"sjmc": own}}, "eth": {"methods": {}}}).blocks
    assert table.rows == [["corridor", "0: met", "1: not met", "0.65: met", "not measured"]]
    own["runs_where_all_yield"] = 0
    (table,) = crowd._aims({"corridor": {"methods": {"sjmc": own}}}).blocks
    assert table.rows[0][2] == "not measured"


def test_of_a_recording_the_aim_is_the_best_others_contacts_a_run() -> None:
    """2 in 2 runs of ours; others 2 in 1 run and none in 1: a sum would hide how many runs."""
    scene = {"sjmc": figures([GOOD, BAD]), "vfh": figures([BAD]), "orca": figures([GOOD])}
    (table,) = crowd._recorded_aims({"eth": {"methods": scene}}, ["eth"]).blocks
    assert table.rows == [["eth", "1: not met", "0.00 (orca)"]]
    del scene["orca"]
    (table,) = crowd._recorded_aims({"eth": {"methods": scene}}, ["eth"]).blocks
    assert table.rows == [["eth", "1: met", "2.00 (vfh)"]]


def test_every_column_of_the_report_is_explained_and_its_key_is_in_the_summary() -> None:
    (table,) = glossary().blocks
    assert [row[0] for row in table.rows] == [*SHOWN.values(), *BESIDE.values()]
    own = figures([GOOD])
    own["beside_vfh_plus"] = beside({0: GOOD}, {0: GOOD})
    for _, key, meaning in table.rows:
        first, _, second = key.partition(".")
        assert (second in own[first] if second else first in own) and meaning


def test_the_page_names_the_keys_of_the_summary() -> None:
    page = (Path(__file__).parents[2] / "docs" / "compare-planners.md").read_text()
    for key in (*SHOWN, "reached", "runs_where_all_yield"):
        assert f"`{key}`" in page


def test_what_a_picture_shows_is_said_below_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crowd, "draw_scene", lambda *_: None)
    args = argparse.Namespace(out_dir=Path(), methods=["sjmc"], seed=0, fps=25.0)
    (picture,) = crowd._pictures(args, "doorway", "", {Task("doorway", 0, "sjmc", 0): GOOD})
    for words in ("the robot every second (blue)", "orange dots, disks", "the goal (black cross)"):
        assert words in picture.caption


def test_one_row_is_sjmc_told_the_disk_that_the_others_are_told() -> None:
    disk, box = crowd_runs._method("sjmc_disk"), crowd_runs._method("sjmc")
    assert isinstance(disk, Sjmc) and isinstance(box, Sjmc)
    assert (disk._box.half_width, box._box.half_width) == (ROBOT.radius_m, ROBOT.half_width_m)


def test_a_recording_in_which_nobody_is_met_fairly_is_refused(tmp_path: Path) -> None:
    """Somebody who is at the corners of a square of 100 m in turns, far from where a robot goes."""
    rows = [f"{10 * k} 1 {100.0 * (k % 2)} 0 {100.0 * (k // 2 % 2)} 0 0 0" for k in range(40)]
    file = tmp_path / "obsmat.txt"
    file.write_text("\n".join(rows))
    with pytest.raises(UserError, match="no start of"):
        recorded(file, 25.0, 0)


@pytest.mark.parametrize("name", list(SCENES))
def test_scenes_can_be_built_and_follow_from_their_seed(name: str) -> None:
    for seed in range(30):
        scene = SCENES[name](seed)
        check_world(scene.world)
        start = scene.world.robots[0].position_m
        places = [plan.path_m[0] for plan in scene.world.people]
        assert len(places) >= 3
        assert min(math.dist(start, place) for place in places) > ROBOT.radius_m + 0.3
        assert all(math.dist(a, b) > 0.4 for k, a in enumerate(places) for b in places[:k])
        assert scene.all_yield == (not any(plan.never_notices for plan in scene.world.people))
    assert SCENES[name](3) == SCENES[name](3) != SCENES[name](4)


def test_a_drive_is_over_level_with_its_goal() -> None:
    scene = SCENES["corridor"](0)  # from (1, 0) to (12, 0)
    assert scene.is_finished(SE2(11.8, 1.2, 0.3))
    assert scene.is_finished(SE2(13.0, -1.0, 0.0))
    assert not scene.is_finished(SE2(11.5, 0.0, 0.0))
    assert not scene.is_finished(SE2(12.0, 2.0, 0.0))


def test_about_one_in_ten_never_notices() -> None:
    plans = [p for seed in range(100) for p in SCENES["crossing"](seed).world.people]
    share = sum(bool(p.never_notices) for p in plans) / len(plans)
    assert share == pytest.approx(0.1, abs=0.04)


def test_the_robots_disk_holds_its_outline() -> None:
    outline = np.array(load_robot(SCENES["corridor"](0).world.robots[0]).config.footprint_m)
    assert np.hypot(*outline.T).max() <= ROBOT.radius_m
    assert np.allclose(outline.max(axis=0), (ROBOT.front_m, ROBOT.half_width_m))
    assert np.allclose(-outline.min(axis=0), (ROBOT.rear_m, ROBOT.half_width_m))


def test_a_recorded_scene_meets_somebody_who_does_not_appear_from_nowhere(tmp_path: Path) -> None:
    # One person a minute walks 20 m along x = 0, in a place 10 m wide that others bound.
    rows = []
    for person in range(10):
        for k in range(36):
            rows.append((1500 * person + 10 * k, person, 0.3 * (-1) ** person, -10.0 + 0.56 * k))
    for k in range(200):
        rows.append((75 * k, 1000 + k, (-1) ** k * 5.0, -10.0 + 0.1 * k))
    rows.sort()
    file = tmp_path / "obsmat.txt"
    lines = [f"{frame} {number} {x} 0 {y} 0 0 0" for frame, number, x, y in rows]
    file.write_text("\n".join(lines))
    for seed in range(4):
        scene = recorded(file, 25.0, seed)
        assert scene == recorded(file, 25.0, seed)
        assert scene.world.recorded_people is not None
        assert 5.0 < scene.straight_m < 12.0
        start = np.array(scene.world.robots[0].position_m)
        t = np.array(rows)[:, 0] / 25.0 - scene.world.recorded_people.starts_s
        share = np.clip(ROBOT.speed_m_s * t / scene.straight_m, 0.0, 1.0)[:, None]
        off = np.array(rows)[:, 2:] - (start + share * (np.array(scene.goal) - start))
        is_under_way = (t > 2.0) & (t < scene.straight_m / ROBOT.speed_m_s)
        assert np.hypot(*off[is_under_way].T).min() < 1.0


def test_the_same_task_gives_the_same_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crowd_runs, "LIMIT_S", 4.0)
    task = Task("doorway", 0, "vfh_plus", 7)
    one, other = run_task(task), run_task(task)
    assert np.array_equal(one.track, other.track)
    assert figures([one]) == figures([other])
    assert not one.is_reached
    assert 1.0 < float(np.hypot(*(one.track[-1, :2] - one.track[0, :2]))) < 4.0


@pytest.mark.parametrize(
    ("change", "said"),
    [({"people": ["none.txt"]}, "none.txt"), ({"scenes": []}, "no scene")],
)
def test_bad_input_is_named(change: dict[str, object], said: str) -> None:
    parser = argparse.ArgumentParser()
    crowd.add_options(parser)
    args = parser.parse_args([])
    crowd.check(args)
    for name, value in change.items():
        setattr(args, name, value)
    with pytest.raises(UserError, match=said):
        crowd.check(args)
