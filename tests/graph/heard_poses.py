"""What the tests of one robot's localizers hear: its poses, what it says, map->odom, the truth."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from robot_messages import statuses
from tf2_msgs.msg import TFMessage

from floornav_common.ros.messages import (
    ns_to_stamp,
    pose_to_se2,
    se2_to_pose,
    stamp_to_ns,
    transform_from_msg,
)
from floornav_common.ros.qos import RELIABLE_QOS, TF_QOS
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import difference


class Heard:
    """What a localizer says.

    Args:
        peer: Who listens.
        topic: Of its poses; its part of the diagnostics is called so too.
        wait_s: How long it is given to answer each moment that is shown.
        most: So many moments are too many.
    """

    def __init__(self, peer: Any, topic: str, wait_s: float = 0.15, most: int = 400) -> None:
        self._peer, self._part = peer, topic.replace("_", " ")
        self._wait_s, self._most = wait_s, most
        self.poses = peer.collect(PoseWithCovarianceStamped, topic, RELIABLE_QOS)
        self.candidates = peer.collect(PoseArray, f"{topic}/candidates", RELIABLE_QOS)
        self.states: list[DiagnosticArray] = peer.collect(DiagnosticArray, "/diagnostics", 100)
        self.transforms: list[TFMessage] = peer.collect(TFMessage, "/tf", TF_QOS)
        peer.wait_to_hear(topic, f"{topic}/candidates", "/diagnostics", "/tf")

    def says(self, level: bytes, words: str, part: str = "") -> Callable[[], bool]:
        """Return whether the newest status of a part, of the pose by default, is so."""

        def is_so() -> bool:
            said = statuses(self.states, part or self._part)
            return bool(said) and said[-1].level == level and words in said[-1].message

        return is_so

    def see_until(self, robot: Any, is_done: Callable[[], bool], *what: Any, **how: Any) -> int:
        """Let a robot show the same again and again; return how often."""
        for num in range(1, self._most):
            robot.see(*what, **how)
            if self._peer.spin_until(is_done, self._wait_s, must=False):
                return num
        said = [(s.level, s.message) for a in self.states[-5:] for s in a.status]
        pytest.fail(f"not so after {self._most - 1} moments; last said: {said}")

    def map_to_odom(self) -> list[SE2]:
        """Return all of map->odom."""
        return [
            transform_from_msg(t.transform).to_se2()
            for m in self.transforms
            for t in m.transforms
            if (t.header.frame_id, t.child_frame_id) == ("map", "odom")
        ]


class HeardTruth:
    """Poses beside the true ones of the simulation, by stamp.

    Args:
        peer: Who listens.
        topic: Of the poses.
        truth: Topic of the true ones.
    """

    def __init__(self, peer: Any, topic: str, truth: str = "ground_truth/odom") -> None:
        self._peer, self._truth = peer, {}
        peer.node.create_subscription(Odometry, truth, self._keep, RELIABLE_QOS)
        self._poses = peer.collect(PoseWithCovarianceStamped, topic, RELIABLE_QOS)

    def _keep(self, msg: Odometry) -> None:
        self._truth[stamp_to_ns(msg.header.stamp)] = pose_to_se2(msg.pose.pose)

    def _pairs(self) -> list[tuple[PoseWithCovarianceStamped, SE2]]:
        stamped = [(m, stamp_to_ns(m.header.stamp)) for m in self._poses]
        return [(m, self._truth[stamp]) for m, stamp in stamped if stamp in self._truth]

    def wait_for(self, num: int, timeout: float) -> list[tuple[PoseWithCovarianceStamped, SE2]]:
        """Return the poses with the true ones, once there are so many."""
        self._peer.spin_until(lambda: len(self._pairs()) >= num, timeout)
        return self._pairs()


def is_near(msg: PoseWithCovarianceStamped, pose: SE2, near_m: float, near_rad: float) -> bool:
    x, y, yaw = np.abs(difference(pose_to_se2(msg.pose.pose), pose))
    return bool(max(x, y) < near_m and yaw < near_rad)


def odometry_of(T_odom_base: SE2, stamp_ns: int) -> Odometry:
    """Return what a robot's odometry says at a moment."""
    msg = Odometry(child_frame_id="base_link")
    msg.header.stamp, msg.header.frame_id = ns_to_stamp(stamp_ns), "odom"
    msg.pose.pose = se2_to_pose(T_odom_base)
    return msg
