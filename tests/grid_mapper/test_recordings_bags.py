import math

import numpy as np
import pytest
from recording_builders import (
    NS,
    START_NS,
    bump_message,
    data_file,
    drive,
    odom_message,
    range_message,
    scan_message,
    tf_message,
    transform,
    write_bag,
)

from floornav_common.se2 import SE2
from grid_mapper.recordings import RangeEvent, RecordingError, RecordingOptions, open_recording
from grid_mapper.recordings.listing import describe_recording

TOL_M = 1e-9
AT_ORIGIN = SE2.identity()


def read(path, **options):
    recording = open_recording(path, RecordingOptions(**options))
    return recording, list(recording.events())


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("compression", ["", "message", "file"])
def test_every_storage_and_compression_gives_the_same_scans(tmp_path, storage, compression):
    path = write_bag(tmp_path / "bag", drive(), storage, compression)
    recording, events = read(path)
    assert [e.stamp_ns for e in events] == [START_NS + i * NS // 10 for i in range(5)]
    for i, event in enumerate(events):
        assert event.T_odom_base.x == pytest.approx(0.01 * i, abs=TOL_M)
        assert event.T_base_laser.x == pytest.approx(0.2, abs=TOL_M)
    assert recording.counts.without_transform == 0
    assert recording.problem is None


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_scans_wait_for_the_transform_at_their_stamp(tmp_path, storage):
    messages = drive(3)
    scans = [m for m in messages if m[0] == "/scan"]
    late = [(t, ns + NS, m) for t, ns, m in messages if t == "/tf"]
    rest = [m for m in messages if m[0] == "/tf_static"]
    path = write_bag(tmp_path / "bag", [*rest, *scans, *late], storage)
    recording, events = read(path)
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.0, 0.01, 0.02]
    assert recording.counts.without_transform == 0


def test_scans_come_in_stamp_order_while_they_wait(tmp_path):
    messages = drive(4)
    scans = [i for i, m in enumerate(messages) if m[0] == "/scan"]
    messages[scans[1]], messages[scans[2]] = messages[scans[2]], messages[scans[1]]
    others = [m for m in messages if m[0] != "/scan"]
    in_order = [m for m in messages if m[0] == "/scan"]
    ordered = [(t, START_NS + i, m) for i, (t, _, m) in enumerate([*in_order, *others])]
    recording, events = read(write_bag(tmp_path / "bag", ordered))
    stamps = [e.stamp_ns for e in events]
    assert stamps == sorted(stamps) and len(stamps) == 4
    assert recording.counts.stamps_backwards == 1


def test_a_static_transform_recorded_last_holds_from_the_start(tmp_path):
    static = ("/tf_static", START_NS + 20 * NS, tf_message(transform(0, "base_link", "laser", 0.2)))
    _, events = read(write_bag(tmp_path / "bag", [*drive(3, has_static=False), static]))
    assert [e.T_base_laser.x for e in events] == [0.2] * 3


def test_scans_outside_the_odometry_are_counted_not_guessed(tmp_path):
    messages = drive(3)
    early = ("/scan", START_NS - NS, scan_message(START_NS - NS))
    late = ("/scan", START_NS + 9 * NS, scan_message(START_NS + 9 * NS))
    recording, events = read(write_bag(tmp_path / "bag", [early, *messages, late]))
    assert len(events) == 3
    assert recording.counts.scans == 5
    assert recording.counts.without_transform == 2


def test_a_looped_bag_starts_again_with_fresh_transforms(tmp_path):
    second = [(t, ns + 20 * NS, m) for t, ns, m in drive(3)]
    first = drive(3, start_ns=START_NS + 10 * NS)
    recording, events = read(write_bag(tmp_path / "bag", [*first, *second]))
    assert [e.follows_jump for e in events] == [False, False, False, True, False, False]
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.0, 0.01, 0.02] * 2
    assert recording.counts.jumps == 1


def test_repeated_stamps_are_kept_and_counted(tmp_path):
    messages = drive(3)
    messages.insert(3, ("/scan", START_NS + 2, scan_message(START_NS)))
    recording, events = read(write_bag(tmp_path / "bag", messages))
    assert len(events) == 4
    assert recording.counts.stamps_repeated == 1


def test_zero_nan_inf_and_far_values_mean_what_drivers_mean(tmp_path):
    ranges = [0.0, math.nan, math.inf, 24.8, 0.05, -1.0, 3.0, 10.0]
    messages = drive(1)
    messages[2] = ("/scan", START_NS + 1, scan_message(START_NS, ranges))
    _, events = read(write_bag(tmp_path / "bag", messages))
    expected = [math.nan, math.nan, math.inf, math.inf, -math.inf, math.nan, 3.0, 10.0]
    np.testing.assert_allclose(events[0].scan.ranges, expected)


