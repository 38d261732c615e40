import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from map_bag_runs import (
    NUM_ROOM_BEAMS,
    RESULT_FILES,
    room_bag,
    room_ranges,
    run,
    summary_of,
)
from recording_builders import (
    NS,
    START_NS,
    data_file,
    drive,
    scan_message,
    write_bag,
)

from floornav_common.grid import OccupancyMap
from floornav_common.reporting import UserError
from floornav_common.se2 import SE2
from grid_mapper.map_bag import main
from grid_mapper.map_files import load_map
from grid_mapper.map_pictures import _bounds, draw_map
from grid_mapper.map_results import SUMMARY_KEYS
from grid_mapper.trajectory_metrics import format_tum, load_tum


def test_a_room_becomes_a_map_and_a_trajectory(tmp_path, capsys):
    out = tmp_path / "out"
    assert run(room_bag(tmp_path / "room"), "--out", out) == 0
    assert {f.name for f in out.iterdir()} == RESULT_FILES
    summary = summary_of(out)
    assert set(SUMMARY_KEYS) <= set(summary)
    assert (summary["scans"], summary["scans_used"], summary["ok"]) == (20, 20, True)
    assert summary["path_m"] == pytest.approx(0.95, abs=0.02)
    assert summary["relations_trans_m"] is None and summary["ate_m"] is None
    last = load_tum(out / "trajectory.tum")[-1][1]
    assert last.x == pytest.approx(0.95, abs=0.01) and last.y == pytest.approx(0.0, abs=0.01)
    assert "scans: 20, used 20" in capsys.readouterr().out


