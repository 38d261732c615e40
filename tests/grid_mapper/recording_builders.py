"""Small recordings for the tests, written by the same library that robots' bags are read with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg("uint8 left\nuint8 right\n", "robot_msgs/msg/Bump"))
DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
NS = 1_000_000_000
ROS1_STORE = get_typestore(Stores.ROS1_NOETIC)
ROS1_STORE.register(
    get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", "tf2_msgs/msg/TFMessage")
)
START_NS = 1_000 * NS
NUM_BEAMS = 8
MSG = "sensor_msgs/msg/LaserScan"


def data_file(name: str) -> Path:
    """Return a real recording, or skip the test where they are not beside the checkout."""
    path = DATA / name
    if not path.exists():
        pytest.skip(f"needs the recording ../shared/data/{name}, which is not there")
    return path


def stamp(stamp_ns: int):
    return STORE.types["builtin_interfaces/msg/Time"](stamp_ns // NS, stamp_ns % NS)


def header(stamp_ns: int, frame: str):
    return STORE.types["std_msgs/msg/Header"](stamp(stamp_ns), frame)


def scan_message(stamp_ns: int, ranges: Sequence[float] | None = None, frame: str = "laser"):
    values = np.full(NUM_BEAMS, 2.0) if ranges is None else np.array(ranges)
    return STORE.types[MSG](
        header=header(stamp_ns, frame),
        angle_min=-math.pi / 2,
        angle_max=math.pi / 2,
        angle_increment=math.pi / NUM_BEAMS,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.1,
        range_max=10.0,
        ranges=values.astype(np.float32),
        intensities=np.zeros(0, np.float32),
    )


def transform(stamp_ns: int, parent: str, child: str, x: float = 0.0, yaw: float = 0.0, roll=0.0):
    t = STORE.types
    q = (math.sin(roll / 2), 0.0, math.sin(yaw / 2), math.cos(roll / 2) * math.cos(yaw / 2))
    return t["geometry_msgs/msg/TransformStamped"](
        header(stamp_ns, parent),
        child,
        t["geometry_msgs/msg/Transform"](
            t["geometry_msgs/msg/Vector3"](x, 0.0, 0.0), t["geometry_msgs/msg/Quaternion"](*q)
        ),
    )


def tf_message(*transforms):
    return STORE.types["tf2_msgs/msg/TFMessage"](list(transforms))


def odom_message(stamp_ns: int, x: float, child: str = "base_link"):
    t = STORE.types
    pose = t["geometry_msgs/msg/Pose"](
        t["geometry_msgs/msg/Point"](x, 0.0, 0.0),
        t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )
    zero = t["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    return t["nav_msgs/msg/Odometry"](
        header(stamp_ns, "odom"),
        child,
        t["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
        t["geometry_msgs/msg/TwistWithCovariance"](
            t["geometry_msgs/msg/Twist"](zero, zero), np.zeros(36)
        ),
    )


def range_message(stamp_ns: int, value: float, frame: str = "sonar_0", radiation: int = 0):
    return STORE.types["sensor_msgs/msg/Range"](
        header(stamp_ns, frame), radiation, 0.5, 0.02, 1.0, value, variance=0.0
    )


def bump_message():
    return STORE.types["robot_msgs/msg/Bump"](1, 0)


def write_bag(
    path: Path,
    messages: Sequence[tuple[str, int, object]],
    storage: str = "sqlite3",
    compression: str = "",
    qos: dict[str, list] | None = None,
) -> Path:
    """Write (topic, recorded ns, message) in the order given."""
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    writer = Writer(path, version=9, storage_plugin=plugin)
    if compression:
        writer.set_compression(CompressionMode[compression.upper()], CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, recorded_ns, message in messages:
            if topic not in connections:
                offered = (qos or {}).get(topic, [])
                connections[topic] = writer.add_connection(
                    topic, message.__msgtype__, typestore=STORE, offered_qos_profiles=offered
                )
            data = STORE.serialize_cdr(message, message.__msgtype__)
            writer.write(connections[topic], recorded_ns, data)
    return path


def storage_file(bag: Path) -> Path:
    """Return the storage file of a bag folder that has one."""
    (file,) = (f for f in bag.iterdir() if f.suffix in (".db3", ".mcap", ".zstd"))
    return file


def write_ros1_bag(
    path: Path, messages: Sequence[tuple[str, int, object]], compression: str = ""
) -> Path:
    """Write the same messages to a ROS 1 bag; `BZ2` or `LZ4` compresses its chunks."""
    writer = Ros1Writer(path)
    if compression:
        writer.set_compression(Ros1Writer.CompressionFormat[compression])
    with writer:
        connections = {}
        for topic, recorded_ns, message in messages:
            content = as_ros1(message)
            msgtype = content.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=ROS1_STORE)
            data = ROS1_STORE.serialize_ros1(content, msgtype)
            writer.write(connections[topic], recorded_ns, data)
    return path


def as_ros1(message):
    """Return a ROS 2 message as the ROS 1 message of the same fields; its headers count none."""
    if isinstance(message, list):
        return [as_ros1(item) for item in message]
    if not hasattr(message, "__msgtype__"):
        return message
    made = ROS1_STORE.types[message.__msgtype__]
    names = [name for name in made.__dataclass_fields__ if name != "__msgtype__"]
    return made(*(as_ros1(getattr(message, name, 0)) for name in names))


def drive(num_scans: int = 5, start_ns: int = START_NS, has_static: bool = True) -> list:
    """Return a drive of 0.1 m/s along x: a scan each 0.1 s, its odometry 0.05 s later."""
    step_ns = NS // 10
    messages: list[tuple[str, int, object]] = []
    if has_static:
        laser = tf_message(transform(start_ns, "base_link", "laser", x=0.2))
        messages.append(("/tf_static", start_ns, laser))
    first = tf_message(transform(start_ns - step_ns // 2, "odom", "base_link", x=-0.005))
    messages.append(("/tf", start_ns, first))
    for i in range(num_scans):
        stamp_ns = start_ns + i * step_ns
        messages.append(("/scan", stamp_ns + 1, scan_message(stamp_ns)))
        tf_ns = stamp_ns + step_ns // 2
        odom = tf_message(transform(tf_ns, "odom", "base_link", x=0.01 * i + 0.005))
        messages.append(("/tf", tf_ns, odom))
    return messages
