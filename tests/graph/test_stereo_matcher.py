"""The stereo matcher over DDS: a pair made by hand, and pairs that are none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from diagnostic_msgs.msg import DiagnosticArray
from robot_messages import statuses
from sensor_msgs.msg import CameraInfo, Image
from stereo_msgs.msg import DisparityImage

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from floornav_common.ros.messages import array_to_image, ns_to_stamp, stamp_to_ns
from floornav_common.ros.qos import RELIABLE_QOS

LISTENING = Path(__file__).with_name("listening.py")
NODE = (LISTENING, "multi_localizer.nodes.stereo_matcher_node")
START_S = 240.0
FRAME = "stereo_front_left_optical_frame"
WIDTH, HEIGHT, SHIFT, FOCAL, BASELINE = 120, 40, 9, 100.0, 0.1


def info(baseline: float, row: float = 19.5) -> CameraInfo:
    msg = CameraInfo(width=WIDTH, height=HEIGHT)
    msg.k = [FOCAL, 0.0, 59.5, 0.0, FOCAL, row, 0.0, 0.0, 1.0]
    msg.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    msg.p = [FOCAL, 0.0, 59.5, -FOCAL * baseline, 0.0, FOCAL, row, 0.0, 0.0, 0.0, 1.0, 0.0]
    return msg


class Rig:
    """Sends pairs of a wall of noise."""

    def __init__(self, peer: Any, node: Any) -> None:
        self.peer, self.stamp_ns = peer, 5_000_000_000
        wall = np.random.default_rng(0).integers(0, 256, (HEIGHT, 160), dtype=np.uint8)
        self.images = {"left": wall[:, :WIDTH], "right": wall[:, SHIFT : WIDTH + SHIFT]}
        self.infos = {"left": info(0.0), "right": info(BASELINE)}
        self.skew_ns = 0
        self.sides = ["left", "right"]
        self.topics = {
            (side, kind): peer.publisher(kind, f"stereo/front/{side}/{name}", RELIABLE_QOS, to=node)
            for side in self.images
            for kind, name in ((Image, "image_rect"), (CameraInfo, "camera_info"))
        }
        self.found: list[DisparityImage] = peer.collect(
            DisparityImage, "stereo/front/disparity", RELIABLE_QOS
        )
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        peer.wait_to_hear("stereo/front/disparity", "/diagnostics")

    def see_until(self, is_done: Callable[[], bool]) -> None:
        for _ in range(400):
            self.stamp_ns += 100_000_000
            for side in self.sides:
                pixels = self.images[side]
                stamp = ns_to_stamp(self.stamp_ns + (self.skew_ns if side == "right" else 0))
                self.infos[side].header.stamp = stamp
                self.topics[side, CameraInfo].publish(self.infos[side])
                image = array_to_image(np.ascontiguousarray(pixels), "mono8", stamp, FRAME)
                self.topics[side, Image].publish(image)
            if self.peer.spin_until(is_done, 0.15, must=False):
                return
        said = [(s.level, s.message) for a in self.states[-5:] for s in a.status]
        pytest.fail(f"not so after 400 pairs; last said: {said}")

    def says(self, level: bytes, words: str) -> Callable[[], bool]:
        def is_so() -> bool:
            said = statuses(self.states, "stereo front")
            return bool(said) and said[-1].level == level and words in said[-1].message

        return is_so


def test_parameters_are_checked_before_anything_is_compiled(start: Any) -> None:
    code = (
        "import sys; from multi_localizer.nodes import stereo_matcher_node as n; "
        "n.StereoMatcher.warm_up = lambda _: print('it compiles', flush=True); sys.exit(n.main())"
    )
    node = start("-c", code, "--ros-args", "-p", "nosuch:=1")
    assert node.wait_for_exit(START_S) == 2
    assert "nosuch" in node.text and "it compiles" not in node.text


def test_a_pair_becomes_disparities_or_a_reason_why_not(start: Any, peer: Any) -> None:
    """One node lives through all of it."""
    args = ("--ros-args", "-p", "pairs:=[front]", "-p", "num_disparities:=32")
    node = start(*NODE, *args)
    node.wait_for("ready", START_S)
    rig = Rig(peer, node)
    rig.sides = ["left"]
    rig.see_until(rig.says(WARN, "no right images on /stereo/front/right/image_rect"))
    assert not any(s.level == OK for s in statuses(rig.states, "stereo front"))
    rig.sides = ["left", "right"]
    rig.see_until(lambda: bool(rig.found) and rig.says(OK, "disparities are sent")())
    rig.see_until(lambda: "front: disparities are sent" in node.text)
    msg = rig.found[-1]
    values = np.frombuffer(msg.image.data, np.float32).reshape(HEIGHT, WIDTH)
    assert np.all(np.abs(values - SHIFT)[values >= 0.0] <= 0.5)
    assert np.mean(values[:, :SHIFT] == -1.0) > 0.9 and np.all(values[:, SHIFT + 3 : -3] >= 0.0)
    assert (msg.header.frame_id, msg.image.encoding) == (FRAME, "32FC1")
    assert msg.header == msg.image.header and stamp_to_ns(msg.header.stamp) % 100_000_000 == 0
    assert (msg.f, msg.min_disparity, msg.max_disparity) == (FOCAL, 0.0, 31.0)
    assert msg.t == pytest.approx(BASELINE)

    for right, why in ((info(BASELINE, row=22.0), "rows differ"), (info(0.0), "no baseline")):
        rig.infos["right"] = right
        rig.see_until(rig.says(ERROR, why))
        num = len(rig.found)
        rig.see_until(rig.says(ERROR, why))
        assert len(rig.found) == num

    rig.infos["right"], rig.skew_ns = info(BASELINE), 40_000_000
    rig.see_until(rig.says(WARN, "without a partner"))
    rig.skew_ns = 0
    num = len(rig.found)
    rig.see_until(lambda: len(rig.found) > num and rig.says(OK, "disparities are sent")())
    assert node.stop() == 0
