"""The floor nodes over DDS: images in, free space and mask out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from painted_floors import BROWN, GRAY, behind, painted, robot_body, upright_camera

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import CompressedImage, Image, LaserScan
from tf2_msgs.msg import TFMessage

from floornav_common.ros.diagnostics import ERROR, OK, WARN
from floornav_common.ros.messages import (
    array_to_compressed,
    array_to_image,
    image_to_array,
    poses_from_msg,
    scan_from_msg,
)
from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, SENSOR_QOS
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.transform3 import Transform3

NODE = (Path(__file__).with_name("listening.py"), "floor_perception.nodes.floor_detector_node")
START_S = 60.0  # kernels may have to be compiled first
OPTICAL = "omni_camera_optical_frame"
WALL_M = 0.60
PART_OF_A_CELL_M = 0.02  # a cell is free while 0.6 of it is floor


@pytest.fixture
def image() -> np.ndarray:
    """Return a floor with a wall in front and one all the way round."""
    camera = upright_camera()
    regions = [
        (behind(0.0, math.pi, 1.5), GRAY), (behind(0.0, 0.3, WALL_M), BROWN),
        (robot_body(), GRAY),
    ]  # fmt: skip
    return painted(camera, regions, noise_sd=2.0)


@pytest.fixture
def node(start: Any) -> Any:
    process = start(*NODE)
    process.wait_for("ready", START_S)
    return process


def test_an_image_gives_free_space_and_mask_with_its_stamp(node, peer, image) -> None:
    scans = peer.collect(LaserScan, "floor/free_space", RELIABLE_QOS)
    masks = peer.collect(Image, "floor/mask", RELIABLE_QOS)
    peer.wait_to_hear("floor/free_space", "floor/mask")
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    stamp = Time(sec=12, nanosec=345)
    msg = array_to_image(image, "rgb8", stamp, OPTICAL)
    peer.publish_until(images, msg, lambda: scans and masks)
    scan, mask = scans[0], masks[0]
    assert scan.header.frame_id == "omni_camera_floor"
    assert (scan.header.stamp, mask.header.stamp) == (stamp, stamp)
    assert (mask.header.frame_id, mask.encoding) == (OPTICAL, "mono8")
    assert (mask.width, mask.height) == (256, 220)
    assert set(np.unique(image_to_array(mask))) == {0, 255}
    assert len(scan.ranges) * scan.angle_increment == pytest.approx(2.0 * math.pi, abs=1e-4)
    assert scan.angle_max == pytest.approx(math.pi - scan.angle_increment, abs=1e-4)
    core = scan_from_msg(scan)
    ahead = core.ranges[np.abs(core.angles) < 0.2]
    assert (ahead <= WALL_M + PART_OF_A_CELL_M).all() and (ahead > WALL_M - 0.1).all()
    aside = core.ranges[np.abs(core.angles) > 0.4]
    assert np.median(aside) > 1.2 and (aside <= 1.6).all()


def test_compressed_images_give_the_same(start, peer, image) -> None:
    node = start(*NODE, "--ros-args", "-p", "image_transport:=compressed")
    node.wait_for("ready", START_S)
    scans = peer.collect(LaserScan, "floor/free_space", RELIABLE_QOS)
    peer.wait_to_hear("floor/free_space")
    images = peer.publisher(CompressedImage, "omni/image_raw/compressed", RELIABLE_QOS, to=node)
    msg = array_to_compressed(image, "rgb8", Time(sec=1), OPTICAL, quality=None)
    peer.publish_until(images, msg, lambda: scans)
    core = scan_from_msg(scans[0])
    assert (core.ranges[np.abs(core.angles) < 0.2] <= WALL_M + PART_OF_A_CELL_M).all()


def test_the_overlay_is_sent_to_those_who_ask(node, peer, image) -> None:
    overlays = peer.collect(Image, "floor/overlay", SENSOR_QOS)
    peer.wait_to_hear("floor/overlay")
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    msg = array_to_image(image, "rgb8", Time(sec=1), OPTICAL)
    peer.publish_until(images, msg, lambda: overlays)
    drawn = image_to_array(overlays[0])
    assert drawn.shape == image.shape and not np.array_equal(drawn, image[..., ::-1])


def test_the_floor_frame_is_sent_where_nobody_else_does(start, peer) -> None:
    sent = peer.collect(TFMessage, "/tf_static", LATCHED_QOS)
    process = start(*NODE, "--ros-args", "-p", "publish_tf_after_s:=0.2")
    process.wait_for("omni_camera_floor is sent by nobody", START_S)
    peer.spin_until(lambda: sent)
    (stamped,) = sent[0].transforms
    assert (stamped.header.frame_id, stamped.child_frame_id) == ("base_link", "omni_camera_floor")
    assert stamped.transform.translation.z == 0.0


def test_the_floor_frame_of_a_robot_description_is_left_alone(start, peer) -> None:
    broadcaster = StaticTransformBroadcaster(peer.node)
    broadcaster.send("base_link", "omni_camera_floor", 0, Transform3.identity())
    process = start(*NODE, "--ros-args", "-p", "publish_tf_after_s:=600.0")
    process.wait_for("ready", START_S)
    process.wait_for("omni_camera_floor is sent by the robot's description")
    assert peer.node.count_publishers("/tf_static") == 1


def test_without_floor_around_the_robot_nothing_is_promised(node, peer) -> None:
    """Half of the ring in one color, half in another, neither more than half: no floor is known."""
    scans = peer.collect(LaserScan, "floor/free_space", RELIABLE_QOS)
    states = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    thirds = [
        (behind(2.0 * math.pi / 3.0 * k, math.pi / 3.0, 0.0), color)
        for k, color in enumerate((BROWN, GRAY))
    ]
    msg = array_to_image(painted(upright_camera(), thirds), "rgb8", Time(sec=1), OPTICAL)
    said = lambda: [  # noqa: E731
        s.message for m in states for s in m.status if s.name.endswith("floor")
    ]
    peer.publish_until(images, msg, lambda: any("color is not known" in text for text in said()))
    assert scans == []


def said_of(states: list[DiagnosticArray], part: str) -> list[tuple[bytes, str]]:
    return [(s.level, s.message) for m in states for s in m.status if s.name.endswith(f": {part}")]


def test_after_a_dark_start_free_space_comes_with_the_light(node, peer, image) -> None:
    scans = peer.collect(LaserScan, "floor/free_space", RELIABLE_QOS)
    states = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
    peer.wait_to_hear("floor/free_space")
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    for second in range(1, 4):
        black = array_to_image(np.zeros_like(image), "rgb8", Time(sec=second), OPTICAL)
        images.publish(black)
        peer.spin(0.2)
    peer.publish_until(
        images, black, lambda: any("too dark" in text for _, text in said_of(states, "floor"))
    )
    assert scans == []
    lit = array_to_image(image, "rgb8", Time(sec=9), OPTICAL)
    peer.publish_until(images, lit, lambda: scans)
    core = scan_from_msg(scans[0])
    assert (core.ranges[np.abs(core.angles) < 0.2] <= WALL_M + PART_OF_A_CELL_M).all()


@pytest.mark.parametrize("kind", ["gray", "strip", "speck"])
@pytest.mark.parametrize("part", ["floor", "markers"])
def test_images_refused_are_an_error_until_one_is_taken(start, peer, image, kind, part) -> None:
    """Never OK while nothing is sent."""
    name = {"floor": "floor_detector", "markers": "marker_detector"}[part]
    node = start(NODE[0], f"floor_perception.nodes.{name}_node")
    node.wait_for("ready", START_S)
    states = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    good = array_to_image(image, "rgb8", Time(sec=1), OPTICAL)
    peer.publish_until(images, good, lambda: OK in [level for level, _ in said_of(states, part)])
    pixels, encoding = {
        "gray": (image[..., 0].copy(), "mono8"),
        "strip": (np.full((20, 4000, 3), 100, dtype=np.uint8), "rgb8"),
        "speck": (np.full((2, 1, 3), 100, dtype=np.uint8), "rgb8"),
    }[kind]
    states.clear()
    bad = array_to_image(pixels, encoding, Time(sec=2), OPTICAL)
    refused = lambda: [t for v, t in said_of(states, part) if v == ERROR]  # noqa: E731
    peer.publish_until(images, bad, refused)
    assert "the image is refused: image must" in refused()[0]
    states.clear()
    peer.publish_until(images, good, lambda: OK in [level for level, _ in said_of(states, part)])


@pytest.mark.parametrize("part", ["floor", "markers"])
def test_images_of_another_shape_are_a_warning_as_long_as_they_come(start, peer, part) -> None:
    """640 x 480 by a camera file for 256 x 220: it may be the same picture, or another camera's."""
    name = {"floor": "floor_detector", "markers": "marker_detector"}[part]
    node = start(NODE[0], f"floor_perception.nodes.{name}_node")
    node.wait_for("ready", START_S)
    states = peer.collect(DiagnosticArray, "/diagnostics", RELIABLE_QOS)
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    for size, level in (((480, 640), WARN), ((220, 256), OK)):
        states.clear()
        pixels = painted(upright_camera(size[::-1]), [(robot_body(), GRAY)])
        msg = array_to_image(pixels, "rgb8", Time(sec=1), OPTICAL)
        as_it_is = lambda v=level: [t for w, t in said_of(states, part) if w == v]  # noqa: E731
        peer.publish_until(images, msg, as_it_is)
        assert ("images are 640 x 480, camera_model is for 256 x 220" in as_it_is()[0]) == (
            level == WARN
        )


