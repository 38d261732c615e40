"""Other robots' bags: their frames, clocks and scans. What is certain is done and said."""

import copy
import math

import numpy as np
import pytest
from recording_builders import (
    NS,
    START_NS,
    STORE,
    drive,
    header,
    odom_message,
    scan_message,
    stamp,
    tf_message,
    transform,
    write_bag,
)

from floornav_common.se2 import SE2
from grid_mapper.recordings import RecordingError, RecordingOptions, open_recording
from grid_mapper.recordings.robot_description import fixed_transforms, quat_of_rpy

TOL_M = 1e-6
STEP_NS = NS // 10
URDF = """<robot name="r"><joint name="a" type="fixed"><parent link="base_link"/>
<child link="tower"/><origin xyz="0.1 0 0.3" rpy="0 0 1.5707963"/></joint>
<joint name="b" type="fixed"><parent link="tower"/><child link="laser"/>
<origin xyz="0.05 0 0"/></joint><joint name="w" type="continuous"><parent link="base_link"/>
<child link="wheel"/></joint></robot>"""


def read(tmp_path, messages, **options):
    bag = tmp_path / "bag"
    bag = bag if bag.exists() else write_bag(bag, messages)
    recording = open_recording(bag, RecordingOptions(**options))
    return recording, list(recording.events())


def refused(tmp_path, messages, match, **options):
    with pytest.raises(RecordingError, match=match) as error:
        read(tmp_path, messages, **options)
    assert "\n" not in str(error.value)


def renamed(messages, names):
    """Return the messages with other frame ids."""
    out = copy.deepcopy(messages)
    for _, _, message in out:
        for part in getattr(message, "transforms", [message]):
            part.header.frame_id = names.get(part.header.frame_id, part.header.frame_id)
            if hasattr(part, "child_frame_id"):
                part.child_frame_id = names.get(part.child_frame_id, part.child_frame_id)
    return out


def scans_with(messages, **values):
    out = copy.deepcopy(messages)
    for message in (m for topic, _, m in out if topic == "/scan"):
        for name, value in values.items():
            setattr(message, name, value)
    return out


def scans_stamped(messages, stamp_of):
    out = copy.deepcopy(messages)
    for topic, recorded_ns, message in out:
        if topic == "/scan":
            message.header.stamp = stamp(stamp_of(recorded_ns - 1))
    return out


def odometry(child="base_link", topic="/odom", num=9):
    times = [START_NS + (i - 1) * STEP_NS for i in range(num)]
    return [(topic, t, odom_message(t, 0.1 * i, child)) for i, t in enumerate(times)]


def without_tf(messages):
    return [m for m in messages if m[0] != "/tf"]


@pytest.mark.parametrize(
    ("names", "base", "odom"),
    [({"base_link": "base_footprint"}, "base_footprint", "odom"),
     ({k: f"tb3_0/{k}" for k in ("odom", "base_link", "laser")}, "tb3_0/base_link", "tb3_0/odom"),
     ({k: f"/{k}" for k in ("odom", "base_link", "laser")}, "base_link", "odom"),
     ({"base_link": "chassis", "odom": "odom_combined"}, "chassis", "odom_combined")],
)  # fmt: skip
def test_the_robots_own_frames_are_found_and_named(tmp_path, names, base, odom):
    recording, events = read(tmp_path, renamed(drive(), names))
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.0, 0.01, 0.02, 0.03, 0.04]
    assert f"odometry: TF {odom} -> {base}" in recording.info
    is_usual = base == "base_link"
    assert any(line.startswith(f"robot frame: {base}, ") for line in recording.info) != is_usual


def test_a_frame_that_was_asked_for_is_never_replaced(tmp_path):
    messages = renamed(drive(), {"base_link": "base_footprint"})
    refused(tmp_path, messages, "no transform from base_link to laser", base_frame="base_link")


def test_base_link_below_base_footprint_is_the_robot(tmp_path):
    messages = renamed(drive(), {"base_link": "base_footprint"})
    messages[0] = ("/tf_static", START_NS, tf_message(
        transform(0, "base_footprint", "base_link", x=0.05), transform(0, "base_link", "laser", 0.2)
    ))  # fmt: skip
    _, events = read(tmp_path, messages)
    assert events[1].T_odom_base.x == pytest.approx(0.06, abs=TOL_M)
    assert events[1].T_base_laser.x == pytest.approx(0.2, abs=TOL_M)


def test_odometry_of_another_frame_of_the_robot_is_carried_over(tmp_path):
    footprint = ("/tf_static", 1, tf_message(transform(0, "base_footprint", "base_link", x=0.05)))
    messages = [footprint, *without_tf(drive()), *odometry("base_footprint")]
    _, events = read(tmp_path, messages)
    assert [round(e.T_odom_base.x, 6) for e in events] == [0.15, 0.25, 0.35, 0.45, 0.55]


@pytest.mark.parametrize("child", ["", "base_footprint"])
def test_odometry_of_an_unknown_frame_is_taken_for_the_robots_and_that_is_said(tmp_path, child):
    recording, events = read(tmp_path, [*without_tf(drive()), *odometry(child)])
    assert len(events) == 5
    assert any("taken as base_link: no transform" in line for line in recording.info)


