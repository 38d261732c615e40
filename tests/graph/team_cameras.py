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

from floornav_common.ros.messages import ns_to_stamp, pose_to_se2
from floornav_common.ros.qos import CLOCK_QOS, RELIABLE_QOS

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
    first = args.names[0]
    heard = [
        node.create_subscription(PoseWithCovarianceStamped, f"/{first}/team_pose", say_pose, 10),
        node.create_subscription(PoseArray, f"/{first}/team/poses", say_poses, 10),
        node.create_subscription(DiagnosticArray, "/diagnostics", say_parts(first), 10),
    ]
    print("ready", len(heard), flush=True)
    last_ns = 0
    while rclpy.ok():
        now_ns = time.time_ns() + round(1e9 * args.ahead)
        clock.publish(Clock(clock=ns_to_stamp(now_ns)))
        if now_ns - last_ns >= ROUND_NS:
            last_ns = now_ns
            voices.say(now_ns)
        rclpy.spin_once(node, timeout_sec=CLOCK_S)
    return 0


def say_pose(msg: PoseWithCovarianceStamped) -> None:
    print("team_pose", *pose_to_se2(msg.pose.pose).as_array(), flush=True)


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
