"""What a team's robots come to, as messages: poses, markers, other things, map->odom."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Pose, PoseArray, PoseWithCovarianceStamped
from visualization_msgs.msg import MarkerArray

from floornav_common.ros.map_to_odom import MapToOdom
from floornav_common.ros.messages import ns_to_stamp, poses_to_msg, se2_to_pose
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.odometry import OdometryFallback
from floornav_common.ros.qos import RELIABLE_QOS, create_publisher
from floornav_common.se2 import SE2
from floornav_common.transform_buffer import TransformUnavailable
from multi_localizer.nodes.team_markers import team_markers
from multi_localizer.ros_conversions import estimate_to_msg
from multi_localizer.team_answers import TeamAnswer

_NAN = float("nan")


class TeamOutputs:
    """Publishes answers.

    Args:
        node: The node.
        team: Namespaces in order.
        own: That of this robot; "" if it is none of them.
        publishes_all: Whether every robot's `team_pose` is published from here.
        publish_tf: Whether map->odom of this robot is sent.
    """

    def __init__(
        self,
        node: FloornavNode,
        team: Sequence[str],
        own: str,
        publishes_all: bool,
        publish_tf: bool,
    ) -> None:
        """Make the publishers."""
        self._node, self._team, self._own = node, team, own
        topics = {name: f"/{name}/team_pose" for name in team} if publishes_all else {}
        if own:
            topics[own] = "team_pose"
        self._poses = {
            name: create_publisher(node, PoseWithCovarianceStamped, topic, RELIABLE_QOS)
            for name, topic in topics.items()
        }
        self._all = create_publisher(node, PoseArray, "team/poses", RELIABLE_QOS)
        self._markers = create_publisher(node, MarkerArray, "team/markers", RELIABLE_QOS)
        self._objects = create_publisher(node, PoseArray, "objects", RELIABLE_QOS)
        self._tf = MapToOdom(node) if publish_tf and own else None
        self._waiting: tuple[int, SE2] | None = None
        self._odometry = OdometryFallback(node) if self._tf is not None else None

    def publish(self, answer: TeamAnswer) -> None:
        """Publish an answer, with the stamp of its moment."""
        stamp, frame = ns_to_stamp(answer.moment.stamp_ns), self._node.frames.map
        for name, publisher in self._poses.items():
            if name in answer.bases:
                publisher.publish(estimate_to_msg(answer.bases[name], stamp, frame))
        self._all.publish(self._team_poses(answer, stamp, frame))
        self._markers.publish(team_markers(answer, self._own, stamp, frame))
        places = [SE2(*map(float, o.position), 0.0) for o in answer.solution.objects]
        self._objects.publish(poses_to_msg(places, stamp, frame))
        own = answer.bases.get(self._own)
        self._waiting = None if own is None else (answer.moment.stamp_ns, own.pose)
        if own is None:
            self.stop_tf()
        self.look_at_tf()

    def look_at_tf(self) -> None:
        """Take map->odom from the newest pose, once the odometry has come as far."""
        if self._tf is None or self._waiting is None:
            return
        frames, (stamp_ns, pose) = self._node.frames, self._waiting
        try:
            T_odom_base = self._node.transforms.buffer.lookup(frames.odom, frames.base, stamp_ns)
        except (TransformUnavailable, ValueError):
            return
        self._waiting = None
        self._tf.set(pose @ T_odom_base.to_se2().inverse())

    def stop_tf(self) -> None:
        """Send map->odom no more until the next answer."""
        self._waiting = None
        if self._tf is not None:
            self._tf.set(None)

    def _team_poses(self, answer: TeamAnswer, stamp: Any, frame: str) -> PoseArray:
        """Return one pose a robot in the order of the team; NaN for those not known."""
        msg = PoseArray(poses=[_pose_or_nan(answer, name) for name in self._team])
        msg.header.stamp, msg.header.frame_id = stamp, frame
        return msg


def _pose_or_nan(answer: TeamAnswer, name: str) -> Pose:
    if name in answer.bases:
        return se2_to_pose(answer.bases[name].pose)
    pose = Pose()
    pose.position.x = pose.position.y = pose.position.z = _NAN
    q = pose.orientation
    q.x = q.y = q.z = q.w = _NAN
    return pose