def test_several_odometry_topics_need_a_choice_unless_one_is_odom(tmp_path):
    two = [*odometry(topic="/a/odom"), *odometry(topic="/b/odom")]
    refused(tmp_path / "a", [*without_tf(drive()), *two], "--odom-topic /a/odom or /b/odom")
    named = [*odometry(), *odometry(topic="/odometry/filtered")]
    recording, _ = read(tmp_path / "b", [*without_tf(drive()), *named])
    assert any("not /odometry/filtered" in line for line in recording.info)


def test_a_static_stand_in_is_no_odometry(tmp_path):
    still = ("/tf_static", 1, tf_message(transform(0, "odom", "base_link")))
    messages = [still, *without_tf(drive())]
    refused(tmp_path, messages, "no moving transform from odom to base_link.*--no-odom")


def test_a_pose_in_the_map_is_only_odometry_if_the_user_says_so(tmp_path):
    messages = renamed(drive(), {"odom": "map"})
    refused(tmp_path, messages, "--odom-frame map")
    assert len(read(tmp_path, messages, odom_frame="map")[1]) == 5


def test_a_laser_sent_as_moving_but_always_the_same_is_static(tmp_path):
    once = [("/tf", ns, m) if topic == "/tf_static" else (topic, ns, m) for topic, ns, m in drive()]
    recording, events = read(tmp_path, once)
    assert len(events) == 5 and recording.counts.without_transform == 0
    assert any("always the same: taken as static" in line for line in recording.info)


def test_a_laser_that_does_move_is_followed(tmp_path):
    messages = drive(5, has_static=False)
    turning = [
        ("/tf", t, tf_message(transform(t, "base_link", "laser", yaw=(t - START_NS) / NS)))
        for t in range(START_NS - STEP_NS, START_NS + NS, STEP_NS)
    ]
    _, events = read(tmp_path, [*messages, *turning])
    assert [round(e.T_base_laser.yaw, 3) for e in events] == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_a_robot_description_tells_where_the_laser_is(tmp_path):
    text = STORE.types["std_msgs/msg/String"](URDF)
    messages = [("/robot_description", START_NS, text), *drive(has_static=False)]
    recording, events = read(tmp_path, messages)
    pose = events[0].T_base_laser
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.1, 0.05, math.pi / 2), abs=TOL_M)
    assert any("robot_description" in line for line in recording.info)


def test_a_robot_description_that_is_none_gives_nothing():
    assert fixed_transforms("<robot>") == []
    assert fixed_transforms("not xml") == []
    assert fixed_transforms(URDF.replace("0.1 0 0.3", "0.1 0")) == []
    np.testing.assert_allclose(quat_of_rpy(math.pi, 0, 0), (1, 0, 0, 0), atol=1e-12)
    np.testing.assert_allclose(quat_of_rpy(0, 0, math.pi), (0, 0, 1, 0), atol=1e-12)


def test_scans_without_a_frame_need_a_laser_pose(tmp_path):
    messages = scans_stamped(renamed(drive(), {"laser": ""}), lambda ns: ns)
    messages = [m for m in messages if m[0] != "/tf_static"]
    refused(tmp_path, messages, "name no frame_id.*--laser-pose")
    assert len(read(tmp_path, messages, laser_pose=SE2.identity())[1]) == 5


def test_scans_in_the_robots_own_frame_need_no_transform(tmp_path):
    messages = [m for m in renamed(drive(), {"laser": "base_link"}) if m[0] != "/tf_static"]
    _, events = read(tmp_path, messages)
    assert [e.T_base_laser for e in events] == [SE2.identity()] * 5


def test_a_laser_at_a_tilt_is_refused_before_anything_is_mapped(tmp_path):
    messages = drive()
    tilted = tf_message(transform(0, "base_link", "laser", roll=0.7))
    messages[0] = ("/tf_static", START_NS, tilted)
    refused(tmp_path, messages, "tilted by 0.70 rad.*--laser-pose")


@pytest.mark.parametrize("offset_s", [18_000, -900])
def test_scans_of_another_clock_are_one_clear_error_with_a_cure(tmp_path, offset_s):
    messages = scans_stamped(drive(30), lambda ns: ns + offset_s * NS)
    refused(tmp_path, messages, "two clocks.*--recorded-stamps.*--no-odom")
    recording, events = read(tmp_path, messages, use_recorded_stamps=True)
    assert len(events) == 30 and recording.counts.without_transform == 0
    assert events[10].T_odom_base.x == pytest.approx(0.1, abs=1e-4)
    assert events[10].stamp_ns == START_NS + NS + 1


def test_clocks_that_are_apart_but_overlap_are_pointed_out(tmp_path):
    recording, _ = read(tmp_path, scans_stamped(drive(100), lambda ns: ns - 5 * NS))
    assert any("5.0 s behind the odometry" in line for line in recording.info)
    recording, _ = read(tmp_path / "same", drive(100))
    assert not any("behind" in line for line in recording.info)


