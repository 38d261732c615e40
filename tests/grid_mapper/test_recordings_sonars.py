"""Recordings of sonars: text logs with and without poses, bags with and without a laser."""

import json
import math

import numpy as np
import pytest
from recording_builders import (
    NS,
    START_NS,
    data_file,
    drive,
    range_message,
    tf_message,
    transform,
    write_bag,
)

from floornav_common.grid import FREE, OCCUPIED
from floornav_common.reporting import run_command
from floornav_common.se2 import SE2
from grid_mapper.map_bag import main
from grid_mapper.map_files import load_map
from grid_mapper.recordings import RangeEvent, RecordingError, RecordingOptions, open_recording
from grid_mapper.sonar_reading import Free, Hit, classify

HEAD = ",".join([*(f"S{k}" for k in range(1, 25)), "OUTPUT"])


def read(path, **options):
    recording = open_recording(path, RecordingOptions(**options))
    return recording, list(recording.events())


def run(*args) -> int:
    return run_command(lambda: main([str(arg) for arg in args]))


def eight_sonars(folder, num=3, poses=None):
    """Write a log: 0.06 m a row along x, a wall 0.7 m to the right, nothing elsewhere."""
    folder.mkdir()
    rows = [f"{1000 + 200 * k} 700 5110 5110 5110 5110 5110 5110 5110" for k in range(num)]
    places = [f"{1000 + 200 * k} {60 * k} 0 0" for k in range(num)]
    (folder / "measurement.txt").write_text("\n".join(rows) + "\n")
    (folder / "poses.txt").write_text("\n".join(places if poses is None else poses) + "\n")
    return folder


def test_eight_sonars_are_read_with_their_poses_in_si(tmp_path):
    folder = eight_sonars(tmp_path / "log", poses=["1000 0 0 0", "1200 100 -50 900", "1400 0 0 0"])
    recording, events = read(folder)
    assert not recording.has_laser and len(events) == 24
    second = events[8]
    assert second.stamp_ns == 1_200_000_000 and second.frame == "sonar_1"
    assert second.T_odom_base == SE2(0.1, -0.05, math.pi / 2.0)
    assert second.T_base_sonar.yaw == pytest.approx(-math.pi / 2.0)
    assert classify(second.reading).range == pytest.approx(0.7)
    assert classify(events[1].reading) == Free(5.11)


def test_rows_without_a_pose_are_counted_and_words_are_malformed(tmp_path):
    folder = eight_sonars(tmp_path / "log", poses=["1000 0 0 0", "1200 x 0 0"])
    recording, events = read(folder / "measurement.txt")
    assert len(events) == 8
    assert (recording.counts.without_transform, recording.counts.malformed) == (2, 1)
    with pytest.raises(RecordingError, match="no readable row with a pose"):
        read(eight_sonars(tmp_path / "none", poses=["9 0 0 0"]))
    with pytest.raises(RecordingError, match="poses"):
        read(folder, use_odom=False)


def test_a_ring_of_24_sonars_goes_clockwise_and_asks_for_no_odom(tmp_path):
    path = tmp_path / "ring.csv"
    row = ",".join([*(f"{k}.5" if k < 5 else "5.000" for k in range(24)), "Move-Forward"])
    path.write_text(f"{HEAD}\n{row}\n{row}\nbroken,row\n")
    recording, events = read(path, use_odom=False)
    assert len(events) == 48 and recording.counts.malformed == 1
    assert events[6].T_base_sonar.yaw == pytest.approx(-math.pi / 2.0)
    assert classify(events[1].reading) == Hit(1.5) and classify(events[5].reading) == Free(5.0)
    assert events[24].stamp_ns - events[0].stamp_ns == NS // 9
    with pytest.raises(RecordingError, match="--no-odom"):
        read(path)


def test_sonars_alone_make_a_map(tmp_path):
    out = tmp_path / "out"
    assert run(eight_sonars(tmp_path / "log", num=20), "--out", out, "--quiet") == 0
    grid = load_map(out / "map.yaml")
    row, col = grid.to_cells(np.array([[0.575, -0.7]]))[0]
    assert grid.cells[row - 1 : row + 2, col].max() == OCCUPIED
    assert grid.cells[row + 10, col] == FREE
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["ranges"], summary["ranges_placed"], summary["scans"]) == (160, 160, 0)
    assert summary["path_m"] == pytest.approx(1.14)
    assert not (out / "map_glass.yaml").exists()


