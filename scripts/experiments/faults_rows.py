"""The faults of what sensors send, in the graph that drives by laser."""

from __future__ import annotations

import numpy as np

from experiments.faults_case import Fault, changing
from experiments.faults_changes import (
    Freeze,
    Lossy,
    Often,
    black,
    drop,
    edited,
    no_numbers,
    no_ranges,
    shift_stamps,
)
from experiments.faults_graph import FaultGraph
from experiments.faults_judge import BRAKE, DRIVE, HALT, OTHER

INPUT_S = 0.5
"""Limit of the planner on the silence of its inputs (default)."""
SONAR_S = 1.0
"""The same for sonars (default)."""
_MS = 1_000_000
_PERIODS_NS = {"scan": 100 * _MS, "odom": 20 * _MS, "sonar": 50 * _MS, "/tf": 20 * _MS}
_LOSS, _DELAY_NS = 0.3, 200 * _MS
_OLD_NS = -5_000 * _MS


def scan_faults() -> list[Fault]:
    """Return the faults of the laser."""
    late = "zero when the newest scan is 0.5 s old"
    return [
        Fault(
            name="scan-silent", what="no scan comes any more", kind=HALT, topic="scan",
            limit_s=INPUT_S, expected=late, **changing("scan", lambda: drop),
        ),
        Fault(
            name="scan-frozen", what="the same scan again and again, with its old stamp",
            kind=HALT, topic="scan", limit_s=INPUT_S, expected=late,
            is_first_good=True, **changing("scan", lambda: Freeze(keeps_stamp=True)),
        ),
        Fault(
            name="scan-stuck", what="the same ranges again and again, with new stamps",
            kind=HALT, topic="scan", limit_s=INPUT_S,
            expected="zero within 0.5 s, as the robot has moved and the ranges have not",
            is_first_good=True, **changing("scan", lambda: Freeze(keeps_stamp=False)),
        ),
        Fault(
            name="nan-ranges", what="every range is NaN: nothing is seen", kind=BRAKE, topic="scan",
            expected="brakes as hard as it may from the next period on",
            **changing("scan", lambda: edited(no_ranges)),
        ),
        Fault(
            name="nan-scan", what="every float of the scan is NaN, its angles too", kind=HALT,
            topic="scan", expected="zero in the next period",
            **changing("scan", lambda: edited(no_numbers)),
        ),
    ]  # fmt: skip


def other_sensor_faults() -> list[Fault]:
    """Return the faults of odometry, sonars and transforms."""
    old = "zero when the newest pose is 0.5 s old"
    return [
        Fault(
            name="odom-silent", what="no odometry message comes any more", kind=HALT, topic="odom",
            limit_s=INPUT_S, expected="zero when odometry is 0.5 s late",
            **changing("odom", lambda: drop),
        ),
        Fault(
            name="nan-odom", what="every float of odometry is NaN", kind=HALT, topic="odom",
            expected="zero in the next period", **changing("odom", lambda: edited(no_numbers)),
        ),
        Fault(
            name="sonar-silent", what="no sonar is heard any more", kind=HALT, topic="sonar",
            limit_s=SONAR_S, expected="zero when they are 1 s late", hold_s=3.5,
            **changing("sonar", lambda: drop),
        ),
        Fault(
            name="nan-sonar", what="every float of every reading is NaN", kind=HALT, topic="sonar",
            limit_s=SONAR_S, expected="as silence: zero after 1 s", hold_s=3.5,
            **changing("sonar", lambda: edited(no_numbers)),
        ),
        Fault(
            name="tf-silent", what="odom to base_link comes no more", kind=HALT, topic="/tf",
            limit_s=INPUT_S, expected=old, **changing("/tf", lambda: drop),
        ),
        Fault(
            name="tf-stale", what="odom to base_link bears stamps 5 s old", kind=HALT, topic="/tf",
            limit_s=INPUT_S, expected=old,
            **changing("/tf", lambda: edited(lambda msg: shift_stamps(msg, _OLD_NS))),
        ),
        Fault(
            name="nan-tf", what="every float of odom to base_link is NaN", kind=HALT, topic="/tf",
            limit_s=INPUT_S, expected=f"the transform is refused, and {old}",
            **changing("/tf", lambda: edited(no_numbers)),
        ),
    ]  # fmt: skip


def traffic_faults(seed: int) -> list[Fault]:
    """Return the faults of the way that messages take."""
    rng = np.random.default_rng(seed)

    def often(graph: FaultGraph) -> None:
        for topic, period_ns in _PERIODS_NS.items():
            graph.relay.set_change(topic, Often(10, period_ns))

    lossy = "scan odom sonar /tf omni/image_raw cmd_vel"
    return [
        Fault(
            name="rate-10x", what="ten times as many scans, readings, odometry and transforms",
            kind=DRIVE, expected="drives on", strike=often,
            mend=changing(" ".join(_PERIODS_NS), lambda: drop)["mend"],
        ),
        Fault(
            name="lossy-relay", kind=OTHER, hold_s=6.0,
            what="30 % of all messages lost, commands too, the others 200 ms late (by the relay)",
            expected="touches nothing: drives on what comes, or stands",
            **changing(lossy, lambda: Lossy(_LOSS, _DELAY_NS, rng)),
        ),
        Fault(
            name="camera-black", what="the camera is black; nothing drives by it here", kind=DRIVE,
            expected="drives on by laser",
            **changing("omni/image_raw", lambda: black),
        ),
    ]  # fmt: skip
