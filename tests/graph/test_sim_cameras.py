"""The cameras of sim_bridge over DDS: encodings, frames, camera_info, transforms."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS: nodes cannot be started")
pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from floornav_common.ros.messages import image_to_array, stamp_to_ns
from floornav_common.ros.qos import LATCHED_QOS, SENSOR_QOS
from sim_bridge.nodes.camera_port import CameraPort
from sim_bridge.robot_model import load_robot
from sim_bridge.world import RobotPlacement

LISTENING = Path(__file__).with_name("listening.py")
START_S = 120.0  # the renderer may have to be compiled first


@pytest.fixture
def sim(start: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that starts the node in a world and waits until it is ready."""

    def begin(world: str) -> Any:
        parameters = ("-p", f"world:={world}", "-p", "real_time_factor:=1.0")
        process = start(LISTENING, "sim_bridge.nodes.sim_bridge_node", "--ros-args", *parameters)
        process.wait_for("ready", START_S)
        return process

    return begin


def test_the_mirror_image_comes_in_its_optical_frame(sim, peer) -> None:
    images = peer.collect(Image, "omni/image_raw", SENSOR_QOS)
    static = peer.collect(TFMessage, "/tf_static", LATCHED_QOS)
    sim("small_size_field")
    peer.spin_until(lambda: images and static)
    image = images[0]
    assert (image.width, image.height, image.encoding) == (256, 220, "rgb8")
    assert image.header.frame_id == "omni_camera_optical_frame"
    assert stamp_to_ns(image.header.stamp) % 100_000_000 == 0
    pixels = image_to_array(image)
    assert pixels[0, 0].max() < 30 and pixels.mean() > 20.0
    heights = {
        t.child_frame_id: t.transform.translation.z for msg in static for t in msg.transforms
    }
    assert heights["omni_camera_link"] == pytest.approx(0.20508)
    assert heights["omni_camera_optical_frame"] == pytest.approx(0.20508)
    assert heights["omni_camera_floor"] == pytest.approx(0.0)


def test_stereo_pairs_come_with_their_camera_info(sim, peer) -> None:
    topics = [f"stereo/{pair}/{side}" for pair in ("front", "rear") for side in ("left", "right")]
    images = {t: peer.collect(Image, f"{t}/image_rect", SENSOR_QOS) for t in topics}
    infos = {t: peer.collect(CameraInfo, f"{t}/camera_info", SENSOR_QOS) for t in topics}
    sim("stereo_room")
    peer.spin_until(lambda: all(images.values()) and all(infos.values()))
    for topic in topics:
        image, info = images[topic][0], infos[topic][0]
        pair = topic.split("/")[1]
        assert image.header.frame_id == f"stereo_{pair}_left_optical_frame"
        assert info.header.frame_id == image.header.frame_id
        assert (info.width, info.height) == (image.width, image.height) == (320, 240)
        shift = -info.p[3] / info.p[0]
        assert shift == pytest.approx(0.10 if topic.endswith("right") else 0.0)


def test_a_camera_is_watched_while_somebody_subscribes_to_any_of_its_topics(peer) -> None:
    robot = load_robot(RobotPlacement(model="segway_stereo", position_m=(0.0, 0.0)))
    port = CameraPort(peer.node, "", "", robot)
    assert not port.is_watched("front") and not port.is_watched("rear")
    subscription = peer.node.create_subscription(
        CameraInfo, "stereo/front/right/camera_info", lambda _: None, SENSOR_QOS
    )
    peer.spin_until(lambda: port.is_watched("front"))
    assert not port.is_watched("rear")
    peer.node.destroy_subscription(subscription)
    peer.spin_until(lambda: not port.is_watched("front"))


def test_who_comes_late_gets_images_and_what_is_built_is_said_before_ready(sim, peer) -> None:
    process = sim("small_size_field")
    clock = peer.collect(Clock, "/clock", SENSOR_QOS)
    peer.spin_until(lambda: clock and stamp_to_ns(clock[-1].clock) > 500_000_000)
    images = peer.collect(Image, "omni/image_raw", SENSOR_QOS)
    peer.spin_until(lambda: len(images) > 1)
    assert stamp_to_ns(images[0].header.stamp) > 500_000_000
    building = process.wait_for("building world 'small_size_field'")
    assert process.lines.index(building) < process.lines.index(process.wait_for("ready"))
