"""Messages and back, and that nothing goes through them element by element."""

from __future__ import annotations

import array
import os
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from floornav_common.grid import OccupancyMap
from floornav_common.readings import OdometryReading, RangeReading
from floornav_common.ros import messages
from floornav_common.ros.arrays import from_field, to_field
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

pytest.importorskip("sensor_msgs.msg", reason="no ROS messages")
from builtin_interfaces.msg import Time  # noqa: E402
from sensor_msgs.msg import Image, LaserScan  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

STAMP = Time(sec=12, nanosec=345)
TOL = 1e-6  # float32 fields


def picture(num_channels: int, height: int = 5, width: int = 7) -> np.ndarray:
    shape = (height, width) if num_channels == 1 else (height, width, num_channels)
    return np.random.default_rng(0).integers(0, 256, shape, dtype=np.uint8)


ENCODINGS = [("mono8", 1), ("bgr8", 3), ("rgb8", 3), ("bgra8", 4)]


@pytest.mark.parametrize(("encoding", "num_channels"), ENCODINGS)
def test_images_survive_the_round_trip_without_a_copy_back(
    encoding: str, num_channels: int
) -> None:
    pixels = picture(num_channels)
    msg = messages.array_to_image(pixels, encoding, STAMP, "camera")
    assert (msg.height, msg.width, msg.step) == (5, 7, 7 * num_channels)
    assert (msg.header.stamp, msg.header.frame_id) == (STAMP, "camera")
    back = messages.image_to_array(msg)
    assert np.array_equal(back, pixels)
    assert np.shares_memory(back, np.frombuffer(msg.data, np.uint8))
    assert not back.flags.writeable


@pytest.mark.parametrize(("encoding", "num_channels"), ENCODINGS)
def test_padded_rows_are_cut(encoding: str, num_channels: int) -> None:
    pixels = picture(num_channels)
    rows = np.zeros((5, 40), np.uint8)
    rows[:, : 7 * num_channels] = pixels.reshape(5, -1)
    msg = Image(height=5, width=7, step=40, encoding=encoding, data=rows.tobytes())
    assert np.array_equal(messages.image_to_array(msg), pixels)


def test_parts_of_a_larger_picture_are_written_right() -> None:
    part = picture(3, 20, 20)[3:8, 2:9]
    msg = messages.array_to_image(part, "bgr8", STAMP, "camera")
    assert np.array_equal(messages.image_to_array(msg), part)


def test_colors_are_reordered_when_asked_for() -> None:
    pixels = picture(3)
    msg = messages.array_to_image(pixels, "rgb8", STAMP, "camera")
    assert np.array_equal(messages.image_to_array(msg, "bgr8"), pixels[..., ::-1])
    bgra = messages.array_to_image(picture(4), "bgra8", STAMP, "camera")
    assert np.array_equal(messages.image_to_array(bgra, "rgb8"), picture(4)[..., 2::-1])
    assert messages.image_to_array(bgra, "mono8").shape == (5, 7)


def bad_image(**changed: Any) -> Image:
    good = dict(height=2, width=3, step=9, encoding="bgr8", data=bytes(18), is_bigendian=0)
    return Image(**{**good, **changed})


