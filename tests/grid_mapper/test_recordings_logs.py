import gzip
import math

import numpy as np
import pytest
from recording_builders import NS, data_file

from floornav_common.se2 import SE2
from grid_mapper.recordings import RecordingError, RecordingOptions, open_recording
from grid_mapper.recordings.events import WheelOptions
from grid_mapper.recordings.mines_rover import arc, dead_reckoning

TOL_M = 1e-6


def read(path, **options):
    recording = open_recording(path, RecordingOptions(**options))
    return recording, list(recording.events())


def flaser(pose, odom, t, ranges=(1.0, 81.83, 2.0, 3.0)):
    values = [len(ranges), *ranges, *pose, *odom, t, "host", t]
    return "FLASER " + " ".join(str(v) for v in values)


def write(path, lines):
    path.write_text("\n".join(lines) + "\n")
    return path


def test_carmen_odometry_is_the_second_pose_when_they_differ(tmp_path):
    lines = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10.5 + i) for i in range(3)]
    recording, events = read(write(tmp_path / "log", lines))
    assert [e.stamp_ns for e in events] == [10_500_000_000, 11_500_000_000, 12_500_000_000]
    assert [e.T_odom_base.x for e in events] == pytest.approx([0.0, 0.1, 0.2])
    assert any("second pose" in line for line in recording.info)


def test_carmen_beams_fan_from_the_right_and_81_83_is_nothing_seen(tmp_path):
    _, events = read(write(tmp_path / "log", [flaser((5, 5, 1), (0, 0, 0), 1)]))
    scan = events[0].scan
    assert scan.angle_min == pytest.approx(-math.pi / 2)
    assert scan.angle_increment == pytest.approx(math.pi / 4)
    np.testing.assert_allclose(scan.ranges, [1.0, math.inf, 2.0, 3.0])


def test_carmen_odom_lines_are_interpolated_when_both_poses_are_the_same(tmp_path):
    lines = [
        "PARAM robot_frontlaser_offset 0.3 0 host 0",
        "ODOM 0.0 0 0 0 0 0 1.0 host 1.0",
        flaser((9, 9, 0), (9, 9, 0), 1.5),
        "ODOM 1.0 0 0 0 0 0 2.0 host 2.0",
    ]
    recording, events = read(write(tmp_path / "log", lines))
    assert events[0].T_odom_base.x == pytest.approx(0.5)
    assert events[0].T_base_laser == SE2(0.3, 0.0, 0.0)
    assert any("--no-odom" in line for line in recording.info)


def test_carmen_laser_pose_is_a_constant_offset_between_the_poses(tmp_path):
    lines = [flaser((0.25 + i, 0, 0), (i, 0, 0), i + 1) for i in range(3)]
    _, events = read(write(tmp_path / "log", lines))
    assert events[0].T_base_laser.x == pytest.approx(0.25)


def test_carmen_log_that_never_moves_has_no_odometry(tmp_path):
    path = write(tmp_path / "log", [flaser((0, 0, 0), (0, 0, 0), i + 1) for i in range(3)])
    with pytest.raises(RecordingError, match="--no-odom"):
        read(path)
    assert len(read(path, use_odom=False)[1]) == 3


def test_carmen_robotlaser_line_carries_both_poses(tmp_path):
    line = "ROBOTLASER1 0 -1.5 3.0 1.0 50 0.1 0 4 1 2 3 60 0 1.2 0 0 1 0 0 0 0 0 0 0 7.25 h 7"
    _, events = read(write(tmp_path / "log", [line]))
    assert events[0].T_odom_base == SE2(1.0, 0.0, 0.0)
    assert events[0].T_base_laser.x == pytest.approx(0.2)
    assert events[0].stamp_ns == 7_250_000_000
    np.testing.assert_allclose(events[0].scan.ranges, [1, 2, 3, math.inf])


def test_broken_lines_are_counted_and_passed_over(tmp_path):
    good = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10 + i) for i in range(2)]
    recording, events = read(write(tmp_path / "log", [good[0], "FLASER 4 1 2", good[1]]))
    assert len(events) == 2
    assert recording.counts.malformed == 1


def test_a_log_that_jumps_back_says_so_and_keeps_its_order(tmp_path):
    stamps = [10.0, 10.5, 10.2, 3.0, 3.5, 3.5]
    lines = [flaser((5, 5, 1), (i, 0, 0), t) for i, t in enumerate(stamps)]
    recording, events = read(write(tmp_path / "log", lines))
    assert [e.T_odom_base.x for e in events] == [0, 1, 2, 3, 4, 5]
    assert [e.follows_jump for e in events] == [False, False, False, True, False, False]
    counts = recording.counts
    assert (counts.stamps_backwards, counts.stamps_repeated, counts.jumps) == (2, 1, 1)


