"""A team as the tests place it, and what its cameras would send: bearings, poses, frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry

from floornav_common.readings import OdometryReading
from floornav_common.ros.messages import (
    ns_to_stamp,
    odometry_to_msg,
    poses_to_msg,
    se2_cov_to_ros,
    se2_to_pose,
)
from floornav_common.ros.transforms import StaticTransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

POSES = {
    "r1": SE2(-2.8, 0.3, 0.1), "r2": SE2(-0.9, -1.2, 0.7), "r3": SE2(-0.6, 1.5, -0.5),
    "r4": SE2(2.0, -0.4, 3.0),
}  # fmt: skip
POLES = np.array([[4.0, 2.0], [-4.0, 2.0], [0.5, -2.5]])
MOUNT = SE2(0.1, 0.0, 0.2)  # of a camera in its base_link
NOISE = 0.005
ROUGH_M, ROUGH_RAD = 0.15, 0.1
SWAY_M, SWAY_RAD, SWAY_S = 0.03, 0.02, 4.0
ODOMETRY_START = SE2(5.0, -3.0, 1.0)
Make = Callable[[type, str], Any]


def write_landmarks(folder: Path) -> Path:
    path = folder / "poles.yaml"
    path.write_text(f"pole: {{positions_m: {POLES.tolist()}}}\n")
    return path


class TeamVoices:
    """Sends what the cameras and wheels of some robots would say of the whole team.

    The robots drive to and fro a little about their places, and their odometry says so.

    Args:
        node: A plain node to send with.
        names: Whose messages to send.
        seed: Of noise, and of the order bearings come in.
        make: Creates a publisher of a type and a topic.
        poses: Where all robots are.
    """

    def __init__(
        self,
        node: Any,
        names: Sequence[str],
        seed: int,
        make: Make,
        poses: dict[str, SE2] | None = None,
    ) -> None:
        self.poses = dict(POSES if poses is None else poses)
        self._now_ns = 0
        self._rng = np.random.default_rng(seed)
        self._statics = StaticTransformBroadcaster(node)
        self._pubs: dict[tuple[str, str], Any] = {}
        for name in names:
            self._statics.send(
                f"{name}/base_link", f"{name}/omni_camera_floor", 1, Transform3.from_se2(MOUNT)
            )
            for topic, kind in (
                ("bearings/robots", PoseArray), ("bearings/pole", PoseArray),
                ("pose", PoseWithCovarianceStamped), ("odom", Odometry),
            ):  # fmt: skip
                self._pubs[name, topic] = make(kind, f"/{name}/{topic}")
        self._rough = {name: self._rng.normal(0.0, 1.0, 3) for name in names}
        self.names = list(names)

    def say(
        self,
        stamp_ns: int,
        silent: Collection[str] = (),
        without_pose: Collection[str] = (),
        lies: dict[str, SE2] | None = None,
        behind_s: Mapping[str, float] | None = None,
    ) -> None:
        """Send one round of messages of a stamp.

        Args:
            stamp_ns: The time.
            silent: Robots that send nothing.
            without_pose: Robots that do not send where they are by themselves.
            lies: What robots say of where they are instead.
            behind_s: By how much the stamps of robots are behind the time.
        """
        self._now_ns = stamp_ns
        for name in self.names:
            if name in silent:
                continue
            own_ns = stamp_ns - round(1e9 * (behind_s or {}).get(name, 0.0))
            self.say_odometry(name, own_ns, ODOMETRY_START @ self._moved(stamp_ns))
            if name not in without_pose:
                self._say_pose(name, own_ns, (lies or {}).get(name))
            others = [self.pose_at(n, stamp_ns) @ MOUNT for n in self.poses if n != name]
            self.say_bearings(name, "pole", own_ns, self.seen(name, POLES))
            places = np.array([[p.x, p.y] for p in others])
            self.say_bearings(name, "robots", own_ns, self.seen(name, places))

    def pose_at(self, name: str, now_ns: int) -> SE2:
        """Return where a robot is at a time."""
        return self.poses[name] @ self._moved(now_ns)

    @staticmethod
    def _moved(now_ns: int) -> SE2:
        """Return how far the robots are from their places."""
        phase = math.sin(2.0 * math.pi * (now_ns / 1e9) / SWAY_S)
        return SE2(SWAY_M * phase, 0.0, SWAY_RAD * phase)

    def seen(self, name: str, places: np.ndarray) -> np.ndarray:
        """Return noisy bearings from a robot's camera, in no order."""
        camera = self.pose_at(name, self._now_ns) @ MOUNT
        x, y = (places - [camera.x, camera.y]).T
        bearings = np.arctan2(y, x) - camera.yaw + self._rng.normal(0.0, NOISE, len(places))
        return np.asarray(self._rng.permutation(bearings))

    def say_bearings(self, name: str, kind: str, stamp_ns: int, bearings: np.ndarray) -> None:
        """Send bearings of a class."""
        msg = self.bearings_msg(name, stamp_ns, bearings)
        self._pubs[name, f"bearings/{kind}"].publish(msg)

    @staticmethod
    def bearings_msg(name: str, stamp_ns: int, bearings: np.ndarray) -> PoseArray:
        """Return bearings as a message; NaN goes out as NaN."""
        frame = f"{name}/omni_camera_floor"
        finite = [SE2(0.0, 0.0, 0.0 if math.isnan(b) else float(b)) for b in bearings]
        msg = poses_to_msg(finite, ns_to_stamp(stamp_ns), frame)
        for pose, value in zip(msg.poses, bearings, strict=True):
            if math.isnan(value):
                pose.orientation.z = pose.orientation.w = math.nan
        return msg

    def say_odometry(self, name: str, stamp_ns: int, pose: SE2) -> None:
        """Send odometry."""
        msg = odometry_to_msg(
            OdometryReading(pose), ns_to_stamp(stamp_ns), f"{name}/odom", f"{name}/base_link"
        )
        self._pubs[name, "odom"].publish(msg)

    def _say_pose(self, name: str, stamp_ns: int, lie: SE2 | None) -> None:
        true, error = self.pose_at(name, self._now_ns), self._rough[name]
        rough = SE2(
            true.x + ROUGH_M * error[0], true.y + ROUGH_M * error[1],
            true.yaw + ROUGH_RAD * error[2],
        )  # fmt: skip
        msg = PoseWithCovarianceStamped()
        msg.header.stamp, msg.header.frame_id = ns_to_stamp(stamp_ns), "map"
        msg.pose.pose = se2_to_pose(rough if lie is None else lie)
        msg.pose.covariance = se2_cov_to_ros(np.diag([ROUGH_M**2, ROUGH_M**2, ROUGH_RAD**2]))
        self._pubs[name, "pose"].publish(msg)