def test_custom_types_are_passed_over(tmp_path):
    messages = [*drive(2), ("/bump", START_NS + NS, bump_message())]
    path = write_bag(tmp_path / "bag", messages)
    assert len(read(path)[1]) == 2
    assert any("robot_msgs/msg/Bump" in line for line in describe_recording(path, AS_IT_IS))


def test_odometry_topic_is_used_where_no_tf_has_it(tmp_path):
    messages = [m for m in drive(3) if m[0] != "/tf"]
    odom = [("/odom", START_NS + i * NS, odom_message(START_NS + i * NS, 1.0 * i)) for i in (0, 1)]
    recording, events = read(write_bag(tmp_path / "bag", [*messages, *odom]))
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.0, 0.1, 0.2]
    assert any("topic /odom" in line for line in recording.info)


def test_without_odometry_the_user_must_say_so(tmp_path):
    path = write_bag(tmp_path / "bag", [m for m in drive(3) if m[0] != "/tf"])
    with pytest.raises(RecordingError, match="--no-odom"):
        read(path)
    _, events = read(path, use_odom=False)
    assert [e.T_odom_base for e in events] == [None] * 3


def test_without_a_laser_transform_the_user_must_say_where_it_is(tmp_path):
    path = write_bag(tmp_path / "bag", drive(3, has_static=False))
    with pytest.raises(RecordingError, match="--laser-pose"):
        read(path)
    _, events = read(path, laser_pose=SE2(0.3, 0.0, 0.1))
    assert [e.T_base_laser for e in events] == [SE2(0.3, 0.0, 0.1)] * 3


def test_a_bag_without_laser_transform_and_odometry_says_both_at_once(tmp_path):
    path = write_bag(tmp_path / "bag", [m for m in drive(3, has_static=False) if m[0] == "/scan"])
    with pytest.raises(RecordingError, match="--laser-pose X Y YAW.*; and .*--no-odom"):
        read(path)