def test_gzip_is_read_directly_and_a_cut_one_as_far_as_it_goes(tmp_path):
    rng = np.random.default_rng(0)
    lines = [
        flaser((5, 5, 1), (i, 0, 0), i, [f"{r:.9f}" for r in rng.uniform(1, 9, 50)])
        for i in range(200)
    ]
    packed = gzip.compress("\n".join(lines).encode())
    (tmp_path / "whole").write_bytes(packed)
    (tmp_path / "cut").write_bytes(packed[: len(packed) // 2])
    assert len(read(tmp_path / "whole")[1]) == 200
    recording, events = read(tmp_path / "cut")
    assert 10 < len(events) < 200
    assert "cut off" in recording.problem


def test_a_log_cut_in_the_middle_of_a_line_says_so_and_no_half_number_counts(tmp_path):
    lines = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10 + i) for i in range(5)]
    whole, last = "\n".join(lines[:4]) + "\n", lines[-1]
    for left in range(1, last.rindex(" ")):
        (tmp_path / "cut").write_text(whole + last[:left])
        recording, events = read(tmp_path / "cut")
        assert recording.problem == "cut is cut off in the middle of line 5"
        assert [e.stamp_ns for e in events] == [k * NS for k in range(10, 14)]


def test_a_last_line_without_an_end_is_whole_if_it_has_all_words(tmp_path):
    lines = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10 + i) for i in range(5)]
    for end in ("", "\n", "\r\n"):
        (tmp_path / "log").write_bytes(("\n".join(lines) + end).encode())
        recording, events = read(tmp_path / "log")
        assert recording.problem is None and len(events) == 5


def test_a_pose_graph_cut_before_its_edges_says_that_first(tmp_path):
    rng, lines = np.random.default_rng(0), []
    for i in range(40):
        ranges = " ".join(f"{r:.9f}" for r in rng.uniform(1, 9, 20))
        fan = f"0 -1.5 3.0 0.15 50 0.1 0 20 {ranges} 0"
        lines.append(f"VERTEX2 {i} {i} 0 0\nROBOTLASER1 {fan} 0 0 0 0 0 0 0 0 0 0 0 {i} h 7")
    lines += [f"EDGE2 {i} {i + 1} 1 0 0 1 0 1 1 0 0" for i in range(39)]
    packed = gzip.compress("\n".join(lines).encode())
    (tmp_path / "cut").write_bytes(packed[: len(packed) // 2])
    with pytest.raises(RecordingError, match="cut off or damaged .* no EDGE2 from vertex 0 to 1"):
        read(tmp_path / "cut")


def rawlaser(t, kind="RAWLASER1", nothing=81.9):
    return f"{kind} 0 -1.5708 3.1416 0.7854 81.9 0.01 0 4 1 2 {nothing} 4 0 {t} host {t}"


def odom(x, t):
    return f"ODOM {x} 0 0 0 0 0 {t} host {t}"


def test_raw_laser_lines_take_their_odometry_from_odom_lines(tmp_path):
    lines = [x for i in range(4) for x in (odom(0.1 * i, 10 + i), rawlaser(10.5 + i))]
    path = write(tmp_path / "log", ["PARAM robot_frontlaser_offset 0.3 0 host 0", *lines])
    recording, events = read(path)
    assert [e.T_odom_base.x for e in events] == pytest.approx([0.05, 0.15, 0.25])
    assert events[0].T_base_laser.x == 0.3 and events[0].scan.angle_increment == 0.7854
    assert recording.counts.without_transform == 1
    bare = write(tmp_path / "bare", [rawlaser(10.5)])
    with pytest.raises(RecordingError, match="--no-odom"):
        read(bare)
    assert len(read(bare, use_odom=False)[1]) == 1


def test_a_scan_logged_in_several_ways_is_used_once(tmp_path):
    lines = [
        x for i in range(3) for x in (flaser((5, 5, 1), (i, 0, 0), i), rawlaser(i), odom(i, i))
    ]
    rear = [flaser((5, 5, 1), (i, 0, 0), i).replace("FLASER", "RLASER") for i in range(3)]
    recording, events = read(write(tmp_path / "log", [*lines, *rear]))
    assert [e.T_odom_base.x for e in events] == [0, 1, 2]
    assert "scans: 3 RAWLASER1 lines are passed over" in recording.info
    with pytest.raises(RecordingError, match="rear laser only"):
        read(write(tmp_path / "rear", rear))


def test_scans_beyond_the_odom_lines_are_counted_not_put_at_the_origin(tmp_path):
    lasers = [flaser((0, 0, 0), (0, 0, 0), i + 0.5) for i in range(5)]
    recording, events = read(
        write(tmp_path / "log", [*(odom(0.1 * i, i) for i in range(5)), *lasers])
    )
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.05, 0.15, 0.25, 0.35]
    assert recording.counts.without_transform == 1


def test_odom_lines_of_another_clock_are_not_used_and_not_named(tmp_path):
    lines = [x for i in range(3) for x in (odom(i, 1000 + i), flaser((i, 0, 0), (i, 0, 0), i))]
    recording, events = read(write(tmp_path / "log", lines))
    assert [e.T_odom_base.x for e in events] == [0, 1, 2]
    assert any("second pose of each laser line" in line for line in recording.info)


@pytest.mark.parametrize(
    "packed",
    ["\r\n".join, "\r".join, lambda lines: "\ufeff" + "\n".join(lines),
     lambda lines: "\n".join(["# " + 200 * "x"] * 1000 + lines)],
    ids=["windows", "old mac", "byte order mark", "long head"],
)  # fmt: skip
def test_lines_end_and_files_begin_as_they_like(tmp_path, packed):
    lines = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10 + i) for i in range(5)]
    (tmp_path / "log").write_bytes(packed(lines).encode())
    (tmp_path / "log.gz").write_bytes(gzip.compress(packed(lines).encode()))
    for name in ("log", "log.gz"):
        recording, events = read(tmp_path / name)
        assert len(events) == 5 and recording.counts.malformed == 0