@pytest.mark.parametrize("speed", [0.2, 4.0, 30.0])
def test_the_speed_of_the_recorders_clock_is_no_second_clock(tmp_path, speed):
    messages = [(t, START_NS + round((ns - START_NS) / speed), m) for t, ns, m in drive(400)]
    recording, _ = read(tmp_path, messages)
    assert not any("clocks" in line for line in recording.info)


def test_scans_recorded_in_a_burst_behind_their_odometry_are_no_second_clock(tmp_path):
    messages = drive(100)
    late = [(t, START_NS + 20 * NS + i, m) for i, (t, _, m) in enumerate(messages) if t == "/scan"]
    recording, _ = read(tmp_path, [m for m in messages if m[0] != "/scan"] + late)
    assert not any("clocks" in line for line in recording.info)


def test_scans_stamped_zero_are_never_taken_as_newest(tmp_path):
    messages = scans_stamped(drive(), lambda ns: 0)
    refused(tmp_path, messages, "stamped 0.*--recorded-stamps")
    assert len(read(tmp_path, messages, use_recorded_stamps=True)[1]) == 5


def test_a_single_zero_stamp_is_left_out_and_is_no_jump(tmp_path):
    messages = scans_stamped(drive(), lambda ns: 0 if ns == START_NS + 2 * STEP_NS else ns)
    recording, events = read(tmp_path, messages)
    assert len(events) == 4 and not any(e.follows_jump for e in events)
    assert (recording.counts.scans, recording.counts.malformed) == (5, 1)


def test_no_odometry_is_made_up_in_a_long_gap(tmp_path):
    for name, source in (
        ("tf", drive(300)),
        ("topic", [*without_tf(drive(300)), *odometry(num=302)]),
    ):
        lost = [m for m in source if m[0] in ("/scan", "/tf_static")
                or not START_NS + 5 * NS < m[1] < START_NS + 20 * NS]  # fmt: skip
        recording, events = read(tmp_path / name, lost)
        assert recording.counts.without_transform in range(148, 153)
        assert len(events) + recording.counts.without_transform == 300


def test_a_frame_that_stops_being_sent_does_not_hold_up_the_rest(tmp_path):
    messages = drive(300)
    second = [
        ("/tf", START_NS + i, tf_message(transform(START_NS + i, "base_link", "rear", yaw=i / NS)))
        for i in range(0, NS, STEP_NS)
    ]
    late = ("/scan", START_NS + 5 * NS, scan_message(START_NS + 5 * NS, frame="rear"))
    ordered = sorted([*messages, *second, late], key=lambda m: m[1])
    recording, events = read(tmp_path, ordered)
    assert len(events) == 300 and recording.counts.without_transform == 1


@pytest.mark.parametrize(
    ("low", "high"), [(5.0, 1.0), (0.1, 0.0), (0.1, math.nan), (math.nan, 9.0)]
)
def test_limits_that_leave_no_range_must_be_said(tmp_path, low, high):
    messages = scans_with(drive(), range_min=low, range_max=high)
    refused(tmp_path, messages, "--range-limits MIN MAX")
    _, events = read(tmp_path, messages, range_limits_m=(0.1, 10.0))
    assert events[0].scan.range_max == 10.0 and events[0].scan.is_hit.all()


def test_an_increment_that_cannot_be_comes_from_the_limits(tmp_path):
    for name, increment in (("zero", 0.0), ("nan", math.nan), ("degrees", 45.0)):
        recording, events = read(tmp_path / name, scans_with(drive(), angle_increment=increment))
        assert events[0].scan.angle_increment == pytest.approx(math.pi / 7)
        assert any("angle_increment" in line for line in recording.info)


def test_an_increment_that_does_not_fit_the_limits_is_taken_and_that_is_said(tmp_path):
    recording, events = read(tmp_path, scans_with(drive(), angle_increment=0.1))
    assert events[0].scan.angle_increment == pytest.approx(0.1)
    assert any("angle_increment is taken" in line for line in recording.info)


def test_scans_without_ranges_are_passed_over(tmp_path):
    messages = scans_with(drive(), ranges=np.zeros(0, np.float32))
    refused(tmp_path / "all", messages, "holds a scan that can be read")
    some = [*messages[:3], *drive()[3:]]
    recording, events = read(tmp_path / "some", some)
    assert len(events) == 4 and recording.counts.malformed == 1


def test_multi_echo_scans_are_passed_over_and_named(tmp_path):
    t = STORE.types
    echo = t["sensor_msgs/msg/LaserEcho"](np.ones(2, np.float32))
    scan = t["sensor_msgs/msg/MultiEchoLaserScan"](
        header(START_NS, "laser"), -1.5, 1.5, 0.1, 0.0, 0.1, 0.1, 10.0, [echo], []
    )
    only = [m for m in drive() if m[0] != "/scan"]
    refused(tmp_path / "only", [*only, ("/echoes", START_NS, scan)], "passed over: /echoes")
    recording, events = read(tmp_path / "too", [*drive(), ("/echoes", START_NS, scan)])
    assert len(events) == 5 and any("/echoes" in line for line in recording.info)
