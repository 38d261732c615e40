"""Time to fill and read large messages, and whether images arrive between two processes.

Peer of filling: assigning ready `array.array` data to the message's field. Peer of reading: taking
the field as it is. Delivery: 640 x 480 images at 30 Hz, best effort, to a process of its own, with
the project's Fast DDS profile, beside the same with Fast DDS as it comes. Latency runs from the
stamp to the subscriber's callback. Floor of a fill: one copy of the bytes.
"""

from __future__ import annotations

import array
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from experiments.timing import Case, median_and_p99, take_turns

NUM_CALLS = 300
IMAGE_HZ, IMAGE_S = 30.0, 10.0
PROFILE_KEY = "FASTRTPS_DEFAULT_PROFILES_FILE"


def run(seed: int, say: Callable[[str], None]) -> list[Case]:
    """Return the cases."""
    say("messages: filling and reading")
    cases = _image(seed) + _grid(seed)
    say(f"messages: images between processes, {2 * IMAGE_S:.0f} s")
    ours, default = (_deliver(has_profile) for has_profile in (True, False))
    extra = {
        "delivered_share": ours["delivered_share"],
        "peer_delivered_share": default["delivered_share"],
    }
    peer = default["median_ms"]
    name = "delivery_image_640x480_30hz"
    what = "Fast DDS without profile"
    return [*cases, Case(name, ours["median_ms"], ours["p99_ms"], what, peer, None, extra)]


def _image(seed: int) -> list[Case]:
    from sensor_msgs.msg import Image

    from floornav_common.ros.messages import array_to_image, image_to_array

    pixels = np.random.default_rng(seed).integers(0, 255, (480, 640, 3), np.uint8)
    stamp = Image().header.stamp
    ready, msg = array.array("B", pixels.tobytes()), Image()
    filled = array_to_image(pixels, "bgr8", stamp, "camera")

    def assign() -> None:
        msg.data = ready

    fill = {
        "ours": lambda: array_to_image(pixels, "bgr8", stamp, "camera"),
        "peer": assign,
        "floor": pixels.copy,
    }
    read = {
        "ours": lambda: image_to_array(filled),
        "peer": lambda: np.frombuffer(filled.data, np.uint8),
        "floor": lambda: filled.data,
    }
    return [
        _timed("fill_image_640x480", fill, "plain assignment"),
        _timed("read_image_640x480", read, "np.frombuffer"),
    ]


def _grid(seed: int) -> list[Case]:
    from nav_msgs.msg import OccupancyGrid

    from floornav_common.grid import OccupancyMap
    from floornav_common.ros.messages import grid_from_msg, grid_to_msg
    from floornav_common.se2 import SE2

    cells = np.random.default_rng(seed).integers(-1, 101, (400, 400), np.int8)
    grid = OccupancyMap(cells, 0.05, SE2.identity())
    ready, msg = array.array("b", cells.tobytes()), OccupancyGrid()
    stamp = msg.header.stamp
    filled = grid_to_msg(grid, stamp, "map")

    def assign() -> None:
        msg.data = ready

    fill = {
        "ours": lambda: grid_to_msg(grid, stamp, "map"),
        "peer": assign,
        "floor": cells.copy,
    }
    read = {
        "ours": lambda: grid_from_msg(filled),
        "peer": lambda: np.frombuffer(filled.data, np.int8),
        "floor": lambda: filled.data,
    }
    return [
        _timed("fill_grid_400x400", fill, "plain assignment"),
        _timed("read_grid_400x400", read, "np.frombuffer"),
    ]


def _timed(name: str, calls: dict[str, Callable[[], object]], peer: str) -> Case:
    ms = take_turns(calls, NUM_CALLS)
    median, p99 = median_and_p99(ms["ours"])
    floor = float(np.median(ms["floor"]))
    return Case(name, median, p99, peer, float(np.median(ms["peer"])), floor)


def _deliver(has_profile: bool) -> dict[str, float]:
    """Run publisher and subscriber in two processes of their own and return what arrived."""
    env = dict(os.environ, ROS_DOMAIN_ID=str(100 + has_profile))
    if not has_profile:
        env.pop(PROFILE_KEY, None)
    elif PROFILE_KEY not in env:
        raise RuntimeError(f"{PROFILE_KEY} is not set; start this with scripts/bench.py")
    scripts = str(Path(__file__).resolve().parent.parent)
    env["PYTHONPATH"] = os.pathsep.join(filter(None, (scripts, env.get("PYTHONPATH"))))
    command = [sys.executable, "-m", "experiments.bench_messages"]
    with subprocess.Popen([*command, "subscribe"], env=env, stdout=subprocess.PIPE) as subscriber:
        subprocess.run([*command, "publish"], env=env, check=True)
        output, _ = subscriber.communicate(timeout=30.0)
    return dict(json.loads(output))


def _publish() -> None:
    import rclpy
    from sensor_msgs.msg import Image

    from floornav_common.ros.messages import array_to_image, ns_to_stamp
    from floornav_common.ros.qos import SENSOR_QOS

    rclpy.init()
    node = rclpy.create_node("image_source")
    publisher = node.create_publisher(Image, "image", SENSOR_QOS)
    pixels = np.zeros((480, 640, 3), np.uint8)
    while publisher.get_subscription_count() == 0:
        time.sleep(0.05)
    time.sleep(0.5)
    next_time = time.monotonic()
    for number in range(int(IMAGE_HZ * IMAGE_S)):
        stamp = ns_to_stamp(time.time_ns())
        publisher.publish(array_to_image(pixels, "bgr8", stamp, str(number)))
        next_time += 1.0 / IMAGE_HZ
        time.sleep(max(0.0, next_time - time.monotonic()))
    time.sleep(1.0)
    node.destroy_node()
    rclpy.shutdown()


def _subscribe() -> None:
    import rclpy
    from sensor_msgs.msg import Image

    from floornav_common.ros.messages import stamp_to_ns
    from floornav_common.ros.qos import SENSOR_QOS

    rclpy.init()
    node = rclpy.create_node("image_sink")
    latencies: list[float] = []

    def on_image(msg: Image) -> None:
        latencies.append(1e-6 * (time.time_ns() - stamp_to_ns(msg.header.stamp)))

    subscription = node.create_subscription(Image, "image", on_image, SENSOR_QOS)
    end = time.monotonic() + 30.0
    while time.monotonic() < end and subscription.get_publisher_count() == 0:
        rclpy.spin_once(node, timeout_sec=0.05)
    while time.monotonic() < end and subscription.get_publisher_count() > 0:
        rclpy.spin_once(node, timeout_sec=0.05)
    ms = np.array(latencies) if latencies else np.array([np.nan])
    median, p99 = median_and_p99(ms)
    share = len(latencies) / (IMAGE_HZ * IMAGE_S)
    print(json.dumps({"median_ms": median, "p99_ms": p99, "delivered_share": share}))
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    {"publish": _publish, "subscribe": _subscribe}[sys.argv[1]]()
