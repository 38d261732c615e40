"""What a robot on the small-size field publishes, drawn from the plan: masks, goals, transforms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray
from heard_poses import odometry_of
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from floornav_common.camera_files import load_camera_model
from floornav_common.ros.messages import array_to_image, ns_to_stamp, poses_to_msg
from floornav_common.ros.qos import RELIABLE_QOS
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from multi_localizer.floor_plan import load_plan

CAMERA = load_camera_model("soccer_small_size")
PLAN = load_plan("small_size_field")
FLOOR_FRAME = "omni_camera_floor"
FRAME_NS = 100_000_000
_U, _V = np.meshgrid(np.arange(256.0), np.arange(220.0))
_SEEN = CAMERA.floor_points(np.stack((_U, _V), axis=-1))
_IS_FLOOR = np.isfinite(_SEEN).all(axis=-1)


def mask_from(pose: SE2) -> np.ndarray:
    """Return the mask of the empty field from a pose of the robot, (220, 256), uint8."""
    points = pose @ np.where(_IS_FLOOR[..., None], _SEEN, 0.0).reshape(-1, 2)
    is_inside = np.zeros(len(points), dtype=bool)
    for (x1, y1), (x2, y2) in zip(PLAN.corners, np.roll(PLAN.corners, -1, axis=0), strict=True):
        if y1 != y2:
            is_level = (y1 > points[:, 1]) != (y2 > points[:, 1])
            is_right = points[:, 0] < x1 + (points[:, 1] - y1) * (x2 - x1) / (y2 - y1)
            is_inside ^= is_level & is_right
    return np.where(is_inside.reshape(220, 256) & _IS_FLOOR, 255, 0).astype(np.uint8)


def goal_bearing(pose: SE2, kind: str) -> float:
    ((x, y),) = pose.inverse() @ np.array([PLAN.goals[kind]])
    return math.atan2(y, x)


class FloorRobot:
    """Sends masks with odometry; its stamps go on by a tenth of a second each time."""

    def __init__(self, peer: Any, node: Any) -> None:
        self.peer = peer
        self.stamp_ns = 5_000_000_000
        self.masks = peer.publisher(Image, "floor/mask", RELIABLE_QOS, to=node)
        self.odometry = peer.publisher(Odometry, "odom", RELIABLE_QOS, to=node)
        self.goals = peer.publisher(PoseArray, "bearings/goal_blue", RELIABLE_QOS, to=node)

    def stand(self) -> None:
        """Say where the camera is."""
        self._statics = StaticTransformBroadcaster(self.peer.node)
        self._statics.send("base_link", FLOOR_FRAME, 0, Transform3.identity())

    def see(self, mask: np.ndarray, odometry: SE2, bearings: list[float] | None = None) -> None:
        """Send what a moment shows: odometry, goals if any are given, then the mask."""
        self.stamp_ns += FRAME_NS
        stamp = ns_to_stamp(self.stamp_ns)
        self.odometry.publish(odometry_of(odometry, self.stamp_ns))
        if bearings is not None:
            poses = PoseArray(poses=[_direction(b) for b in bearings])
            poses.header.stamp, poses.header.frame_id = stamp, FLOOR_FRAME
            self.goals.publish(poses)
        frame = "omni_camera_optical_frame"
        self.masks.publish(array_to_image(mask, "mono8", stamp, frame))


def _direction(bearing: float) -> Any:
    if math.isfinite(bearing):
        return poses_to_msg([SE2(0.0, 0.0, bearing)], ns_to_stamp(0), "").poses[0]
    pose = poses_to_msg([SE2.identity()], ns_to_stamp(0), "").poses[0]
    pose.orientation.z = pose.orientation.w = bearing
    return pose