def test_bytes_that_are_no_text_do_no_harm(tmp_path):
    lines = [flaser((5, 5, 1), (0.1 * i, 0, 0), 10 + i) for i in range(5)]
    text = "\n".join(lines).encode()
    (tmp_path / "cut").write_bytes(text[:-40])
    (tmp_path / "latin").write_bytes(b"# caf\xe9 \xff\n" + text.replace(b"host", b"h\xf6st"))
    assert len(read(tmp_path / "latin")[1]) == 5
    recording, events = read(tmp_path / "cut")
    assert len(events) == 4 and recording.counts.malformed == 1
    noise = np.random.default_rng(0).bytes(100_000)
    for name, content in (("noise", noise), ("noise.gz", gzip.compress(noise)),
                          ("blank", b"\n"), ("none.gz", gzip.compress(b""))):  # fmt: skip
        (tmp_path / name).write_bytes(content)
        with pytest.raises(RecordingError, match="no known format"):
            read(tmp_path / name)


def test_what_a_driver_writes_for_nothing_seen_is_found_out(tmp_path):
    rng = np.random.default_rng(0)
    lines = []
    for i in range(20):
        ranges = np.round(rng.uniform(1.0, 8.0, 180), 2)
        ranges[rng.random(180) < 0.05] = 8.19
        lines.append(flaser((5, 5, 1), (i, 0, 0), i, ranges))
    recording, events = read(write(tmp_path / "log", lines))
    assert any("8.19 m is what the log writes for nothing seen" in line for line in recording.info)
    assert max(e.scan.ranges[np.isfinite(e.scan.ranges)].max() for e in events) <= 8.0
    assert sum(int(np.isposinf(e.scan.ranges).sum()) for e in events) > 100
    _, events = read(tmp_path / "log", range_limits_m=(0.1, 9.0))
    assert not any(np.isposinf(e.scan.ranges).any() for e in events)


@pytest.mark.parametrize(
    ("param", "cure"),
    [("robot_frontlaser_offset", "--laser-pose"), ("robot_front_laser_max", "--range-limits")],
)
def test_a_param_that_is_no_number_names_its_cure(tmp_path, param, cure):
    path = write(tmp_path / "log", [f"PARAM {param} abc", flaser((5, 5, 1), (0, 0, 0), 1)])
    with pytest.raises(RecordingError, match=cure):
        read(path)


@pytest.mark.parametrize(
    ("num_beams", "first_deg", "step_deg"),
    [(180, -90, 1.0), (181, -90, 1.0), (360, -90, 0.5), (361, -90, 0.5), (401, -50, 0.25)],
)
def test_beam_counts_of_the_sick_tell_their_angles(tmp_path, num_beams, first_deg, step_deg):
    path = write(tmp_path / "log", [flaser((5, 5, 1), (0, 0, 0), 1, [1] * num_beams)])
    recording, events = read(path)
    assert np.degrees(events[0].scan.angle_min) == pytest.approx(first_deg)
    assert np.degrees(events[0].scan.angle_increment) == pytest.approx(step_deg)
    assert any(f"{num_beams} beams from {first_deg:.1f} deg" in line for line in recording.info)


def test_laser_lines_without_a_readable_stamp_are_named_as_such(tmp_path):
    path = write(tmp_path / "log", [flaser((5, 5, 1), (0, 0, 0), "nan")] * 3)
    with pytest.raises(RecordingError, match="3 laser lines, none of which can be read"):
        read(path)


