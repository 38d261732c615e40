"""Cameras of robots of `team_scene`: `team_cameras.py --names NAME... --team NAME... --ahead S`.

With `--ahead` it also sends `/clock`, that much ahead of the machine's own: a host whose clock is
wrong. What its nodes find is printed, one line a pose and one a diagnosis.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from rosgraph_msgs.msg import Clock
from team_scene import POSES, TeamVoices

from floornav_common.ros.messages import ns_to_stamp, stamp_to_ns
from floornav_common.ros.qos import CLOCK_QOS, RELIABLE_QOS
from floornav_common.se2 import SE2
from multi_localizer.pose_estimate import normalized_error
from multi_localizer.ros_conversions import estimate_from_msg

ROUND_NS, CLOCK_S = 100_000_000, 0.01


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--names", nargs="+", required=True)
    parser.add_argument("--team", nargs="+", default=list(POSES))
    parser.add_argument("--ahead", type=float, default=0.0)
    args = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("cameras", namespace=args.names[0])
    make = lambda kind, topic: node.create_publisher(kind, topic, RELIABLE_QOS)  # noqa: E731
    voices = TeamVoices(node, args.names, 0, make, {name: POSES[name] for name in args.team})
    clock = node.create_publisher(Clock, "clock", CLOCK_QOS)
    first, ahead_ns = args.names[0], round(1e9 * args.ahead)

    def on_pose(msg: PoseWithCovarianceStamped) -> None:
        say_pose(msg, voices.pose_at(first, stamp_to_ns(msg.header.stamp) - ahead_ns))

    heard = [
        node.create_subscription(PoseWithCovarianceStamped, f"/{first}/team_pose", on_pose, 10),
        node.create_subscription(PoseArray, f"/{first}/team/poses", say_poses, 10),
        node.create_subscription(DiagnosticArray, "/diagnostics", say_parts(first), 10),
    ]
    print("ready", len(heard), flush=True)
    behind = dict.fromkeys(args.names, -args.ahead)
    last_ns = 0
    while rclpy.ok():
        now_ns = time.time_ns()
        clock.publish(Clock(clock=ns_to_stamp(now_ns + ahead_ns)))
        if now_ns - last_ns >= ROUND_NS:
            last_ns = now_ns
            voices.say(now_ns, behind_s=behind)
        rclpy.spin_once(node, timeout_sec=CLOCK_S)
    return 0


def say_pose(msg: PoseWithCovarianceStamped, true: SE2) -> None:
    """Print a pose and its squared deviation from the truth in the deviations it claims."""
    estimate = estimate_from_msg(msg)
    square = normalized_error(estimate.pose, true, estimate.cov)
    print("team_pose", *estimate.pose.as_array(), square, flush=True)


def say_poses(msg: PoseArray) -> None:
    values = [(p.position.x, p.position.y) for p in msg.poses]
    print("team/poses", *(v for pair in values for v in pair), flush=True)


def say_parts(own: str) -> Callable[[DiagnosticArray], None]:
    def say(msg: DiagnosticArray) -> None:
        for status in msg.status:
            if status.name.startswith(f"/{own}/team_localizer: robot "):
                robot = status.name.rpartition(" ")[2]
                values = " ".join(f"{v.key}={v.value};" for v in status.values)
                print("says", robot, status.message, "|", values, flush=True)

    return say


if __name__ == "__main__":
    sys.exit(main())