def test_a_camera_model_that_is_none_is_named_at_the_start(start) -> None:
    process = start(*NODE, "--ros-args", "-p", "camera_model:=nobody")
    assert process.wait_for_exit(START_S) == 2
    assert "no file named 'nobody' in camera_models" in process.text


def test_markers_are_sent_as_bearings_and_their_absence_as_empty_arrays(start, peer, image) -> None:
    node = start(NODE[0], "floor_perception.nodes.marker_detector_node")
    node.wait_for("ready", START_S)
    robots = peer.collect(PoseArray, "bearings/robots", RELIABLE_QOS)
    goals = peer.collect(PoseArray, "bearings/goal_yellow", RELIABLE_QOS)
    peer.wait_to_hear("bearings/robots", "bearings/goal_yellow")
    images = peer.publisher(Image, "omni/image_raw", RELIABLE_QOS, to=node)
    picture = image.copy()
    picture[157:162, 125:131] = (230, 26, 191)  # down in the image: to the left
    msg = array_to_image(picture, "rgb8", Time(sec=7), OPTICAL)
    peer.publish_until(images, msg, lambda: robots and goals)
    assert robots[0].header.frame_id == "omni_camera_floor"
    assert robots[0].header.stamp == Time(sec=7)
    (pose,) = poses_from_msg(robots[0])
    assert pose.yaw == pytest.approx(math.pi / 2.0, abs=0.02)
    assert poses_from_msg(goals[0]) == []
