"""scripts/demo.py as a user starts it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS: the demo talks over DDS")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")
pytest.importorskip("grid_mapper.nodes.grid_mapper_node", reason="no grid_mapper node")

ROOT = Path(__file__).resolve().parents[2]
TIMEOUT_S = 300.0
KEYS = (
    "command", "version", "seed", "machine", "python", "packages", "wall_s", "ok", "world",
    "sim_s", "rtf", "path_m", "scans", "scans_used", "ate_m", "final_error_m",
    "odometry_final_error_m", "map_error_m", "map_found_share", "touched", "bag",
)  # fmt: skip

DAY_KEYS = (
    "world", "goals", "reached", "collisions", "glass_touched", "stops_over_5s", "glass_recall",
    "pose_error_m", "inputs_handled", "rtf", "baseline", "latency_ms", "load", "bag",
)  # fmt: skip
NODES = (
    "grid_mapper", "wavefront_planner", "floor_detector", "marker_detector", "stereo_matcher",
    "stereo_localizer",
)  # fmt: skip


def _start(*words: str) -> subprocess.Popen[str]:
    environ = {**os.environ, "FLOORNAV_ENV_READY": "1"}
    environ.pop("ROS_DOMAIN_ID", None)
    command = [sys.executable, str(ROOT / "scripts" / "demo.py"), "--headless", *words]
    return subprocess.Popen(
        command, env=environ, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def _run(*words: str) -> tuple[int, str]:
    process = _start(*words)
    text, _ = process.communicate(timeout=TIMEOUT_S)
    return process.returncode, text


def test_a_short_run_leaves_all_its_results(tmp_path: Path) -> None:
    words = ("furnished_floor", "--duration", "10", "--seed", "3", "--out", str(tmp_path / "out"))
    code, text = _run(*words, "--live")
    assert code == 0, text
    assert "live view: open http://127.0.0.1:" in text
    out = tmp_path / "out"
    summary = json.loads((out / "summary.json").read_text())
    assert set(KEYS) <= set(summary)
    assert summary["ok"] and not summary["partial"] and summary["seed"] == 3
    assert summary["path_m"] > 0.3 and summary["scans"] > 20
    # Time starts once everybody listens and waits for the mapper, so no scan is lost.
    assert summary["scans"] - summary["scans_used"] <= 1
    assert summary["ate_m"]["rms"] < 0.1 and summary["map_error_m"] < 0.1
    assert 0.5 < summary["map_found_share"] <= 1.0
    names = ("map.png", "errors.png", "world.png", "trajectory.tum", "ground_truth.tum")
    for name in (*names, "report.html"):
        assert (out / name).stat().st_size > 100, name
    assert (out / summary["bag"] / "metadata.yaml").exists()
    assert len((out / "trajectory.tum").read_text().splitlines()[0].split()) == 8


def test_the_main_job_maps_localizes_plans_and_drives_beside_the_usual_robot(
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    code, text = _run("flat_day", "--duration", "4", "--film", "--out", str(out))
    assert code == 0, text
    summary = json.loads((out / "summary.json").read_text())
    assert set(DAY_KEYS) <= set(summary)
    assert summary["world"] == "flat_day" and summary["ok"] and not summary["partial"]
    assert summary["goals"] == 4 and summary["collisions"] == summary["glass_touched"] == 0
    assert summary["sim_s"] >= 4.0 and summary["path_m"] > 0.2
    assert summary["inputs_handled"].keys() >= set(NODES)
    assert summary["inputs_handled"]["grid_mapper"] > 0.5
    assert summary["inputs_handled"]["wavefront_planner"] == 1.0
    assert summary["pose_error_m"]["grid_mapper"]["rms"] < 0.1
    assert summary["baseline"]["path_m"] > 0.2 and summary["baseline"]["time_s"] >= 4.0
    assert summary["load"].keys() >= {*NODES, "local_planner", "sim_bridge"}
    assert summary["latency_ms"]["pose"]["p50_ms"] > 0.0
    for name in ("map.png", "zones.png", "errors.png", "film.gif", "report.html"):
        assert (out / name).stat().st_size > 1000, name
    assert (out / summary["bag"] / "metadata.yaml").exists()
    assert "floornav:" in text and "laser + VFH+:" in text


def test_an_unknown_world_is_one_line_that_names_those_there_are() -> None:
    code, text = _run("nowhere")
    assert code == 2
    assert text.count("\n") == 1 and "furnished_floor" in text


def test_ctrl_c_ends_all_children_and_marks_the_results_partial(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = _start("furnished_floor", "--out", str(out))
    log = out / "logs" / "sim_bridge.log"
    end = time.monotonic() + TIMEOUT_S
    while not (log.exists() and "ready" in log.read_text()):
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.2)
    time.sleep(2.0)  # well into the run or not: Ctrl-C has to end it anyway
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 1
    summary = json.loads((out / "summary.json").read_text())
    assert summary["partial"] and not summary["ok"]
    assert not _running_with(str(out))


def _running_with(text: str) -> list[str]:
    """Return the command lines of processes that mention a text."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if text in line and str(os.getpid()) != path.parent.name:
            found.append(line)
    return found


def test_a_world_without_a_route_is_driven_and_pictured(tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, text = _run("sjmc_oncoming", "--duration", "3", "--out", str(out))
    assert code == 0, text
    summary = json.loads((out / "summary.json").read_text())
    assert summary["ok"] and summary["sim_s"] >= 3.0 and summary["people"] == 1
    robot = summary["robots"][""]
    assert robot["path_m"] > 0.3 and robot["messages"]["scan"] > 20
    for name in ("plan.png", "world.png", "report.html"):
        assert (out / name).stat().st_size > 1000, name
    assert (out / summary["bag"] / "metadata.yaml").exists()


def test_a_live_view_where_nobody_maps_is_refused_before_anything_is_written(
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    code, text = _run("field", "--live", "--out", str(out))
    assert code == 2
    assert text.count("\n") == 1 and "--live: nobody maps in field" in text
    assert not out.exists()


def test_an_unknown_figure_of_a_world_is_one_line() -> None:
    code, text = _run("sjmc_static", "--set", "distance=2")
    assert code == 2
    assert text.count("\n") == 1 and "start_distance_m" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--rtf", "-1"), "must be a number in 0..1000, got -1"),
        (("--rtf", "fast"), "must be a number in 0..1000, got fast"),
        (("--duration", "nan"), "must be a number > 0, got nan"),
    ],
)
def test_a_figure_out_of_range_is_refused_at_once(words: tuple[str, ...], said: str) -> None:
    code, text = _run(*words)
    assert code == 2 and said in text.splitlines()[-1]


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("robots: [{model: segway_rmp50, position_m: [3, 0]}]", "is inside 'wall'"),
        ("robots: []", "no robots"),
    ],
)
def test_a_world_that_cannot_be_driven_is_one_line_before_anything_starts(
    tmp_path: Path, place: str, said: str
) -> None:
    world, out = tmp_path / "mine.yaml", tmp_path / "out"
    world.write_text(f"name: mine\nwalls: [{{from_m: [0, 0], to_m: [6, 0]}}]\n{place}\n")
    code, text = _run(str(world), "--out", str(out))
    assert code == 2
    assert text.count("\n") == 1 and said in text
    assert not out.exists()
