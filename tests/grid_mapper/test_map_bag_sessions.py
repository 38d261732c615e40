"""Floors mapped in several sittings by map_bag."""

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
from recording_builders import NS, START_NS, scan_message, tf_message, transform, write_bag

from grid_mapper.trajectory_metrics import load_tum

NUM_UNTIL_FOUND = 12
"""Scans in the half meter or so over which they have to fit."""


@pytest.mark.parametrize("saved_as", [None, "other.session", "room.session", "link.session"])
def test_a_session_taken_up_gives_the_files_of_one_run(tmp_path, monkeypatch, saved_as):
    monkeypatch.setattr("grid_mapper.session_files.EVENTS_A_PART", 20)  # a later one has more parts
    bag, session = room_bag(tmp_path / "bag", sonar=1.5), tmp_path / "room.session"
    (tmp_path / "link.session").symlink_to(session)
    sonar = ("--sonar-topic", "/sonar", "--quiet")
    at_once = tmp_path / "at-once.session"
    assert run(bag, *sonar, "--out", tmp_path / "whole", "--save-session", at_once) == 0
    part = ("--max-scans", "8", "--save-session", session)
    assert run(bag, *sonar, "--out", tmp_path / "a", *part) == 0
    save = () if saved_as is None else ("--save-session", tmp_path / saved_as)
    assert run(bag, *sonar, "--out", tmp_path / "b", "--session", session, *save) == 0
    for name in ("trajectory.tum", "map.pgm", "map.yaml", "map.png"):
        whole = (tmp_path / "whole" / name).read_bytes()
        assert (tmp_path / "b" / name).read_bytes() == whole, name
    if saved_as is not None:
        assert (tmp_path / saved_as).read_bytes() == at_once.read_bytes()


def test_progress_ends_at_all_and_says_which_time_it_is(tmp_path, capsys):
    bag, session = room_bag(tmp_path / "bag"), tmp_path / "room.session"
    part = ("--max-scans", "8", "--save-session", session)
    assert run(bag, "--out", tmp_path / "a", *part) == 0
    assert "mapping: 100 %  maps of 8 scans, 0 not trusted" in capsys.readouterr().out
    assert run(bag, "--out", tmp_path / "b", "--session", session) == 0
    assert "mapping: 100 %  maps of 20 scans, 0 not trusted" in capsys.readouterr().out


def test_a_saved_session_changes_no_file(tmp_path):
    bag = room_bag(tmp_path / "bag")
    assert run(bag, "--out", tmp_path / "a", "--quiet") == 0
    save = ("--save-session", tmp_path / "room.session")
    assert run(bag, "--out", tmp_path / "b", "--quiet", *save) == 0
    for name in ("trajectory.tum", "map.pgm", "map.yaml", "map.png"):
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "a" / name).read_bytes(), name


