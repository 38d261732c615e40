"""The parts of a demo with goals that need no graph: goals, latency, load, shares, settings."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="no ROS: the demo talks over DDS")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from _day_goals import GoalSender
from _day_heard import due_stamps, error_rows, inputs_handled, pose_errors
from _day_latency import Latencies, StampClock, share_answered
from _day_load import LoadMeter, cpu_seconds, resident_mb
from _day_nodes import changed, node_names, write_settings
from _day_pictures import nearest_person
from _day_report import last_lines
from _day_robot import OURS, USUAL, pilot_of
from _demo_glass import glass_recall
from _field_run import field_lines
from experiments.goal_record import GoalRecord
from floornav_common.config_files import load_config
from floornav_common.grid import OccupancyMap
from floornav_common.se2 import SE2
from sim_bridge.glass import Glass
from sim_bridge.robot_model import load_robot
from sim_bridge.solids import Solid
from sim_bridge.world import load_world, world_names
from sjmc_planner.config import LocalPlannerConfig

S = 1_000_000_000
GOALS = np.array([[1.0, 0.0], [2.0, 0.0]])


def sender(limit_s: float = 60.0) -> tuple[GoalSender, list[float], GoalRecord]:
    sent: list[float] = []
    record = GoalRecord(num_goals=2)
    return GoalSender(GOALS, limit_s, lambda p: sent.append(float(p[0])), record), sent, record


def test_goals_are_sent_one_after_the_other_as_they_are_reached() -> None:
    goals, sent, record = sender()
    goals.look(S)
    for k in range(2):
        goals.has_way()
        goals.take_state("driving", "", (2 + 10 * k) * S)
        goals.take_state("reached", "", (5 + 10 * k) * S)
    assert sent == [1.0, 2.0] and goals.is_done and goals.num_with_way == 2
    assert record.reached_ns == [5 * S, 15 * S] and record.given_up == []


def test_what_the_planner_said_of_the_last_goal_does_not_count_for_the_next() -> None:
    goals, sent, record = sender()
    goals.look(S)
    goals.has_way()
    goals.take_state("driving", "", 2 * S)
    goals.take_state("reached", "", 3 * S)
    goals.take_state("reached", "", 3 * S + 1)
    assert record.reached_ns == [3 * S] and goals.number == 1


def test_a_goal_without_a_way_is_sent_again_and_one_not_reached_in_time_is_left() -> None:
    goals, sent, record = sender(limit_s=10.0)
    for second in range(1, 13):
        goals.look(second * S)
    assert record.given_up == [0] and goals.number == 1
    assert sent.count(1.0) == 4 and sent[-1] == 2.0


def test_latency_is_real_time_since_the_stamped_instant_however_fast_time_runs() -> None:
    clock = StampClock()
    for k in range(5):
        clock.tick(k * 20_000_000, 100.0 + 0.1 * k)  # a fifth of real time
    latencies = Latencies(clock)
    latencies.note("pose", 30_000_000, 100.25)
    latencies.note("pose", 40_000_000, 100.25)
    latencies.note("cmd_vel", None, 100.3)
    latencies.note("late", 10**12, 100.3)  # of an instant that nobody has heard of yet
    found = latencies.figures()
    assert found["pose"] == {
        "messages": 2,
        "p50_ms": pytest.approx(75.0),
        "p99_ms": pytest.approx(99.5),
    }
    assert found["cmd_vel"]["p50_ms"] is None and found["late"]["p50_ms"] is None


def test_an_older_clock_message_changes_nothing() -> None:
    clock = StampClock()
    clock.tick(20, 1.0)
    clock.tick(10, 2.0)
    assert clock.newest_ns == 20 and clock.wall_of(20) == 1.0 and clock.wall_of(10) is None


def test_the_share_answered_counts_inputs_whose_stamp_an_output_bears() -> None:
    assert share_answered({1, 2, 9}, {1, 2, 3, 4}) == 0.5
    assert share_answered({1}, set()) is None


def test_stamps_due_are_multiples_of_the_period() -> None:
    assert due_stamps(0.1, 0, 350_000_000) == {100_000_000, 200_000_000, 300_000_000}
    assert due_stamps(0.1, 150_000_000, 250_000_000) == {200_000_000}


def test_shares_of_the_nodes_by_what_they_answer() -> None:
    stamps = {
        "pose": {1, 2, 3}, "floor/free_space": {1}, "bearings/robots": {1, 2},
        "stereo/front/disparity": {1, 2}, "stereo_pose/candidates": {2},
    }  # fmt: skip
    due = {"scan": {1, 2, 3, 4}, "omni": {1, 2}, "front": {1, 2, 3, 4}}
    assert inputs_handled(stamps, due, 0.5) == {
        "grid_mapper": 0.75, "wavefront_planner": 0.5, "floor_detector": 0.5,
        "marker_detector": 1.0, "stereo_matcher": 0.5, "stereo_localizer": 0.5,
    }  # fmt: skip


def test_pose_errors_are_against_the_truth_between_its_stamps() -> None:
    truth = [(0, SE2(0.0, 0.0, 0.0)), (10, SE2(1.0, 0.0, 0.2))]
    track = [(5, SE2(0.5, 0.3, 0.1)), (10, SE2(1.0, 0.4, 0.2)), (20, SE2(9.0, 9.0, 0.0))]
    assert error_rows(track, truth)[:, 1] == pytest.approx([0.3, 0.4])
    found = pose_errors(track, truth)
    assert found["poses"] == 2 and found["mean"] == pytest.approx(0.35)
    assert found["max"] == pytest.approx(0.4) and found["rms_deg"] == pytest.approx(0.0, abs=1e-9)
    assert pose_errors([], truth) == {
        "poses": 0,
        "mean": None,
        "rms": None,
        "max": None,
        "rms_deg": None,
    }


def test_load_is_read_from_the_texts_of_proc() -> None:
    ticks = os.sysconf("SC_CLK_TCK")
    stat = f"7 (a) b) S {' '.join(['0'] * 10)} {3 * ticks} {ticks} 0 0"
    assert cpu_seconds(stat) == pytest.approx(4.0)
    assert resident_mb("Name: x\nVmRSS:\t 2048 kB\n") == pytest.approx(2.0)
    assert resident_mb("Name: gone\n") == 0.0
    with pytest.raises(ValueError, match="times of a process"):
        cpu_seconds("7 (a) S")


def test_the_meter_counts_from_its_first_look_and_keeps_what_is_gone() -> None:
    meter = LoadMeter()
    meter.look({"self": os.getpid()})
    assert meter.loads["self"].cpu_s == 0.0 and meter.loads["self"].rss_mb > 10.0
    sum(k * k for k in range(2_000_000))
    meter.look({"self": os.getpid(), "gone": 2**22 + 1})
    assert meter.loads["self"].cpu_s > 0.0 and "gone" not in meter.loads


def test_glass_beside_the_way_counts_and_far_glass_does_not() -> None:
    panes = [
        Solid("pane", SE2(x, 1.0, 0.0), (1.0, 0.01, 2.0), 0.0, False, (1.0,) * 3, glass=Glass())
        for x in (0.5, 9.0)
    ]
    cells = np.zeros((40, 40), np.int8)
    cells[20, :10] = 100  # y from 1.0 m, x to 0.5 m: half of the near pane
    grid = OccupancyMap(cells, 0.05, SE2(0.0, 0.0, 0.0))
    way = np.column_stack((np.linspace(0.0, 1.0, 11), np.zeros(11)))
    found = glass_recall(grid, SE2(0.0, 0.0, 0.0), panes, way)
    assert found == pytest.approx(0.5, abs=0.15)
    assert glass_recall(grid, SE2(0.0, 0.0, 0.0), [], way) is None


def test_the_nearest_person_is_measured_from_the_outline_to_the_body() -> None:
    record = GoalRecord(truth=[(0, SE2(0.0, 0.0, 0.0)), (S, SE2(1.0, 0.0, 0.0))])
    record.people = [(0, np.array([[2.0, 0.0], [0.0, 5.0]])), (S, np.zeros((0, 2)))]
    outline = np.array([[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]])
    times, gaps = nearest_person(record, outline, 0.2)
    assert times.tolist() == [0.0, 1.0] and gaps[0] == pytest.approx(1.5) and np.isinf(gaps[1])


def test_settings_say_what_differs_and_read_back_as_the_same(tmp_path: Path) -> None:
    world = load_world("flat_day")
    model = load_robot(world.robots[0])
    path = write_settings(tmp_path, world, model)
    told = yaml.safe_load(path.read_text())
    assert [key.removeprefix("/**/") for key in told] == node_names_told(model)
    planner = told["/**/local_planner"]["ros__parameters"]
    assert planner["method"] == OURS and "omni" not in planner
    read = load_config(path, LocalPlannerConfig, node="local_planner")
    assert read == pilot_of(world, model, OURS).planner
    assert "*" not in (tmp_path / "nodes.yaml").read_text().replace("/**/", "")  # no YAML aliases
    assert (tmp_path / "omni_camera.yaml").exists()


def node_names_told(model: object) -> list[str]:
    first = ["grid_mapper", "wavefront_planner", "local_planner"]
    return [*first, *(name for name in node_names(model) if name not in first)]


def test_both_pilots_know_the_same_robot_and_only_ours_hears_glass() -> None:
    world = load_world("flat_day")
    model = load_robot(world.robots[0])
    ours, usual = pilot_of(world, model, OURS), pilot_of(world, model, USUAL)
    assert ours.has_glass and not usual.has_glass
    assert ours.wavefront == usual.wavefront and ours.mapper == usual.mapper
    assert ours.planner.robot.speed_m_s == usual.planner.robot.speed_m_s
    assert changed(usual.planner)["method"] == USUAL


def test_every_short_name_is_of_a_world() -> None:
    import demo

    assert set(demo._SHORT.values()) <= set(world_names()) and "flat_day" in world_names()


def test_the_last_lines_say_what_both_robots_did() -> None:
    run = {
        "reached": 3, "goals": 4, "time_s": 63.2, "glass_touched": 0, "collisions": 1,
        "stops_over_5s": 2, "glass_recall": 0.925,
    }  # fmt: skip
    usual = {**run, "glass_recall": None, "reached": 1}
    poses = {"grid_mapper": {"poses": 9, "rms": 0.0123}, "stereo_localizer": {"poses": 0}}
    shares = {"grid_mapper": 1.0, "stereo_localizer": 0.5, "floor_detector": None}
    values = {
        **run,
        "baseline": usual,
        "pose_error_m": poses,
        "rtf": 0.987,
        "inputs_handled": shares,
    }
    first, second, third, last = last_lines(values)
    assert first.startswith("floornav:     3 of 4 goals in 63 s, glass touched 0, collisions 1")
    assert first.endswith("glass in the map 92%") and second.endswith("glass in the map –")
    assert third == "pose errors (rms): grid_mapper 0.012 m"
    assert last.startswith("0.99 times real time") and "50.0% of its inputs (stereo_loc" in last
    assert len(last_lines({**values, "baseline": None})) == 3


def test_the_field_says_each_robots_errors_or_that_it_has_none() -> None:
    errors = {"alone": {"poses": 5, "rms_m": 0.03}, "team": {"poses": 0, "rms_m": None}}
    nothing = {"alone": {"poses": 0, "rms_m": None}}
    lines = field_lines({"pose_error_m": {"r1": errors, "r2": nothing}})
    assert lines == ["r1: pose error (rms) alone 0.030 m", "r2: pose error (rms) unknown: no pose"]
    assert field_lines({"pose_error_m": None}) == []