def test_same_input_same_bytes(tmp_path):
    bag = room_bag(tmp_path / "room")
    for name in ("a", "b"):
        assert run(bag, "--out", tmp_path / name, "--quiet") == 0
    for name in ("map.pgm", "map.yaml", "map.png", "trajectory.tum"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_relations_and_ground_truth_are_measured(tmp_path, capsys):
    start, end = START_NS // NS, START_NS / NS + 1.0
    relations = tmp_path / "relations"
    relations.write_text(f"{start}.0 {end} 0.5 0 0 0 0 0\n7.0 8.0 1 0 0 0 0 0\n")
    truth = tmp_path / "truth.tum"
    poses = [(START_NS + i * NS // 10, SE2(3.0, 0.05 * i, np.pi / 2)) for i in range(20)]
    truth.write_text(format_tum(poses))
    out = tmp_path / "out"
    bag = room_bag(tmp_path / "room")
    assert run(bag, "--relations", relations, "--gt", truth, "--out", out) == 0
    summary = summary_of(out)
    assert (summary["relations_used"], summary["relations_total"]) == (1, 2)
    assert summary["relations_trans_m"] < 0.01 and summary["relations_rot_deg"] < 0.5
    assert summary["relations_trans_std_m"] == 0.0 and len(summary["relations_worst"]) == 1
    assert summary["ate_m"] < 0.01 and summary["rpe_m"] < 0.01 and summary["gt_poses"] == 20
    assert summary["relations_published"] is None
    text, page = capsys.readouterr().out, (out / "report.html").read_text()
    assert "relations: 1 of 2 matched" in text and "published" not in text + page
    assert "Against known relations" in page


def test_relations_and_ground_truth_of_another_time_are_errors(tmp_path, capsys):
    relations, truth = tmp_path / "relations", tmp_path / "truth.tum"
    relations.write_text("7.0 8.0 1 0 0 0 0 0\n")
    truth.write_text(format_tum([(i * NS, SE2(0.0, 0.0, 0.0)) for i in range(5)]))
    bag, out = room_bag(tmp_path / "room"), tmp_path / "out"
    assert run(bag, "--relations", relations, "--gt", truth, "--out", out) == 1
    error, summary = capsys.readouterr().err, summary_of(out)
    assert "relations: none of 1 matched: they are of 7.000 to 8.000 s" in error
    assert "; ground truth: " in error and "marked partial" not in error
    assert (summary["ok"], summary["partial"], summary["relations_used"]) == (False, False, 0)
    assert {f.name for f in out.iterdir()} == RESULT_FILES


@pytest.mark.parametrize("shape", [(1, 400), (400, 1), (50, 50)])
def test_the_picture_is_wide_enough_for_its_legend_whatever_the_map(shape):
    occupancy = OccupancyMap(np.zeros(shape, np.int8), 0.05, SE2(0.0, 0.0, 0.0))
    left, bottom, right, top = _bounds(occupancy, [])
    assert 0.3 - 1e-9 <= (top - bottom) / (right - left) <= 1.6 + 1e-9
    png = draw_map(occupancy, [(0, SE2(0.0, 0.0, 0.0))], "folder/name")
    assert int.from_bytes(png[16:20], "big") == 1500


@pytest.mark.parametrize("called", ["scripts/map_bag.py", "/usr/lib/grid_mapper/map_bag"])
def test_help_names_the_command_as_it_was_called(monkeypatch, capsys, called):
    monkeypatch.setattr(sys, "argv", [called])
    with pytest.raises(SystemExit):
        main(["--help"])
    name, text = called.rpartition("/")[2], capsys.readouterr().out
    assert f"usage: {name} [" in text and f"`{name} BAG_OR_LOG" in text


def test_max_scans_and_a_folder_that_exists(tmp_path, capsys):
    bag = room_bag(tmp_path / "room")
    for _ in range(2):
        assert run(bag, "--max-scans", 3, "--out", tmp_path / "out") == 0
    assert summary_of(tmp_path / "out-2")["scans_used"] == 3
    assert "out-2" in capsys.readouterr().err


def test_config_is_read_and_unknown_keys_are_refused(tmp_path):
    bag = room_bag(tmp_path / "room")
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text("resolution_m: 0.1\nlabel.noise_points: 2\nbase_frame: base_link\n")
    bad.write_text("grid_mapper:\n  ros__parameters:\n    label:\n      noise_point: 2\n")
    assert run(bag, "--config", good, "--out", tmp_path / "out", "--quiet") == 0
    assert "resolution: 0.1" in (tmp_path / "out" / "map.yaml").read_text()
    with pytest.raises(UserError, match="label.noise_points"):
        main([str(bag), "--config", str(bad), "--out", str(tmp_path / "bad")])
    assert not (tmp_path / "bad").exists()


@pytest.mark.parametrize(
    ("args", "expected"),
    [(["missing"], "does not exist"), (["bag"], "--laser-pose"),
     (["bag", "--scan-topic", "/left"], "/left"), 
     (["room", "--relations", "missing"], "--relations missing: No such file"),
     (["room", "--relations", "room"], "--relations room is a folder: name a file"),
     (["room", "--relations-tol", "0.1"], "--relations-tol is of the relations in --relations"),
     (["room", "--relations-offset", "0"], "--relations-offset is of the relations"),
     (["room", "--gt", "missing"], "--gt missing: No such file"),
     (["room", "--gt", "room"], "--gt room is a folder"),
     (["room", "--config", "missing"], "missing"),
     (["room", "--laser-pose", "0", "0", "180"], "radians")],
)  # fmt: skip
def test_bad_input_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, capsys, args, expected):
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "bag", drive(2, has_static=False))
    room_bag(tmp_path / "room", 2)
    assert run(*args, "--out", "out") == 2
    error = capsys.readouterr().err
    assert expected in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_out_that_is_a_file_is_refused_and_stays(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "README.md").write_text("mine")
    assert run(room_bag(tmp_path / "room", 2), "--out", "README.md") == 2
    assert "--out README.md is a file: name a folder" in capsys.readouterr().err
    assert {f.name for f in tmp_path.iterdir()} == {"README.md", "room"}


def test_laser_pose_and_no_odom_make_a_bare_bag_usable(tmp_path):
    bag = write_bag(
        tmp_path / "bare",
        [("/scan", i, scan_message(START_NS + i * NS, room_ranges(0.0))) for i in range(3)],
    )
    assert run(bag, "--no-odom", "--out", tmp_path / "a") == 2
    options = ["--laser-pose", "0.1", "0", "0", "--no-odom", "--out"]
    assert run(bag, *options, tmp_path / "a", "--quiet") == 0
    assert summary_of(tmp_path / "a")["scans_used"] == 3


def test_scans_without_a_point_leave_a_trajectory_and_say_so(tmp_path, capsys):
    nothing = [np.inf] * NUM_ROOM_BEAMS
    bag = write_bag(
        tmp_path / "dark", [("/scan", i, scan_message(START_NS + i, nothing)) for i in range(3)]
    )
    options = ["--laser-pose", "0", "0", "0", "--no-odom", "--out"]
    assert run(bag, *options, tmp_path / "out") == 1
    assert "no scan had enough points" in capsys.readouterr().err
    assert summary_of(tmp_path / "out")["scans_untrusted"] == 3
    assert len(load_tum(tmp_path / "out" / "trajectory.tum")) == 3


def test_list_shows_topics_and_maps_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(room_bag(tmp_path / "room"), "--list") == 0
    text = capsys.readouterr().out
    assert "* /scan" in text and "sensor_msgs/msg/LaserScan" in text and "Hz" in text
    assert not (tmp_path / "out").exists()


def test_a_cut_off_bag_gives_partial_results_and_exit_1(tmp_path, capsys):
    bag = room_bag(tmp_path / "room", 300, "sqlite3")
    file = bag / "room.db3"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert run(bag, "--out", tmp_path / "out", "--quiet") == 1
    summary = summary_of(tmp_path / "out")
    assert (summary["ok"], summary["partial"]) == (False, True)
    assert 10 < summary["scans_used"] < 300
    assert "cut off" in summary["problem"]
    assert {f.name for f in (tmp_path / "out").iterdir()} == RESULT_FILES


def test_ctrl_c_leaves_the_results_so_far_marked_partial(tmp_path):
    bag = room_bag(tmp_path / "room", 3000)
    code = "import sys; from grid_mapper.map_bag import run; sys.argv[0] = 'map_bag'; run()"
    command = [sys.executable, "-c", code, str(bag), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"}
    )
    assert process.stdout is not None
    while "mapping" not in process.stdout.readline():
        assert process.poll() is None
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 1
    summary = summary_of(tmp_path / "out")
    assert (summary["ok"], summary["partial"]) == (False, True)
    assert 0 < summary["scans_used"] < 3000
    assert (tmp_path / "out" / "map.png").exists()


def test_the_intel_lab_comes_out_far_better_than_its_odometry(tmp_path, capsys):
    log = data_file("intel-lab/intel_keyframes_rawodom_corrected.log.gz")
    relations = data_file("intel-lab/intel.relations.gz")
    words = ("--relations", relations, "--max-scans", "200", "--out", tmp_path / "out")
    assert run(log, *words) == 0
    summary = summary_of(tmp_path / "out")
    assert (summary["relations_used"], summary["scans_used"]) == (13, 200)
    assert summary["relations_trans_m"] < 0.1  # raw odometry: 0.765 m
    assert summary["loops"] > 20 and summary["nodes"] <= 200
    assert [r["trans_m"] for r in summary["relations_published"]] == [0.220, 0.070, 0.031]
    text, page = capsys.readouterr().out, (tmp_path / "out" / "report.html").read_text()
    assert "graph mapping 0.031 +- 0.026" in text
    for words in (text, page):
        assert "published over all 2984 relations, ours over the 13 matched ones" in words


def test_without_closing_loops_nothing_is_said_of_them(tmp_path, capsys):
    bag, config = room_bag(tmp_path / "room"), tmp_path / "config.yaml"
    config.write_text("loop_closing: false\n")
    assert run(bag, "--config", config, "--out", tmp_path / "out") == 0
    summary = summary_of(tmp_path / "out")
    assert summary["loops"] is None and summary["loops_refused"] is None
    assert "loops closed" not in capsys.readouterr().out


def test_without_the_solver_nothing_is_mapped_and_the_cure_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "gtsam", None)
    bag = room_bag(tmp_path / "room")
    with pytest.raises(UserError, match="gtsam"):
        main([str(bag), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_a_pane_that_only_a_sonar_hears_is_in_the_map_and_in_layers_of_its_own(tmp_path, capsys):
    bag = room_bag(tmp_path / "room", 30, sonar=0.6)
    config, out = tmp_path / "config.yaml", tmp_path / "out"
    config.write_text("keepout_margin_m: 0.2\n")
    assert run(bag, "--sonar-topic", "/sonar", "--config", config, "--out", out) == 0
    layers = {"map_glass.yaml", "map_glass.pgm", "map_keepout.yaml", "map_keepout.pgm"}
    assert {f.name for f in out.iterdir()} == RESULT_FILES | layers
    summary = summary_of(out)
    assert summary["ranges"] == 30 and summary["ranges_placed"] >= 29
    assert summary["ranges_unplaced"] == 30 - summary["ranges_placed"]
    glass = load_map(out / "map_glass.yaml")
    points = glass.to_points(np.argwhere(glass.cells == 100))
    assert summary["glass_cells"] == len(points) > 20
    assert np.abs(points[:, 1] - 0.6).max() < 0.15
    occupancy = load_map(out / "map.yaml")
    assert occupancy.cells[tuple(occupancy.to_cells(np.array([[0.7, 0.6]]))[0])] == 100
    assert "cells of glass" in capsys.readouterr().out
    assert run(bag, "--out", tmp_path / "laser", "--quiet") == 0
    assert {f.name for f in (tmp_path / "laser").iterdir()} == RESULT_FILES
    assert summary_of(tmp_path / "laser")["glass_cells"] is None