def test_a_session_that_is_none_is_one_line_and_leaves_nothing(tmp_path, capsys):
    bag, other = room_bag(tmp_path / "bag"), tmp_path / "other"
    other.write_text("something else")
    assert run(bag, "--session", other, "--out", tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert "other is no session of map_bag, or is cut off" in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_another_recording_of_the_same_time_goes_on_with_a_session(tmp_path, capsys):
    first, second = room_bag(tmp_path / "a", 12), room_bag(tmp_path / "b", 20, begin=0.1)
    session = tmp_path / "room.session"
    assert run(first, "--out", tmp_path / "one", "--save-session", session, "--quiet") == 0
    assert run(second, "--out", tmp_path / "two", "--session", session, "--quiet") == 0
    stamps = [stamp_ns for stamp_ns, _ in load_tum(tmp_path / "two" / "trajectory.tum")]
    summary = summary_of(tmp_path / "two")
    used, unplaced = summary["scans_used"], summary["scans_unplaced"]
    assert len(stamps) == used == 32 - unplaced and unplaced <= NUM_UNTIL_FOUND
    assert stamps[12] == stamps[unplaced] < stamps[11]
    assert [summary[f"scans{k}"] for k in ("", "_untrusted")] == [32, 0]


def elsewhere_then_room(path, num_elsewhere, num_room):
    """Write a drive whose first scans are of a hall that is nowhere in the room."""
    ranges = [2.0 * room_ranges(-0.5 + 0.025 * k) for k in range(num_elsewhere)]
    ranges += [room_ranges(0.03 + 0.05 * k) for k in range(num_room)]
    late_ns = START_NS + 10**6 * NS
    messages = [("/tf_static", late_ns, tf_message(transform(late_ns, "base_link", "laser")))]
    for k, of_scan in enumerate(ranges):
        stamp_ns = late_ns + k * NS // 10
        scan = scan_message(stamp_ns, of_scan)
        scan.angle_min, scan.angle_increment = -np.pi, 2 * np.pi / NUM_ROOM_BEAMS
        odom = tf_message(transform(stamp_ns, "odom", "base_link", x=0.05 * k))
        messages += [("/tf", stamp_ns, odom), ("/scan", stamp_ns + 1, scan)]
    return write_bag(path, messages, "mcap")


def test_a_recording_that_is_nowhere_in_a_session_is_left_out_and_not_saved(tmp_path, capsys):
    session, one, two = tmp_path / "room.session", tmp_path / "one", tmp_path / "two"
    room = room_bag(tmp_path / "a", 12)
    assert run(room, "--out", one, "--save-session", session, "--quiet") == 0
    saved = session.read_bytes()
    hall = elsewhere_then_room(tmp_path / "hall", 20, 0)
    words = ("--session", session, "--save-session", session, "--quiet")
    assert run(hall, "--out", two, *words) == 1
    error = capsys.readouterr().err
    assert "was not found in the session room.session: start a recording near its last" in error
    assert session.read_bytes() == saved
    for name in ("trajectory.tum", "map.pgm"):
        assert (two / name).read_bytes() == (one / name).read_bytes()
    summary = summary_of(two)
    assert [summary[k] for k in ("ok", "partial", "scans", "scans_used", "scans_unplaced")] == [
        False, True, 32, 12, 20,
    ]  # fmt: skip
    assert summary["duration_s"] == pytest.approx(1.1) and summary["real_time_factor"] is None


def test_scans_before_the_robot_is_found_in_a_session_are_left_out(tmp_path, capsys):
    session, both = tmp_path / "room.session", tmp_path / "both.session"
    room = room_bag(tmp_path / "a", 12)
    assert run(room, "--out", tmp_path / "one", "--save-session", session, "--quiet") == 0
    bag = elsewhere_then_room(tmp_path / "bag", 4, 20)
    words = ("--session", session, "--save-session", both)
    assert run(bag, "--out", tmp_path / "two", *words) == 0
    summary = summary_of(tmp_path / "two")
    num = summary["scans_unplaced"] - 4
    assert 0 <= num <= NUM_UNTIL_FOUND
    assert f"met: {num + 4} before the robot was found" in capsys.readouterr().out
    poses = load_tum(tmp_path / "two" / "trajectory.tum")
    ahead = [pose.x for _, pose in poses[12:]]
    assert ahead == pytest.approx([0.03 + 0.05 * k for k in range(num, 20)], abs=0.02)
    assert summary["duration_s"] == pytest.approx(1.1 + 0.1 * (19 - num))  # not days between
    assert summary["path_m"] == pytest.approx(0.55 + 0.05 * (19 - num), abs=0.02)  # nor the way
    assert run(bag, "--out", tmp_path / "three", "--session", both, "--quiet") == 0
    for name in ("trajectory.tum", "map.pgm"):
        again = (tmp_path / "three" / name).read_bytes()
        assert again == (tmp_path / "two" / name).read_bytes()


def test_sessions_that_cannot_be_are_one_line_and_leave_nothing(tmp_path, capsys):
    first, second = room_bag(tmp_path / "a", 6), room_bag(tmp_path / "b", 20, begin=0.1)
    one, two, out = tmp_path / "one.session", tmp_path / "two.session", tmp_path / "out"
    assert run(first, "--out", tmp_path / "x", "--save-session", one, "--quiet") == 0
    words = ("--session", one, "--save-session", two, "--quiet")
    assert run(second, "--out", tmp_path / "y", *words) == 0
    sonars = tmp_path / "sonars"
    sonars.mkdir()
    (sonars / "poses.txt").write_text("0 0 0 0\n100 0 0 0\n")
    (sonars / "measurement.txt").write_text(f"0{8 * ' 900'}\n100{8 * ' 900'}\n")
    capsys.readouterr()
    for words, expected in (
        ((first, "--session", two), "two.session holds this recording already"),
        ((sonars, "--save-session", one), "sessions are of recordings with a laser"),
        ((first, "--save-session", tmp_path), "cannot be written"),
        ((first, "--save-session", tmp_path / "no" / "a"), "there is no folder"),
    ):
        assert run(*words, "--out", out) == 2
        error = capsys.readouterr().err
        assert expected in error and error.count("\n") == 1
        assert not out.exists()


def test_a_map_is_kept_where_the_session_cannot_be_saved(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("grid_mapper.loop_run.save_session", full)
    bag, out = room_bag(tmp_path / "bag", 6), tmp_path / "out"
    assert run(bag, "--out", out, "--save-session", tmp_path / "a.session", "--quiet") == 1
    assert "could not be saved: [Errno 28] No space left" in capsys.readouterr().err
    assert {f.name for f in out.iterdir()} == RESULT_FILES
