"""For every rule of a consumer a message that breaks it, and one that does not."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

from grid_mapper.contract import judge as judging
from grid_mapper.contract.rule import FAILED, OPEN, PASSED, Topic, Verdict
from grid_mapper.contract.scans import expected_beams

S_NS = 10**9
STEP = 2.0 * math.pi / 180.0
SCAN, RANGE = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Range"
ODOM, POSE = "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseWithCovarianceStamped"
MAP, TF = "nav_msgs/msg/OccupancyGrid", "tf2_msgs/msg/TFMessage"
Break = Callable[[Any], None]


def vector(**values: float) -> Made:
    return Made(**{"x": 0.0, "y": 0.0, "z": 0.0, **values})


def header(frame: str, second: int = 5) -> Made:
    return Made(frame_id=frame, stamp=Made(sec=second, nanosec=0))


def pose() -> Made:
    return Made(position=vector(), orientation=vector(w=1.0))


def cov() -> list[float]:
    return (np.eye(6) * 0.01).ravel().tolist()


def good(msgtype: str) -> Any:
    """Return a message that breaks no rule."""
    if msgtype == SCAN:
        return Made(
            header=header("laser"), angle_min=-math.pi, angle_max=-math.pi + 179 * STEP,
            angle_increment=STEP, time_increment=0.0, scan_time=0.0, range_min=0.1, range_max=5.0,
            ranges=[math.inf, math.nan, -math.inf, 0.1, 5.0] + [1.0] * 175, intensities=[],
        )  # fmt: skip
    if msgtype == RANGE:
        return Made(
            header=header("laser"), field_of_view=0.5, radiation_type=0, min_range=0.1,
            max_range=2.0, range=math.inf,
        )  # fmt: skip
    if msgtype == ODOM:
        speeds = Made(linear=vector(), angular=vector())
        return Made(
            header=header("odom"), child_frame_id="base_link",
            pose=Made(pose=pose(), covariance=cov()), twist=Made(twist=speeds, covariance=cov()),
        )  # fmt: skip
    if msgtype == POSE:
        return Made(header=header("odom"), pose=Made(pose=pose(), covariance=cov()))
    if msgtype == MAP:
        info = Made(resolution=0.05, width=2, height=2, origin=pose())
        return Made(header=header("map"), info=info, data=[-1, 0, 50, 100])
    return Made(transforms=[transform("odom", "base_link"), transform("base_link", "laser")])


def transform(parent: str, child: str) -> Made:
    return Made(
        header=header(parent), child_frame_id=child,
        transform=Made(translation=vector(), rotation=vector(w=1.0)),
    )  # fmt: skip


def profile(*, reliable: bool = True, latched: bool = False) -> Qos:
    none = QosTime(0, 0)
    return Qos(
        QosHistory.KEEP_LAST, 5,
        QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        none, none, QosLiveliness.AUTOMATIC, none, False,
    )  # fmt: skip


def topic_of(msgtype: str, *messages: Any, qos: Qos | None = None) -> Topic:
    own = [profile(latched=msgtype == MAP) if qos is None else qos]
    return Topic(f"/{msgtype}", msgtype, own, list(messages), [5 * S_NS] * len(messages))


def verdicts(*topics: Topic) -> dict[tuple[str, str], Verdict]:
    return {(v.topic, v.rule.name): v for v in judging.judge(topics)}


def failed(*topics: Topic) -> set[str]:
    return {rule for (_, rule), v in verdicts(*topics).items() if v.result == FAILED}


TREE = topic_of(TF, good(TF))


@pytest.mark.parametrize("msgtype", [SCAN, RANGE, ODOM, POSE, MAP, TF])
def test_a_good_message_breaks_no_rule(msgtype: str) -> None:
    found = verdicts(topic_of(msgtype, good(msgtype)), TREE)
    assert {v.result for v in found.values()} == {PASSED}


def put(path: str, value: Any) -> Break:
    """Return what sets a field such as `pose.pose.position.x`, or an element such as `data.2`."""

    def change(message: Any) -> None:
        *parts, last = path.split(".")
        at = message
        for part in parts:
            at = at[int(part)] if part.isdigit() else getattr(at, part)
        if last.isdigit():
            at[int(last)] = value
        else:
            setattr(at, last, value)

    return change


BROKEN: list[tuple[str, Break, str]] = [
    (SCAN, put("header.frame_id", ""), "frame_id"),
    (SCAN, put("header.frame_id", "/laser"), "frame_id"),
    (SCAN, put("header.stamp.sec", 0), "stamps"),
    (SCAN, put("header.stamp.sec", 6), "age"),
    (SCAN, put("header.stamp.sec", -6), "age"),
    (SCAN, put("header.frame_id", "nowhere"), "in the tree"),
    (SCAN, lambda m: m.ranges.pop(), "beam count"),
    (SCAN, put("angle_max", math.pi + STEP), "beam count"),
    (SCAN, put("angle_increment", 0.0), "angles"),
    (SCAN, put("angle_min", math.nan), "angles"),
    (SCAN, put("angle_max", 4.0), "angles"),
    (SCAN, put("angle_increment", -STEP), "angles"),
    (SCAN, put("range_max", math.inf), "limits"),
    (SCAN, put("range_min", 6.0), "limits"),
    (SCAN, put("ranges.7", 0.0), "values"),
    (SCAN, put("ranges.7", 5.1), "values"),
    (SCAN, put("time_increment", -0.1), "beam times"),
    (SCAN, put("scan_time", math.nan), "beam times"),
    (SCAN, put("intensities", [1.0]), "intensities"),
    (RANGE, put("field_of_view", 0.0), "cone"),
    (RANGE, put("radiation_type", 2), "cone"),
    (RANGE, put("max_range", 0.05), "cone"),
    (RANGE, put("range", 2.5), "values"),
    (ODOM, put("child_frame_id", ""), "child frame"),
    (ODOM, put("child_frame_id", "odom"), "child frame"),
    (ODOM, put("twist.twist.angular.z", math.nan), "finite"),
    (ODOM, put("pose.pose.orientation.w", 0.9), "quaternion"),
    (ODOM, put("twist.covariance.0", -1.0), "covariance"),
    (ODOM, put("pose.covariance.1", 0.005), "covariance"),
    (ODOM, put("pose.covariance.35", 0.0), "variances"),
    (ODOM, put("twist.covariance.0", 0.0), "variances"),
    (ODOM, put("pose.covariance.35", 1000.0), "not inflated"),
    (POSE, put("pose.pose.position.x", math.inf), "finite"),
    (POSE, put("pose.pose.orientation.w", 0.0), "quaternion"),
    (POSE, put("pose.covariance", [math.nan] * 36), "covariance"),
    (POSE, put("pose.covariance.7", 0.0), "variances"),
    (POSE, put("pose.covariance.7", 1e6), "not inflated"),
    (MAP, put("info.resolution", 0.0), "size"),
    (MAP, put("data", [0, 0, 0]), "size"),
    (MAP, put("data.2", 101), "cells"),
    (MAP, put("info.origin.position.x", math.nan), "origin"),
    (MAP, put("info.origin.orientation.z", 1.0), "origin"),
    (MAP, put("info.origin.orientation", vector(z=0.6, w=0.8)), "not turned"),
    (TF, put("transforms.0.child_frame_id", "/base_link"), "frame_id"),
    (TF, put("transforms.0.transform.rotation.w", 0.5), "quaternion"),
    (TF, put("transforms.0.child_frame_id", "odom"), "one parent"),
    (TF, put("transforms.0.child_frame_id", "laser"), "one parent"),
]


@pytest.mark.parametrize(("msgtype", "change", "rule"), BROKEN)
def test_a_message_that_breaks_a_rule_is_found(msgtype: str, change: Break, rule: str) -> None:
    message = copy.deepcopy(good(msgtype))
    change(message)
    others = () if msgtype == TF else (TREE,)
    assert rule in failed(topic_of(msgtype, message), *others)


def test_every_rule_has_a_message_that_breaks_it() -> None:
    elsewhere = {"full circle", "same laser", "QoS"}
    assert {rule.name for rule in judging.RULES} == {rule for *_, rule in BROKEN} | elsewhere


def test_a_full_circle_that_repeats_its_first_beam_is_found() -> None:
    scan = good(SCAN)
    scan.ranges.append(1.0)
    scan.angle_max += STEP
    assert failed(topic_of(SCAN, scan), TREE) == {"full circle"}


@pytest.mark.parametrize("field", ["ranges", "range_max", "angle_min"])
def test_a_scan_unlike_the_first_is_found_and_counted(field: str) -> None:
    first, last = good(SCAN), good(SCAN)
    last.header.stamp.sec = 6
    setattr(last, field, [1.0] * 179 if field == "ranges" else getattr(last, field) + 0.5)
    topic = topic_of(SCAN, first, last)
    topic.arrived_ns[1] = 6 * S_NS
    assert verdicts(topic, TREE)[topic.name, "same laser"].text.startswith("1 of 2: ")


def test_a_stamp_that_is_not_later_is_found_unless_another_sensor_sent_it() -> None:
    same = topic_of(SCAN, good(SCAN), good(SCAN))
    assert failed(same, TREE) == {"stamps"}
    other = good(RANGE)
    other.header.frame_id = "base_link"
    assert failed(topic_of(RANGE, good(RANGE), other), TREE) == set()


def test_a_sweep_longer_than_its_scan_time_is_found() -> None:
    scan = good(SCAN)
    scan.time_increment, scan.scan_time = 0.001, 0.1
    assert failed(topic_of(SCAN, scan), TREE) == {"beam times"}


@pytest.mark.parametrize(
    ("msgtype", "qos", "is_kept"),
    [
        (SCAN, profile(reliable=False), True),
        (RANGE, profile(reliable=False), True),
        (ODOM, profile(reliable=False), False),
        (POSE, profile(reliable=False), False),
        (MAP, profile(latched=True), True),
        (MAP, profile(latched=False), False),
        (MAP, profile(reliable=False, latched=True), False),
        (TF, profile(), True),
    ],
)
def test_qos_must_be_what_subscribers_ask_for(msgtype: str, qos: Qos, is_kept: bool) -> None:
    topic = topic_of(msgtype, good(msgtype), qos=qos)
    assert (verdicts(topic)[topic.name, "QoS"].result == PASSED) == is_kept


def test_static_transforms_must_be_latched() -> None:
    topic = Topic("/tf_static", TF, [profile()], [good(TF)], [0])
    assert failed(topic) == {"QoS"}


def test_what_is_not_known_is_not_judged() -> None:
    topic = topic_of(SCAN, good(SCAN))
    topic.qos, topic.arrived_ns = [], [10**18]
    found = verdicts(topic)
    for rule in ("QoS", "age", "in the tree"):
        assert found[topic.name, rule].result == OPEN
    silent = verdicts(topic_of(SCAN))
    assert PASSED not in {v.result for (_, rule), v in silent.items() if rule != "QoS"}


@pytest.mark.parametrize(
    ("span", "num", "expected"),
    [
        (179.0, 180, 180),  # the last beam's angle: [0, 360)
        (180.0, 180, 180),  # the angle behind it: slam_toolbox takes a full circle so
        (180.0, 181, 181),  # [0, 360]
        (90.0, 91, 91),
        (90.0, 90, 91),
    ],
)
def test_the_expected_beams_are_slam_toolboxs(span: float, num: int, expected: int) -> None:
    assert expected_beams(-1.0, -1.0 + span * STEP, STEP, num) == expected
