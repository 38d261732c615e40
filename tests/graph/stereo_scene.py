"""What a robot with stereo pairs publishes in a small room, drawn from the room's voxel map."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
from heard_poses import odometry_of
from nav_msgs.msg import Odometry
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header
from stereo_msgs.msg import DisparityImage

from floornav_common.ros.messages import array_to_image, ns_to_stamp
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from multi_localizer.ros_conversions import disparities_to_msg
from multi_localizer.stereo_cameras import RectifiedPair
from multi_localizer.voxel_map import VoxelMap
from multi_localizer.voxel_view import ViewCamera, VoxelScene

SIZE, FOCAL, BASELINE, HEIGHT_M = (320, 240), 280.0, 0.1, 1.0
FRAME_NS = 100_000_000
CAMERAS = {
    name: ViewCamera(*SIZE, FOCAL, BASELINE, HEIGHT_M, x, 0.05 if yaw == 0.0 else -0.05, yaw)
    for name, x, yaw in (("front", 0.1, 0.0), ("rear", -0.1, math.pi))
}


def small_room() -> VoxelMap:
    """Return a room of 3 x 2.4 m with walls of patches, no two alike, and a box."""
    rng = np.random.default_rng(3)
    occupied = np.zeros((10, 122, 152), dtype=bool)
    occupied[0] = occupied[-1] = True
    occupied[:, 0] = occupied[:, -1] = occupied[:, :, 0] = occupied[:, :, -1] = True
    occupied[1:4, 10:40, 10:50] = True
    patches = rng.integers(30, 256, (10, 13, 16, 3)).astype(np.uint8)
    color = patches.repeat(10, axis=1).repeat(10, axis=2)[:, :122, :152]
    color = np.where(occupied[..., None], color, np.uint8(0))
    return VoxelMap(np.ascontiguousarray(color), occupied, 0.02, 0.25, -0.02, -0.02, -0.25)


class StereoRobot:
    """Sends disparities and left images with odometry; its stamps go on by a tenth of a second."""

    def __init__(self, peer: Any, node: Any) -> None:
        self.peer, self.stamp_ns, self.skew_ns = peer, 5_000_000_000, 0
        self.is_covered = False
        self._scene = VoxelScene(small_room())
        self._drawn: dict[tuple[str, SE2], tuple[np.ndarray, np.ndarray]] = {}
        self.odometry = peer.publisher(Odometry, "odom", RELIABLE_QOS, to=node)
        kinds = {
            "disparity": DisparityImage,
            "left/image_rect": Image,
            "left/camera_info": CameraInfo,
        }
        self.topics = {
            (pair, topic): peer.publisher(kind, f"stereo/{pair}/{topic}", RELIABLE_QOS, to=node)
            for pair in CAMERAS
            for topic, kind in kinds.items()
        }

    def stand(self) -> None:
        """Say where the cameras are."""
        self._statics = StaticTransformBroadcaster(self.peer.node)
        for pair, c in CAMERAS.items():
            turn = Rotation.from_euler("z", c.yaw) * Rotation.from_matrix(
                [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
            )
            place = Transform3.from_parts((c.x_m, c.y_m, c.height_m), turn.as_quat())
            self._statics.send("base_link", frame_of(pair), 0, place)

    def see(
        self, pose: SE2, odometry: SE2, pairs: Collection[str] = tuple(CAMERAS),
        has_info: bool = True,
    ) -> None:  # fmt: skip
        """Send what pairs show at a pose, with odometry before it."""
        self.stamp_ns += FRAME_NS
        self.odometry.publish(odometry_of(odometry, self.stamp_ns))
        for pair in pairs:
            self._show(pair, pose, has_info)

    def _show(self, pair: str, pose: SE2, has_info: bool) -> None:
        color, disparity = self._view(pair, pose)
        header = Header(stamp=ns_to_stamp(self.stamp_ns), frame_id=frame_of(pair))
        if has_info:
            middle = [(n - 1) / 2.0 for n in SIZE]
            info = CameraInfo(header=header, width=SIZE[0], height=SIZE[1])
            info.p = [FOCAL, 0.0, middle[0], 0.0, 0.0, FOCAL, middle[1], 0.0, 0.0, 0.0, 1.0, 0.0]
            self.topics[pair, "left/camera_info"].publish(info)
        rectified = RectifiedPair(SIZE, FOCAL, BASELINE, 0.0)
        msg = disparities_to_msg(disparity, rectified, 64, header)
        stamp = ns_to_stamp(self.stamp_ns + self.skew_ns)
        left = array_to_image(color, "rgb8", stamp, frame_of(pair))
        self.topics[pair, "left/image_rect"].publish(left)
        self.topics[pair, "disparity"].publish(msg)

    def _view(self, pair: str, pose: SE2) -> tuple[np.ndarray, np.ndarray]:
        if (pair, pose) not in self._drawn:
            poses = np.array([[pose.x, pose.y, pose.yaw]])
            color, distance = self._scene.render(poses, CAMERAS[pair], SIZE)
            disparity = (FOCAL * BASELINE / distance[0]).astype(np.float32)
            self._drawn[pair, pose] = np.rint(color[0]).astype(np.uint8), disparity
        color, disparity = self._drawn[pair, pose]
        if self.is_covered:
            return np.zeros_like(color), np.full_like(disparity, np.nan)
        return color, disparity


def frame_of(pair: str) -> str:
    """Return the frame of a pair's left camera."""
    return f"stereo_{pair}_left_optical_frame"
