"""Image in to free space out over DDS: run as a process of its own, it prints JSON.

Starts the node `floor_detector`, publishes one picture of 640 x 480 again and again at 30 Hz, and
takes the time from before `publish` to the arrival of the scan with the same stamp.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Any

import numpy as np

PERIOD_S = 1.0 / 30.0
NUM_WARM, NUM_IMAGES = 30, 300
DISCOVERY_S, LAST_S = 20.0, 1.0


def main() -> None:
    """Measure, print, end the node."""
    command = [sys.executable, "-m", "floor_perception.nodes.floor_detector_node"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as node:
        try:
            print(json.dumps(measure(np.load(sys.argv[1]))))
        finally:
            node.terminate()


def measure(picture: np.ndarray) -> dict[str, float]:
    """Return median and 99th percentile of the latency, ms, and how many scans never came."""
    import rclpy
    from sensor_msgs.msg import Image, LaserScan

    from floornav_common.ros.messages import array_to_image, ns_to_stamp, stamp_to_ns
    from floornav_common.ros.qos import RELIABLE_QOS

    rclpy.init()
    node = rclpy.create_node("floor_latency")
    arrived: dict[int, float] = {}

    def on_scan(msg: Any) -> None:
        arrived[stamp_to_ns(msg.header.stamp)] = time.perf_counter()

    node.create_subscription(LaserScan, "floor/free_space", on_scan, RELIABLE_QOS)
    images = node.create_publisher(Image, "omni/image_raw", RELIABLE_QOS)
    begun = time.perf_counter()
    while not arrived:  # the node is there and sees the floor
        if time.perf_counter() - begun > DISCOVERY_S:
            raise TimeoutError("no free space from floor_detector")
        images.publish(array_to_image(picture, "rgb8", ns_to_stamp(1), "camera"))
        rclpy.spin_once(node, timeout_sec=0.5)
    sent: dict[int, float] = {}
    begun = time.perf_counter()
    for k in range(1, NUM_WARM + NUM_IMAGES + 1):
        stamp_ns = int(1e9 * (1.0 + k * PERIOD_S))
        msg = array_to_image(picture, "rgb8", ns_to_stamp(stamp_ns), "camera")
        sent[stamp_ns] = time.perf_counter()
        images.publish(msg)
        _spin_until(node, begun + k * PERIOD_S)
    _spin_until(node, time.perf_counter() + LAST_S)
    judged = sorted(sent)[NUM_WARM:]
    ms = np.array([1e3 * (arrived[s] - sent[s]) for s in judged if s in arrived])
    return {
        "median_ms": float(np.median(ms)),
        "p99_ms": float(np.percentile(ms, 99)),
        "lost": len(judged) - len(ms),
        "images": len(judged),
    }


def _spin_until(node: Any, end: float) -> None:
    import rclpy

    while (left := end - time.perf_counter()) > 0.0:
        rclpy.spin_once(node, timeout_sec=left)


if __name__ == "__main__":
    main()