def sonar_bag(path, values=(0.7, 1.5), has_tf=True):
    """Write a bag without a laser: odometry, and a sonar that looks left."""
    messages = [m for m in drive(5) if m[0] != "/scan"]
    messages += [
        ("/sonar", START_NS + k, range_message(START_NS + k * NS // 10, value))
        for k, value in enumerate(values)
    ]
    if has_tf:
        left = tf_message(transform(0, "base_link", "sonar_0", x=0.1, yaw=math.pi / 2.0))
        messages.insert(0, ("/tf_static", 1, left))
    return write_bag(path, sorted(messages, key=lambda m: m[1]))


def test_a_bag_without_laser_is_mapped_by_its_odometry(tmp_path):
    path = sonar_bag(tmp_path / "bag")
    with pytest.raises(RecordingError, match="no LaserScan.*--sonar-topic /sonar"):
        read(path)
    recording, events = read(path, sonar_topics=("sonar",))
    assert not recording.has_laser and len(events) == 2
    assert all(isinstance(e, RangeEvent) and e.T_odom_base is not None for e in events)
    assert events[0].T_base_sonar.yaw == pytest.approx(math.pi / 2.0)
    assert run(path, "--sonar-topic", "/sonar", "--out", tmp_path / "out", "--quiet") == 0


def test_sonars_that_are_not_asked_for_are_mentioned(tmp_path):
    readings = [
        (topic, START_NS + k, range_message(START_NS + k, 0.7))
        for k, topic in enumerate(("/left", "/right"))
    ]
    left = ("/tf_static", 1, tf_message(transform(0, "base_link", "sonar_0")))
    path = write_bag(tmp_path / "bag", sorted([left, *drive(5), *readings], key=lambda m: m[1]))
    said = "not used: Range messages on {}; if they are sonars: --sonar-topic {}"
    recording, _ = read(path, sonar_topics=("left",))
    assert said.format("/right", "/right") in recording.info
    assert said.format("/left, /right", "/left --sonar-topic /right") in read(path)[0].info
    both, _ = read(path, sonar_topics=("/left", "/right"))
    assert not any("not used" in line for line in both.info)


def test_where_a_sonar_sits_can_be_said(tmp_path):
    path = sonar_bag(tmp_path / "bag", has_tf=False)
    with pytest.raises(RecordingError, match="--sonar-pose sonar_0 X Y YAW"):
        read(path, sonar_topics=("/sonar",))
    pose = SE2(0.2, 0.0, -0.5)
    _, events = read(path, sonar_topics=("/sonar",), sonar_poses=(("sonar_0", pose),))
    assert [e.T_base_sonar.between(pose).distance for e in events] == [0.0, 0.0]
    options = ["--sonar-topic", "/sonar", "--out", tmp_path / "out", "--sonar-pose", "sonar_0"]
    assert run(path, *options, "0.2", "0", "90") == 2
    assert run(path, *options, "0.2", "0", "left") == 2
    assert run(path, *options, "0.2", "0", "-0.5", "--quiet") == 0


def test_values_come_as_the_driver_sent_them(tmp_path):
    """What they mean is told in one place, live and offline: `sonar_reading`."""
    values = (math.nan, math.inf, -math.inf, 0.0, 99.0)
    _, events = read(sonar_bag(tmp_path / "bag", values), sonar_topics=("/sonar",))
    np.testing.assert_equal([e.range for e in events], values)


def test_an_infrared_ranger_is_left_out_and_named_once(tmp_path, capsys):
    plain, mixed = sonar_bag(tmp_path / "plain"), tmp_path / "mixed"
    messages = [m for m in drive(5) if m[0] != "/scan"]
    messages.insert(0, ("/tf_static", 1, tf_message(transform(0, "base_link", "sonar_0"))))
    for k in range(4):
        stamp_ns = START_NS + k * NS // 20
        messages.append(("/sonar", stamp_ns, range_message(stamp_ns, 0.7)))
        infrared = range_message(stamp_ns, math.inf, "ir_front", radiation=1)
        messages.append(("/sonar", stamp_ns + 1, infrared))
    write_bag(mixed, sorted(messages, key=lambda m: m[1]))
    recording, events = read(mixed, sonar_topics=("/sonar",))
    assert [e.frame for e in events] == ["sonar_0"] * 4
    assert recording.counts.infrared == {"ir_front"} and recording.counts.malformed == 0
    out = tmp_path / "out"
    assert run(mixed, "--sonar-topic", "/sonar", "--out", out, "--quiet") == 0
    assert capsys.readouterr().err.count("ir_front: infrared rangers see through glass") == 1
    assert json.loads((out / "summary.json").read_text())["infrared_frames"] == ["ir_front"]
    assert run(plain, "--sonar-topic", "/sonar", "--out", tmp_path / "no", "--quiet") == 0
    assert "infrared" not in capsys.readouterr().err


def test_real_eight_sonars_show_a_corridor_round_a_corner(tmp_path):
    folder = data_file("sonar8-mapping")
    recording, events = read(folder)
    assert len(events) == 8 * 413 and recording.counts.malformed == 0
    silent = np.mean([isinstance(classify(e.reading), Free) for e in events])
    assert silent == pytest.approx(0.323, abs=0.002)
    assert run(folder, "--out", tmp_path / "out", "--quiet") == 0
    grid = load_map(tmp_path / "out" / "map.yaml")
    assert (grid.cells == OCCUPIED).sum() > 500 and (grid.cells == FREE).sum() > 20_000


def test_the_real_ring_of_24_parses_and_runs(tmp_path):
    path = data_file("scitos-sonar24/sensor_readings_24_first_half.csv.gz")
    recording, events = read(path, use_odom=False)
    assert len(events) == 24 * 2728 and recording.counts.malformed == 0
    silent = np.mean([not isinstance(classify(e.reading), Hit) for e in events])
    assert silent == pytest.approx(0.15, abs=0.01)
    assert run(path, "--no-odom", "--out", tmp_path / "out", "--quiet") == 0


def test_the_real_tiago_sonars_parse_and_run(tmp_path):
    path = data_file("tiago-sonar-lidar/sonar.bag")
    frames = [f"base_sonar_0{k}_link" for k in (1, 2, 3)]
    given = tuple((frame, SE2(0.2, 0.0, k - 1.0)) for k, frame in enumerate(frames))
    _, events = read(path, sonar_topics=("/sonar_base",), sonar_poses=given, use_odom=False)
    assert len(events) == 609 and {e.frame for e in events} == set(frames)
    assert {type(classify(e.reading)) for e in events} == {Hit, Free}