def posegraph(tmp_path, edges):
    robot = "0 0 0 0 0 0 0 0 0 0 0"
    lines = []
    for i in range(3):
        lines.append(f"VERTEX2 {i} 99 99 0")
        lines.append(f"ROBOTLASER1 0 -1.5 3.0 1.0 50 0.1 0 2 1 2 0 {robot} {i}.5 host 0")
    return write(tmp_path / "graph.log", [*lines, *edges])


def test_posegraph_odometry_is_the_chain_of_edges_never_the_vertex_poses(tmp_path):
    edges = [f"EDGE2 {i} {i + 1} 1 0 {math.pi / 2} 1 0 1 1 0 0" for i in range(2)]
    recording, events = read(posegraph(tmp_path, edges))
    assert events[0].T_odom_base == SE2.identity()
    assert events[2].T_odom_base.x == pytest.approx(1.0, abs=TOL_M)
    assert events[2].T_odom_base.y == pytest.approx(1.0, abs=TOL_M)
    assert any("EDGE2" in line for line in recording.info)


def test_posegraph_with_a_broken_chain_needs_no_odom(tmp_path):
    path = posegraph(tmp_path, ["EDGE2 0 1 1 0 0 1 0 1 1 0 0"])
    with pytest.raises(RecordingError, match="--no-odom"):
        read(path)
    assert len(read(path, use_odom=False)[1]) == 3


def test_wean_hall_is_in_centimeters(tmp_path):
    ranges = " ".join(["8183", "8191", *["250"] * 178])
    lines = ["O 100 0 0 0.1", f"L 100 0 0 125 0 0 {ranges} 0.25"]
    _, events = read(write(tmp_path / "log", lines))
    assert events[0].T_odom_base == SE2(1.0, 0.0, 0.0)
    assert events[0].T_base_laser.x == pytest.approx(0.25)
    assert events[0].stamp_ns == NS // 4
    np.testing.assert_allclose(events[0].scan.ranges[:3], [math.inf, math.inf, 2.5])


def test_rover_ticks_become_dead_reckoning():
    wheels = WheelOptions(ticks_per_turn=1000.0, wheel_radius_m=0.1, half_axle_m=0.2)
    turn = 2.0 * math.pi * 0.1
    poses = dead_reckoning(np.array([[0, 0], [1000, 1000], [1000, 2000]]), wheels)
    assert poses[1].x == pytest.approx(turn)
    assert poses[2].yaw == pytest.approx(turn / 0.4)
    with pytest.raises(ValueError, match="wheel_radius_m"):
        WheelOptions(wheel_radius_m=0.0)


def test_an_arc_meets_the_sum_of_small_arcs():
    many = SE2.identity()
    for _ in range(100):
        many = many @ arc(0.01, 0.02, 0.2)
    np.testing.assert_allclose(arc(1.0, 2.0, 0.2).as_array(), many.as_array(), atol=TOL_M)


def test_rover_lines_are_recognized_by_their_columns(tmp_path):
    row = ["1000000", "0", "0", "0", *["0"] * 20, *["0", "1500"] * 341, "0"]
    moved = ["1100000", "0", "2000", "2000", *row[4:]]
    _, events = read(write(tmp_path / "log", [" ".join(row), " ".join(moved)]))
    assert [e.stamp_ns for e in events] == [NS, NS + NS // 10]
    assert events[1].T_odom_base.x == pytest.approx(2.0 * math.pi * 0.077)
    assert math.isnan(events[0].scan.ranges[0]) and events[0].scan.ranges[1] == 1.5


@pytest.mark.parametrize(
    ("name", "num_scans", "way"),
    [("intel-lab/intel_keyframes_rawodom_corrected.log.gz", 910, 501.1),
     ("intel-lab/intel_posegraph.log.gz", 2672, 361.2),
     ("fr079/fr079_corrected.log.gz", 4791, 424.9),
     ("fr079/fr079_posegraph.log.gz", 1464, 391.1), ("wean-hall/robotdata1.log.gz", 713, 41.2),
     ("wean-hall/robotdata4.log.gz", 600, 21.5), ("mines-rover/exp1.dat.gz", 756, 46.0)],
)  # fmt: skip
def test_real_logs_give_all_their_scans(name, num_scans, way):
    recording, events = read(data_file(name))
    poses = [e.T_odom_base for e in events]
    length = sum(a.between(b).distance for a, b in zip(poses, poses[1:], strict=False))
    assert recording.counts.scans == len(events) == num_scans
    assert recording.counts.malformed == 0
    assert length == pytest.approx(way, abs=0.1)


def test_the_dense_intel_log_steps_back_97_times():
    recording, events = read(data_file("intel-lab/intel_posegraph.log.gz"))
    assert recording.counts.stamps_backwards == 97
    assert recording.counts.jumps == 0
