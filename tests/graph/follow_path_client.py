"""A client of Nav2's FollowPath for tests: does what its input says, prints what comes back.

`send FRAME X Y [X Y ...]` sends a path, `cancel` cancels the newest; each goal has a number.
"""

from __future__ import annotations

import contextlib
import sys
import threading
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException


class Client:
    """Sends goals and prints answers."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("test_follow_path_client")
        self._client = ActionClient(self.node, FollowPath, "follow_path")
        self._handles: list[Any] = []

    def obey(self) -> None:
        """Do what the input says, line by line."""
        self._client.wait_for_server()
        print("server is there", flush=True)
        for line in sys.stdin:
            word, *rest = line.split()
            if word == "send":
                self._send(rest[0], [float(v) for v in rest[1:]])
            else:
                self._handles[-1].cancel_goal_async()

    def _send(self, frame: str, numbers: list[float]) -> None:
        goal = FollowPath.Goal()
        goal.path.header.frame_id = frame
        for x, y in zip(numbers[::2], numbers[1::2], strict=True):
            pose = PoseStamped(header=goal.path.header)
            pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = x, y, 1.0
            goal.path.poses.append(pose)
        number = len(self._handles)
        self._handles.append(None)

        def told(message: Any) -> None:
            feedback = message.feedback
            print(
                f"feedback {number} {feedback.distance_to_goal:.2f} {feedback.speed:.2f}",
                flush=True,
            )

        def accepted(future: Any) -> None:
            handle = self._handles[number] = future.result()
            print(f"accepted {number} {handle.accepted}", flush=True)
            handle.get_result_async().add_done_callback(ended)

        def ended(future: Any) -> None:
            answer = future.result()
            result = answer.result
            text = f"result {number} {answer.status} {result.error_code} {result.error_msg}"
            print(text.strip(), flush=True)

        self._client.send_goal_async(goal, feedback_callback=told).add_done_callback(accepted)


def main() -> None:
    """Run until the input ends."""
    rclpy.init()
    client = Client()
    threading.Thread(target=client.obey, daemon=True).start()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(client.node)


if __name__ == "__main__":
    main()
