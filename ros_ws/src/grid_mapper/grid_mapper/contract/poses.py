"""Rules for Odometry and PoseWithCovarianceStamped."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from grid_mapper.contract.rule import Rule, Topic, Verdict, judge_each

_PREPARING = "robot_localization doc/preparing_sensor_data.rst"
_PLANAR = {"x": 0, "y": 1, "yaw": 5}
INFLATED = 1e3
_UNIT = 0.01

NUMBERS = Rule(
    "finite", "position, orientation and twist are finite",
    "AMCL (initial pose), robot_localization",
    "nav2_amcl amcl_node.cpp publishAmclPose; robot_localization src/ros_filter.cpp",
)  # fmt: skip
QUATERNION = Rule(
    "quaternion", "orientations have unit length", "tf2, robot_localization",
    "tf2 src/buffer_core.cpp setTransform: DENORMALIZED_QUATERNION; REP 103",
)  # fmt: skip
CHILD = Rule(
    "child frame", "child_frame_id is given, and another than frame_id",
    "robot_localization: the twist is in it", f"{_PREPARING}; nav_msgs/Odometry.msg; REP 105",
)  # fmt: skip
COVARIANCE = Rule(
    "covariance", "36 finite numbers, symmetric, no negative variance or eigenvalue",
    "robot_localization, AMCL", "geometry_msgs/PoseWithCovariance.msg; REP 103",
)  # fmt: skip
VARIANCE = Rule(
    "variances", "those of x, y and yaw are not 0 (missing)",
    "robot_localization", f"{_PREPARING}: Missing covariances",
)  # fmt: skip
NOT_INFLATED = Rule(
    "not inflated", "variances of x, y and yaw are below 1000: large ones do not switch off",
    "robot_localization", f"{_PREPARING}: Inflated covariances",
)  # fmt: skip

RULES = (NUMBERS, QUATERNION, CHILD, COVARIANCE, VARIANCE, NOT_INFLATED)


def judge_odometry(topic: Topic) -> list[Verdict]:
    """Return the verdicts on a topic of Odometry."""
    return [
        judge_each(topic, CHILD, child_problem),
        judge_each(topic, NUMBERS, lambda m: numbers_problem(m.pose.pose, m.twist.twist)),
        judge_each(topic, QUATERNION, lambda m: quaternion_problem(m.pose.pose.orientation)),
        judge_each(topic, COVARIANCE, covariances_problem),
        judge_each(
            topic, VARIANCE, lambda m: variance_problem(m.pose.covariance, m.twist.covariance)
        ),
        judge_each(topic, NOT_INFLATED, lambda m: inflated_problem(m.pose.covariance)),
    ]


def judge_poses(topic: Topic) -> list[Verdict]:
    """Return the verdicts on a topic of PoseWithCovarianceStamped."""
    return [
        judge_each(topic, NUMBERS, lambda m: numbers_problem(m.pose.pose)),
        judge_each(topic, QUATERNION, lambda m: quaternion_problem(m.pose.pose.orientation)),
        judge_each(topic, COVARIANCE, lambda m: covariance_problem(m.pose.covariance)),
        judge_each(topic, VARIANCE, lambda m: variance_problem(m.pose.covariance)),
        judge_each(topic, NOT_INFLATED, lambda m: inflated_problem(m.pose.covariance)),
    ]


def child_problem(odom: Any) -> str:
    """Return what is wrong with the child frame."""
    if not odom.child_frame_id:
        return "child_frame_id is empty"
    if odom.child_frame_id == odom.header.frame_id:
        return f"frame_id and child_frame_id are both {odom.child_frame_id}"
    return ""


def numbers_problem(pose: Any, speeds: Any | None = None) -> str:
    """Return which numbers of a pose and a twist are not finite."""
    parts = {"position": pose.position, "orientation": pose.orientation}
    if speeds is not None:
        parts |= {"linear": speeds.linear, "angular": speeds.angular}
    bad = [
        f"{name}.{axis} {getattr(part, axis)}"
        for name, part in parts.items()
        for axis in ("x", "y", "z", "w")
        if not math.isfinite(getattr(part, axis, 0.0))
    ]
    return ", ".join(bad)


def quaternion_problem(q: Any) -> str:
    """Return whether a quaternion has another length than 1."""
    length = math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)
    return "" if abs(length - 1.0) < _UNIT else f"length {length:g}"


def covariance_problem(covariance: Any) -> str:
    """Return what makes 36 numbers no covariance."""
    cov = np.asarray(covariance, dtype=float)
    if cov.size != 36 or not np.isfinite(cov).all():
        return "not 36 finite numbers"
    cov = cov.reshape(6, 6)
    if (np.diag(cov) < 0.0).any():
        return f"a variance of {np.diag(cov).min():g}"
    slack = 1e-6 * max(float(np.abs(cov).max()), 1e-9)
    if np.abs(cov - cov.T).max() > slack:
        return "not symmetric"
    if np.linalg.eigvalsh(cov).min() < -slack:
        return f"an eigenvalue of {np.linalg.eigvalsh(cov).min():g}"
    return ""


def covariances_problem(odom: Any) -> str:
    """Return what makes an Odometry's covariances none."""
    parts = {"pose": odom.pose, "twist": odom.twist}
    texts = {name: covariance_problem(part.covariance) for name, part in parts.items()}
    return ", ".join(f"{name}: {text}" for name, text in texts.items() if text)


def variance_problem(covariance: Any, twist_covariance: Any | None = None) -> str:
    """Return which variances of the plane's motion are 0; of a twist, x and yaw."""
    missing = [f"pose {n}" for n, k in _PLANAR.items() if not covariance[7 * k] > 0.0]
    if twist_covariance is not None:
        missing += [f"twist {n}" for n in ("x", "yaw") if not twist_covariance[7 * _PLANAR[n]] > 0]
    return f"0 for {', '.join(missing)}" if missing else ""


def inflated_problem(covariance: Any) -> str:
    """Return which variances of x, y, yaw are so large that they mean `ignore me`."""
    large = [
        f"{n} {covariance[7 * k]:g}" for n, k in _PLANAR.items() if covariance[7 * k] >= INFLATED
    ]
    return ", ".join(large)