@pytest.mark.parametrize(
    ("msg", "said"),
    [
        (bad_image(encoding="mono16"), "encoding must be one of .* got 'mono16'"),
        (bad_image(encoding="16UC1", is_bigendian=1), "got '16UC1'"),
        (bad_image(encoding=""), "encoding must be one of"),
        (bad_image(is_bigendian=1), "little-endian, got big-endian 'bgr8'"),
        (bad_image(step=8), "step must be >= 9 bytes, got 8"),
        (bad_image(data=bytes(17)), "data must be 18 bytes, got 17"),
        (bad_image(data=b""), "data must be 18 bytes, got 0"),
        (bad_image(height=0, data=b""), "must not be empty, got 3 x 0"),
    ],
)
def test_bad_images_are_refused_by_what_is_wrong(msg: Image, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        messages.image_to_array(msg)


@pytest.mark.parametrize(
    ("pixels", "encoding"),
    [(picture(3), "mono8"), (picture(1), "bgr8"), (picture(3).astype(float), "bgr8")],
)
def test_pixels_that_do_not_fit_their_encoding_are_refused(
    pixels: np.ndarray, encoding: str
) -> None:
    with pytest.raises(ValueError, match=f"must be {encoding} uint8"):
        messages.array_to_image(pixels, encoding, STAMP, "camera")


def test_png_keeps_every_pixel_and_jpeg_nearly() -> None:
    smooth = np.full((16, 16, 3), (200, 100, 50), np.uint8)
    png = messages.array_to_compressed(smooth, "bgr8", STAMP, "camera", quality=None)
    jpeg = messages.array_to_compressed(smooth, "bgr8", STAMP, "camera")
    assert np.array_equal(messages.compressed_to_array(png, "rgb8"), smooth[..., ::-1])
    difference = messages.compressed_to_array(jpeg).astype(int) - smooth
    assert np.abs(difference).max() <= 4
    assert jpeg.format == "bgr8; jpeg compressed bgr8" and isinstance(jpeg.data, array.array)


def test_broken_compressed_images_are_refused() -> None:
    for data, said in ((b"", "must not be empty"), (b"no picture", "cannot be decoded")):
        with pytest.raises(ValueError, match=said):
            messages.compressed_to_array(SimpleNamespace(format="jpeg", data=data))


def test_scans_survive_the_round_trip() -> None:
    ranges = np.array([1.0, np.inf, -np.inf, np.nan, 0.0])
    scan = Scan(ranges, -0.2, 0.1, 0.05, 30.0, 1e-4)
    msg = messages.scan_to_msg(scan, Header(stamp=STAMP, frame_id="laser"), scan_time=0.1)
    assert msg.angle_max == pytest.approx(0.2, abs=TOL)
    back = messages.scan_from_msg(msg)
    assert np.array_equal(back.ranges, ranges, equal_nan=True)
    assert back.angle_increment == pytest.approx(0.1, abs=TOL)
    assert back.range_max == 30.0 and back.time_increment == pytest.approx(1e-4, abs=TOL)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"ranges": []}, "must have beams"),
        ({"angle_increment": 0.0}, "angle_increment must not be 0"),
        ({"angle_increment": 0.0, "ranges": [1.0]}, "angle_increment must not be 0"),
        ({"range_max": float("nan")}, "range_max must be a number"),
        ({"range_min": float("inf")}, "range_min must be finite, got inf"),
        ({"angle_min": float("-inf")}, "angle_min must be finite, got -inf"),
        ({"angle_increment": float("inf")}, "angle_increment must be finite, got inf"),
        ({"angle_increment": float("nan")}, "angle_increment must be finite, got nan"),
        ({"range_min": 9.5}, "range_min 9.5 must be <= range_max 9.0"),
        ({"angle_increment": -7.0}, "at most 6.91 rad, got 2 beams -7.0 rad apart"),
        ({"ranges": [1.0] * 400, "angle_increment": 0.0175}, "6.98 rad"),
    ],
)
def test_scans_that_mean_nothing_are_refused(changed: dict[str, Any], said: str) -> None:
    msg = LaserScan(**{"angle_increment": 0.1, "range_max": 9.0, "ranges": [1.0, 2.0], **changed})
    with pytest.raises(ValueError, match=said):
        messages.scan_from_msg(msg)


def test_scans_of_unbounded_range_or_a_little_over_once_round_are_taken() -> None:
    msg = LaserScan(angle_increment=0.0175, range_max=float("inf"), ranges=[1.0] * 380)
    scan = messages.scan_from_msg(msg)
    assert len(scan.ranges) == 380 and scan.range_max == float("inf")
    single = LaserScan(angle_increment=0.1, range_max=9.0, ranges=[1.0])
    assert len(messages.scan_from_msg(single).ranges) == 1


def test_grids_survive_the_round_trip_without_a_copy_back() -> None:
    cells = np.arange(-1, 11, dtype=np.int8).reshape(3, 4)
    grid = OccupancyMap(cells, 0.05, SE2(-1.0, 2.0, 0.5))
    msg = messages.grid_to_msg(grid, STAMP, "map")
    assert (msg.info.height, msg.info.width, msg.header.frame_id) == (3, 4, "map")
    back = messages.grid_from_msg(msg)
    assert np.array_equal(back.cells, cells) and back.cells.dtype == np.int8
    assert np.shares_memory(back.cells, np.frombuffer(msg.data, np.int8))
    assert back.origin.as_array() == pytest.approx([-1.0, 2.0, 0.5])
    msg.info.width = 5
    with pytest.raises(ValueError, match="5 x 3 cells, got 12"):
        messages.grid_from_msg(msg)


def test_odometry_ranges_poses_and_transforms_survive_the_round_trip() -> None:
    cov = np.arange(9.0).reshape(3, 3)
    odometry = OdometryReading(SE2(1.0, 2.0, 3.0), (0.5, 0.0, -0.1), cov, 2.0 * cov)
    msg = messages.odometry_to_msg(odometry, STAMP, "odom", "base_link")
    back = messages.odometry_from_msg(msg)
    assert back.T_odom_base.as_array() == pytest.approx([1.0, 2.0, 3.0])
    assert back.twist == (0.5, 0.0, -0.1)
    assert np.array_equal(back.pose_cov, cov) and np.array_equal(back.twist_cov, 2.0 * cov)
    reading = RangeReading(1.5, 0.25, 0.5, 4.0)
    assert messages.range_from_msg(messages.range_to_msg(reading, STAMP, "sonar_0")) == reading
    poses = [SE2(1.0, 2.0, -3.0), SE2(0.0, 0.0, 0.0)]
    (first, second) = messages.poses_from_msg(messages.poses_to_msg(poses, STAMP, "map"))
    assert first.as_array() == pytest.approx(poses[0].as_array())
    assert second.as_array() == pytest.approx(poses[1].as_array())
    assert messages.poses_from_msg(messages.poses_to_msg([], STAMP, "map")) == []
    T_a_b = Transform3.from_parts((1.0, 2.0, 3.0), (0.5, 0.5, 0.5, 0.5))
    T_back = messages.transform_from_msg(messages.transform_to_msg(T_a_b))
    assert np.allclose(T_back.matrix(), T_a_b.matrix())