def test_topics_may_be_named_without_their_slash(tmp_path):
    odom = [("/odom", START_NS + i * NS // 10, odom_message(START_NS + i * NS // 10, 0.0))
            for i in range(4)]  # fmt: skip
    path = write_bag(tmp_path / "bag", [*drive(3), *odom])
    recording, events = read(path, scan_topic="scan", odom_topic="odom")
    assert len(events) == 3 and "scans: /scan, as asked" in recording.info
    with pytest.raises(RecordingError, match="has no topic left"):
        read(path, scan_topic="left")


def test_a_laser_pose_that_overrides_tf_says_what_tf_has(tmp_path):
    path = write_bag(tmp_path / "bag", drive(3))
    recording, events = read(path, laser_pose=SE2(0.3, 0.0, 0.1))
    assert events[0].T_base_laser == SE2(0.3, 0.0, 0.1)
    assert any("TF base_link -> laser: 0.200 0.000 0.0000" in line for line in recording.info)
    path = write_bag(tmp_path / "bare", drive(3, has_static=False))
    recording, _ = read(path, laser_pose=SE2(0.3, 0.0, 0.1))
    assert "laser pose: as given on the command line" in recording.info


def test_a_laser_hung_upside_down_sweeps_the_other_way(tmp_path):
    messages = drive(1)
    down = tf_message(transform(0, "base_link", "laser", 0.2, roll=math.pi))
    messages[0] = ("/tf_static", START_NS, down)
    _, events = read(write_bag(tmp_path / "bag", messages))
    assert events[0].scan.angle_min == pytest.approx(math.pi / 2, abs=1e-6)
    assert events[0].scan.angle_increment < 0.0


def test_several_scan_topics_need_a_choice(tmp_path):
    front = [("/front", ns, m) if t == "/scan" else (t, ns, m) for t, ns, m in drive(2)]
    rear = [("/rear", START_NS + 3, scan_message(START_NS))]
    path = write_bag(tmp_path / "bag", [*front, *rear])
    with pytest.raises(RecordingError, match="--scan-topic /front or /rear"):
        read(path)
    assert len(read(path, scan_topic="/front")[1]) == 2
    with pytest.raises(RecordingError, match="/left"):
        read(path, scan_topic="/left")


def test_a_bag_without_scans_names_its_topics(tmp_path):
    path = write_bag(tmp_path / "bag", [m for m in drive(2) if m[0] == "/tf"])
    with pytest.raises(RecordingError, match=r"no LaserScan.*/tf"):
        read(path)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_metadata_is_not_needed(tmp_path, storage):
    path = write_bag(tmp_path / "bag", drive(3), storage)
    (path / "metadata.yaml").unlink()
    assert len(read(path)[1]) == 3


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_storage_file_of_any_name_is_recognized_by_content(tmp_path, storage):
    path = write_bag(tmp_path / "bag", drive(3), storage)
    (file,) = (f for f in path.iterdir() if f.name != "metadata.yaml")
    assert len(read(file.rename(tmp_path / "recording.data"))[1]) == 3


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_cut_off_bag_is_read_as_far_as_it_goes(tmp_path, storage):
    path = write_bag(tmp_path / "bag", drive(2000), storage)
    (file,) = (f for f in path.iterdir() if f.name != "metadata.yaml")
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    recording, events = read(path)
    assert 100 < len(events) < 2000
    assert "cut off" in recording.problem and "last recorded at" in recording.problem


def test_empty_things_are_one_clear_line(tmp_path):
    (tmp_path / "nothing").mkdir()
    (tmp_path / "zero.mcap").write_bytes(b"")
    (tmp_path / "text.txt").write_text("hello\n")
    for name, expected in (("nothing", "no recording"), ("zero.mcap", "empty"),
                           ("text.txt", "known are"), ("missing", "does not exist")):  # fmt: skip
        with pytest.raises(RecordingError, match=expected) as error:
            read(tmp_path / name)
        assert "\n" not in str(error.value)
    with pytest.raises(RecordingError, match="no LaserScan"):
        read(write_bag(tmp_path / "bag", []))


def test_sonars_come_among_the_scans_in_stamp_order(tmp_path):
    messages = drive(3)
    sonar = tf_message(transform(0, "base_link", "sonar_0", x=0.1, yaw=0.5))
    readings = [
        ("/sonar", START_NS + d, range_message(START_NS + d, value))
        for d, value in ((10, 0.7), (20, 1.5))
    ]
    path = write_bag(
        tmp_path / "bag",
        sorted([("/tf_static", 1, sonar), *messages, *readings], key=lambda m: m[1]),
    )
    assert len(read(path)[1]) == 3
    _, events = read(path, sonar_topics=("/sonar",))
    assert [isinstance(e, RangeEvent) for e in events] == [False, True, True, False, False]
    near, far = events[1], events[2]
    assert (near.frame, near.fov) == ("sonar_0", 0.5)
    assert near.range == pytest.approx(0.7) and far.range == 1.5  # as sent
    assert near.T_base_sonar.yaw == pytest.approx(0.5)


def test_a_sonar_or_scan_without_transform_stops_nothing(tmp_path):
    messages = drive(3)
    lost = ("/scan", START_NS + 5, scan_message(START_NS + 5, frame="nowhere"))
    recording, events = read(write_bag(tmp_path / "a", [*messages[:3], lost, *messages[3:]]))
    assert len(events) == 3 and recording.counts.without_transform == 1
    path = write_bag(
        tmp_path / "b", [*messages, ("/sonar", START_NS, range_message(START_NS, 0.5))]
    )
    with pytest.raises(RecordingError, match="leave out --sonar-topic /sonar"):
        read(path, sonar_topics=("/sonar",))


def test_neato_scans_lose_their_repeated_beam():
    recording, events = read(data_file("rosbag2/neato_wall_follower"))
    assert len(events) == 300
    assert {len(e.scan.ranges) for e in events} == {360}
    assert 0.30 < np.mean([e.scan.is_hit.mean() for e in events]) < 0.36
    assert not any((e.scan.ranges == 0.0).any() for e in events)


@pytest.mark.parametrize(
    ("name", "num_scans", "num_left_out", "way"),
    [("olin_mac_floor1", 357, 1, 8.4), ("pioneer_trace0", 958, 1, 31.7),
     ("neato_drive_square", 152, 1, 1.5), ("neato_wall_follower", 300, 0, 6.0)],
)  # fmt: skip
def test_real_bags_lose_only_scans_beyond_their_odometry(name, num_scans, num_left_out, way):
    recording, events = read(data_file(f"rosbag2/{name}"))
    poses = [e.T_odom_base for e in events]
    length = sum(a.between(b).distance for a, b in zip(poses, poses[1:], strict=False))
    assert recording.counts.scans == num_scans
    assert recording.counts.without_transform == num_left_out
    assert len(events) == num_scans - num_left_out
    assert length == pytest.approx(way, abs=0.15)


def test_a_ros1_bag_is_read():
    path = data_file("tiago-sonar-lidar/scan_lidar.bag")
    _, events = read(path, use_odom=False, laser_pose=AT_ORIGIN)
    assert len(events) == 274


def test_a_cut_off_ros1_bag_is_read_as_far_as_it_goes(tmp_path):
    content = data_file("tiago-sonar-lidar/scan_lidar.bag").read_bytes()
    (tmp_path / "cut.bag").write_bytes(content[:400_000])
    recording, events = read(tmp_path / "cut.bag", use_odom=False, laser_pose=AT_ORIGIN)
    assert len(events) == 163
    assert "cut off" in recording.problem


AS_IT_IS = RecordingOptions()
