"""The five-robot experiment: reader, judging, a made recording whole, the real one in part."""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mrclam_files import DELAY_S, SPEED, write_recording

from experiments.mrclam_measures import errors_of
from experiments.mrclam_noise import first_half
from experiments.mrclam_recording import RobotLog, TeamRecording, load_recording
from experiments.mrclam_runs import Track, dead_reckoning, run_filter
from experiments.mrclam_triangles import count_triangles
from floornav_common.reporting import UserError
from multi_localizer.team_filter import TeamFilter
from multi_localizer.team_sightings import Sighting

EVALUATE = Path(__file__).resolve().parents[2] / "scripts" / "evaluate.py"
REAL = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "mrclam6"
THREE = (1, 2, 3)


def started(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(EVALUATE), "mrclam", *words]
    env = {**os.environ, "FLOORNAV_ENV_READY": "1"}
    return subprocess.run(
        command, cwd=folder, timeout=600.0, env=env, capture_output=True, text=True
    )


def test_velocities_are_held_and_take_effect_late() -> None:
    odometry = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, np.pi / 2], [2.0, 0.0, 0.0]])
    log = RobotLog(odometry, np.empty((0, 3)), np.empty((0, 4)), 0)
    driven = log.dead_reckoned(np.array([0.2, 0.7, 1.7, 9.0]), 0.2)
    expected = [[0, 0, 0], [0.5, 0, 0], [1, 0, np.pi / 4], [1, 0, np.pi / 2]]
    assert driven == pytest.approx(np.array(expected), abs=1e-9)


def test_truth_is_not_made_up_where_it_is_missing() -> None:
    truth = np.array([[0.0, 0.0, 0.0, 3.1], [0.4, 4.0, 0.0, -3.1], [2.0, 0.0, 0.0, 0.0]])
    log = RobotLog(np.empty((0, 3)), np.empty((0, 3)), truth, 0)
    found = log.truth_at(np.array([0.2, 1.0, 2.5, -0.1]))
    assert found[0] == pytest.approx([2.0, 0.0, np.pi], abs=1e-9)
    assert np.isnan(found[1:]).all()


def test_errors_by_hand() -> None:
    times = np.array([29.0, 30.0, 31.0, 32.0])
    truth = np.array([[t, 0.0, 0.0, 0.0] for t in np.arange(0.0, 33.0, 0.5)])
    log = RobotLog(np.empty((0, 3)), np.empty((0, 3)), truth, 0)
    recording = TeamRecording({1: log}, {}, 0.0, 33.0)
    poses = np.array([[9.0, 9.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 0.0], [np.nan] * 3])
    covs = np.broadcast_to(np.eye(3), (4, 1, 3, 3))
    errors = errors_of(recording, Track(times, poses[:, None], covs))
    assert errors.ate[0] == pytest.approx(np.sqrt(25.0 / 2.0))
    assert errors.worst[0] == pytest.approx(5.0)
    assert errors.located_share[0] == pytest.approx(2.0 / 3.0)
    assert errors.first_s[0] == 29.0
    assert errors.nees[0] == pytest.approx(12.5)
    assert errors.sure_share[0] == pytest.approx(0.5)


def test_ranges_are_not_used_and_unknown_barcodes_are_counted(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 5.0), THREE)
    assert all(log.looks.shape[1] == 3 for log in recording.robots.values())
    assert [log.num_unknown for log in recording.robots.values()] == [1, 1, 1]


def test_ground_truth_does_not_reach_the_runs(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 15.0), THREE)
    blind = {k: replace(log, truth=np.empty((0, 4))) for k, log in recording.robots.items()}
    tracks = [run_filter(r, "named") for r in (recording, replace(recording, robots=blind))]
    assert np.array_equal(tracks[0].poses, tracks[1].poses, equal_nan=True)
    assert np.isfinite(tracks[0].poses[-1]).any()


def test_runs_are_causal(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 15.0), THREE)
    middle = recording.start + 8.0
    cut = {
        k: replace(
            log, looks=log.looks[log.looks[:, 0] <= middle],
            odometry=log.odometry[log.odometry[:, 0] <= middle],
        )
        for k, log in recording.robots.items()
    }  # fmt: skip
    whole = run_filter(recording, "nameless")
    part = run_filter(replace(recording, robots=cut), "nameless")
    is_before = whole.times <= middle
    assert np.array_equal(whole.poses[is_before], part.poses[is_before], equal_nan=True)
    assert not np.array_equal(whole.poses[-1], part.poses[-1])


def test_the_noise_is_chosen_by_what_was_recorded_before_the_middle(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 10.0), THREE)
    middle = 0.5 * (recording.start + recording.end)
    for k, log in first_half(recording).robots.items():
        for part, all_of_it in ((log.looks, recording.robots[k].looks),
                                (log.odometry, recording.robots[k].odometry)):  # fmt: skip
            assert len(part) == np.sum(all_of_it[:, 0] <= middle) < len(all_of_it)
            assert part[:, 0].max() <= middle


def test_a_robot_that_takes_no_part_is_still_seen_by_those_without_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = load_recording(write_recording(tmp_path, 2.0, half_view=np.pi), (1, 2))
    given: list[tuple[str, ...]] = []
    update = TeamFilter.update

    def spy(team: TeamFilter, name: str, sightings: list[Sighting], stamp_ns: int) -> object:
        given.extend(s.meanings for s in sightings if s.meanings[0].startswith("robot"))
        return update(team, name, sightings, stamp_ns)

    monkeypatch.setattr(TeamFilter, "update", spy)
    num_two, num_all = (
        sum(int(np.isin(log.looks[:, 1], who).sum()) for log in recording.robots.values())
        for who in ((1, 2), (1, 2, 3))
    )
    run_filter(recording, "named")
    assert len(given) == num_two < num_all
    given.clear()
    run_filter(recording, "nameless")
    assert len(given) == num_all and {*given} == {("robot1",), ("robot2",)}