def test_planar_covariance_stands_at_x_y_and_yaw_of_the_36() -> None:
    full = messages.se2_cov_to_ros(np.arange(1.0, 10.0).reshape(3, 3))
    assert [full[i] for i in (0, 1, 5, 6, 7, 11, 30, 31, 35)] == list(range(1, 10))
    assert np.count_nonzero(full) == 9
    with pytest.raises(ValueError, match=r"\(3, 3\)"):
        messages.se2_cov_to_ros(np.full((3, 3), np.nan))


@pytest.mark.parametrize("stamp_ns", [0, 1, 999_999_999, 1_700_000_000_123_456_789])
def test_stamps_survive_the_round_trip(stamp_ns: int) -> None:
    assert messages.stamp_to_ns(messages.ns_to_stamp(stamp_ns)) == stamp_ns


class NoElements(array.array):  # type: ignore[type-arg]
    """A message field that may be taken whole, but not element by element."""

    def __iter__(self) -> Any:
        raise AssertionError("read element by element")

    __getitem__ = tolist = __iter__  # type: ignore[assignment]


class NoElementsArray(np.ndarray):
    """Pixels that may be taken whole, but not element by element."""

    def __iter__(self) -> Any:
        raise AssertionError("written element by element")

    tolist = __iter__  # type: ignore[assignment]


def test_reading_takes_fields_whole() -> None:
    image = bad_image()
    image._data = NoElements("B", bytes(18))
    assert messages.image_to_array(image).shape == (2, 3, 3)
    scan = LaserScan(angle_increment=0.1, range_max=9.0)
    scan._ranges = NoElements("f", [1.0, 2.0])
    assert len(messages.scan_from_msg(scan).ranges) == 2


def test_writing_hands_over_one_array_of_the_right_type_code(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    handed: list[Any] = []

    def record(values: np.ndarray) -> Any:
        handed.append(to_field(values.view(NoElementsArray)))
        return handed[-1]

    monkeypatch.setattr(messages, "to_field", record)
    monkeypatch.setattr("floornav_common.ros.images.to_field", record)
    # Checking setters keep the very array they are given; ours of large messages always check.
    monkeypatch.setattr("sensor_msgs.msg._laser_scan.ros_python_check_fields", "1")
    image = messages.array_to_image(picture(3), "bgr8", STAMP, "camera")
    scan = messages.scan_to_msg(Scan(np.ones(3), 0.0, 0.1, 0.0, 9.0), Header())
    grid = messages.grid_to_msg(
        OccupancyMap(np.zeros((2, 2), np.int8), 0.1, SE2.identity()), STAMP, "map"
    )
    fields = [image.data, scan.ranges, grid.data]
    assert [f.typecode for f in fields] == ["B", "f", "b"]
    assert all(field is given for field, given in zip(fields, handed, strict=True))


def test_everything_passes_under_field_checks_of_rclpy() -> None:
    code = "import pytest, sys; sys.exit(pytest.main(['-q', sys.argv[1], '-k', 'round_trip']))"
    env = {**os.environ, "ROS_PYTHON_CHECK_FIELDS": "1"}
    words = [sys.executable, "-c", code, __file__]
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


def test_messages_of_rosbags_are_read_as_well() -> None:
    typesys = pytest.importorskip("rosbags.typesys")
    types = typesys.get_typestore(typesys.Stores.ROS2_JAZZY).types
    header = types["std_msgs/msg/Header"](
        types["builtin_interfaces/msg/Time"](sec=1, nanosec=2), "laser"
    )
    scan = types["sensor_msgs/msg/LaserScan"](
        header, 0.0, 0.1, 0.1, 0.0, 0.0, 0.1, 9.0,
        np.array([1.0, 2.0], np.float32), np.zeros(0, np.float32),
    )  # fmt: skip
    assert messages.scan_from_msg(scan).ranges.tolist() == [1.0, 2.0]
    pixels = picture(3)
    image = types["sensor_msgs/msg/Image"](header, 5, 7, "bgr8", 0, 21, pixels.reshape(-1))
    assert np.array_equal(messages.image_to_array(image), pixels)
    assert np.shares_memory(messages.image_to_array(image), pixels)
    assert messages.stamp_to_ns(image.header.stamp) == 1_000_000_002


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "int32", "float32", "float64"])
def test_fields_survive_the_round_trip_at_every_size(dtype: str) -> None:
    for size in (0, 1, 5):
        values = np.arange(size).astype(dtype)
        assert np.array_equal(from_field(to_field(values), values.dtype.type), values)
    assert np.array_equal(from_field([1, 2], np.int8), [1, 2])
    with pytest.raises(ValueError, match="dtype must be one of"):
        to_field(np.zeros(2, complex))
