"""What the relay of the faults does to messages."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: there are no messages")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from geometry_msgs.msg import TransformStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import CameraInfo, LaserScan  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

from experiments.faults_changes import (  # noqa: E402
    Freeze,
    Lossy,
    Often,
    black,
    drop,
    half_size,
    no_numbers,
    no_ranges,
    saturated,
    shift_stamps,
    upside_down,
)
from floornav_common.ros.messages import (  # noqa: E402
    array_to_image,
    image_to_array,
    ns_to_stamp,
    stamp_to_ns,
)

S = 1_000_000_000


def scan_of(stamp_ns: int, first: float = 1.0) -> LaserScan:
    msg = LaserScan(ranges=[first, 2.0, 3.0], angle_increment=0.1)
    msg.header.stamp = ns_to_stamp(stamp_ns)
    return msg


def stamp_of(msg: LaserScan) -> int:
    return stamp_to_ns(msg.header.stamp)


def test_dropping_sends_nothing() -> None:
    assert drop(scan_of(S), S) == []


def test_a_frozen_sensor_repeats_the_first_with_its_stamp_or_with_new_ones() -> None:
    for keeps_stamp, stamps in ((True, [S, S]), (False, [S, 2 * S])):
        freeze = Freeze(keeps_stamp=keeps_stamp)
        sent = [freeze(scan_of(k * S, float(k)), 0)[0][1] for k in (1, 2)]
        assert [msg.ranges[0] for msg in sent] == [1.0, 1.0]
        assert [stamp_of(msg) for msg in sent] == stamps


def test_a_lossy_way_loses_its_share_and_delays_the_rest() -> None:
    lossy = Lossy(0.3, 200_000_000, np.random.default_rng(0))
    sent = [lossy(scan_of(S), S) for _ in range(2000)]
    assert np.mean([not each for each in sent]) == pytest.approx(0.3, abs=0.03)
    assert {delay for each in sent for delay, _ in each} == {200_000_000}


def test_ten_times_as_many_have_stamps_of_their_own_up_to_the_true_one() -> None:
    sent = [msg for _, msg in Often(10, 100_000_000)(scan_of(S), S)]
    assert [stamp_of(msg) for msg in sent] == [S - k * 10_000_000 for k in range(9, -1, -1)]


@pytest.mark.parametrize("kind", [LaserScan, Odometry, TransformStamped, CameraInfo])
def test_no_float_of_a_message_stays_a_number(kind: type) -> None:
    msg = kind()
    if kind is LaserScan:
        msg.ranges = [1.0, 2.0]
    no_numbers(msg)
    assert floats_of(msg) and all(map(math.isnan, floats_of(msg)))


def floats_of(msg: object) -> list[float]:
    found: list[float] = []
    for name in msg.get_fields_and_field_types():
        value = getattr(msg, name)
        if hasattr(value, "get_fields_and_field_types"):
            found += floats_of(value)
        elif isinstance(value, float):
            found.append(value)
        elif not isinstance(value, str | int) and len(value) and isinstance(value[0], float):
            found += list(value)
    return found


def test_no_transform_of_a_list_stays_a_number() -> None:
    msg = TFMessage(transforms=[TransformStamped(), TransformStamped()])
    no_numbers(msg)
    assert all(math.isnan(each.transform.translation.x) for each in msg.transforms)


def test_ranges_alone_are_taken_away() -> None:
    msg = scan_of(S)
    no_ranges(msg)
    assert all(map(math.isnan, msg.ranges)) and msg.angle_increment == pytest.approx(0.1)


def test_stamps_move_wherever_they_are_and_not_below_zero() -> None:
    clock, tf = Clock(clock=ns_to_stamp(7 * S)), TFMessage(transforms=[TransformStamped()])
    tf.transforms[0].header.stamp = ns_to_stamp(3 * S)
    shift_stamps(clock, -5 * S)
    shift_stamps(tf, -5 * S)
    assert stamp_to_ns(clock.clock) == 2 * S
    assert stamp_to_ns(tf.transforms[0].header.stamp) == 0


def test_images_go_black_white_upside_down_and_small() -> None:
    pixels = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)

    def through(change: object) -> np.ndarray:
        msg = array_to_image(pixels, "rgb8", ns_to_stamp(S), "camera")
        return image_to_array(change(msg, 0)[0][1], "rgb8")

    assert not through(black).any() and (through(saturated) == 255).all()
    assert np.array_equal(through(upside_down), pixels[::-1, ::-1])
    assert np.array_equal(through(half_size), pixels[::2, ::2])