def test_dead_reckoning_goes_on_from_the_first_pose(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 15.0), THREE)
    track = run_filter(recording, "alone")
    odometry = dead_reckoning(recording, track, DELAY_S)
    first = int(np.argmax(np.isfinite(track.poses[:, 0, 0])))
    assert odometry.poses[first, 0] == pytest.approx(track.poses[first, 0])
    steps = np.hypot(*np.diff(odometry.poses[first:-5, 0, :2], axis=0).T)
    assert steps == pytest.approx(np.full(len(steps), 0.2 * SPEED), rel=0.01)


def test_the_published_step_finds_triangles_where_cameras_see_all_round(tmp_path: Path) -> None:
    recording = load_recording(write_recording(tmp_path, 36.0, half_view=np.pi), THREE)
    alone = run_filter(recording, "alone")
    triangles = count_triangles(recording, alone, DELAY_S)
    assert triangles.num_instants >= 5
    assert triangles.num_pairs == triangles.num_mutual == triangles.num_instants
    assert triangles.num_found >= triangles.num_instants - 1
    assert triangles.num_right == triangles.num_found


def test_a_made_recording_whole(tmp_path: Path) -> None:
    data = write_recording(tmp_path / "data", 40.0)
    words = ["--data", str(data), "--robots", "1,2,3", "--out", "out", "--quiet"]
    done = started(tmp_path, *words)
    assert done.returncode == 0, done.stderr
    values = json.loads((tmp_path / "out" / "summary.json").read_text())
    for row in ("odometry", "alone", "team"):
        assert sorted(values["ate_m"][row]) == ["1", "2", "3", "mean"]
    assert values["ate_m"]["team"]["mean"] < 0.06
    assert values["ate_m"]["team"] == values["ate_m"]["team_named"]
    assert values["identified_share"] > 0.7 and values["wrong_share"] < 0.01
    assert 0.0 <= values["triangles_share"] <= 1.0
    assert {"report.html", "ways.png", "errors.png"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }


def cut_short(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-200])


def no_gzip(path: Path) -> None:
    path.write_bytes(b"1 2 3\n")


def fewer_columns(path: Path) -> None:
    rows = gzip.decompress(path.read_bytes()).decode().splitlines()
    path.write_bytes(gzip.compress("\n".join([*rows[:-1], rows[-1][:5]]).encode()))


def words_for_numbers(path: Path) -> None:
    path.write_bytes(gzip.compress(b"a b c d\ne f g h\n"))


def not_finite(path: Path) -> None:
    path.write_bytes(gzip.compress(b"1 2 3 nan\n2 3 4 5\n"))


def foreign_barcodes(path: Path) -> None:
    path.write_bytes(gzip.compress(b"1 7777 3 0\n2 7777 4 0\n"))


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (Path.unlink, "no such file"),
        (cut_short, "cannot be read"),
        (no_gzip, "cannot be read"),
        (fewer_columns, "has 1 column, not 4"),
        (words_for_numbers, "could not convert"),
        (not_finite, "not finite"),
        (foreign_barcodes, "none of its barcodes"),
    ],
)
def test_a_spoilt_file_is_refused_by_name(
    tmp_path: Path, spoil: Callable[[Path], None], expected: str
) -> None:
    folder = write_recording(tmp_path / "data", 5.0)
    spoil(folder / "Robot2_Measurement.dat.gz")
    with pytest.raises(UserError, match=expected) as caught:
        load_recording(folder, THREE)
    assert "Robot2_Measurement" in str(caught.value)
    assert set(load_recording(folder, (1, 3)).robots) == {1, 3}


def test_landmarks_cut_short_are_refused(tmp_path: Path) -> None:
    folder = write_recording(tmp_path / "data", 5.0)
    path = folder / "Landmark_Groundtruth.dat"
    path.write_text("\n".join(path.read_text().splitlines()[:-1]) + "\n")
    with pytest.raises(UserError, match=r"lacks landmarks \[11\]"):
        load_recording(folder, THREE)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--data", "nope"], "error: no such folder: nope\n"),
        (["--data", "."], "error: no such file: Barcodes.dat\n"),
        (["--data", ".", "--robots", "1,6"], "robots are 1 to 5, each once, got 1,6\n"),
        (["--data", ".", "--robots", "1,x"], "'1,x' is not a list such as 1,2,5\n"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_folder(
    tmp_path: Path, words: list[str], expected: str
) -> None:
    done = started(tmp_path, *words)
    assert done.returncode == 2
    assert done.stderr.endswith(expected)
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_the_real_team_in_its_first_minutes() -> None:
    if not REAL.is_dir():
        pytest.skip("needs the recording ../shared/data/mrclam6, which is not there")
    whole = load_recording(REAL, (1, 2, 3, 4, 5))
    end = whole.start + 120.0
    cut = {
        k: replace(log, looks=log.looks[log.looks[:, 0] <= end])
        for k, log in whole.robots.items()
    }  # fmt: skip
    recording = replace(whole, robots=cut, end=end)
    errors = {
        mode: errors_of(recording, run_filter(recording, mode)) for mode in ("alone", "named")
    }
    # Robot 2 sees nothing from 12 to 60 s; the whole recording's mean is lower.
    assert errors["named"].ate.mean() < 0.2
    assert errors["named"].ate.mean() < errors["alone"].ate.mean()
    assert errors["named"].located_share.min() > 0.98
