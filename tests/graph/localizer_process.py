"""Another localizer: `localizer_process.py [JUMP_NS]` sends map->odom for each odom->base_link.

It places the odometry frame at (2, 1) turned by 90 degrees in the map; from stamp JUMP_NS on it
is 1 m farther along x of the map, as AMCL's pose is after it has found a mistake.
"""

from __future__ import annotations

import sys

from tf2_msgs.msg import TFMessage

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import stamp_to_ns
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.qos import TF_QOS
from floornav_common.ros.transforms import TransformBroadcaster
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3

PLACE, JUMP = SE2(2.0, 1.0, 1.5707963), SE2(1.0, 0.0, 0.0)


class Localizer(FloornavNode):
    """Answers each odometry sample on /tf with a sample of its own."""

    def __init__(self) -> None:
        super().__init__("localizer")
        self._jump_ns = int(sys.argv[1]) if len(sys.argv) > 1 else None
        self._tf = TransformBroadcaster(self)
        self.create_subscription(TFMessage, "/tf", self._on_tf, TF_QOS)
        self.get_logger().info("ready")

    def _on_tf(self, msg: TFMessage) -> None:
        for stamped in msg.transforms:
            if stamped.header.frame_id == "odom":
                stamp_ns = stamp_to_ns(stamped.header.stamp)
                has_jumped = self._jump_ns is not None and stamp_ns >= self._jump_ns
                place = JUMP @ PLACE if has_jumped else PLACE
                self._tf.send("map", "odom", stamp_ns, Transform3.from_se2(place))


if __name__ == "__main__":
    sys.exit(run_node(Localizer, []))
