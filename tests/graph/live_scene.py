"""A robot in a room as the live view's tests need it: every topic that the page draws."""

from __future__ import annotations

from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import OccupancyGrid, Path
from robot_messages import LATCHED, tf_of, time_of
from sensor_msgs.msg import Image, LaserScan, Range
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

CELL_M = 0.1
WIDTH, HEIGHT = 80, 40  # cells: a room of 6 x 4 m, its corner at (-1, -1), and 2 m not known
ROOM_COLS = 60
CORNER = -1.0
GLASS_COL = 50
NodeProcess = Peer = Any  # of conftest.py


def room(cells: np.ndarray, frame: str = "map") -> OccupancyGrid:
    """Return a map of cells, shape (H, W)."""
    msg = OccupancyGrid()
    msg.header.frame_id = frame
    msg.info.height, msg.info.width = cells.shape
    msg.info.resolution = CELL_M
    msg.info.origin.position.x = msg.info.origin.position.y = CORNER
    msg.info.origin.orientation.w = 1.0
    msg.data = cells.ravel().tolist()
    return msg


def room_cells() -> np.ndarray:
    """Return the room: free, with walls around, and beside it nothing known."""
    cells = np.full((HEIGHT, WIDTH), -1, dtype=np.int8)
    cells[:, :ROOM_COLS] = 100
    cells[1:-1, 1 : ROOM_COLS - 1] = 0
    return cells


def glass_cells() -> np.ndarray:
    """Return a pane across the room."""
    cells = np.full((HEIGHT, WIDTH), -1, dtype=np.int8)
    cells[5:35, GLASS_COL] = 100
    return cells


def circle(name: str, x: float, y: float, radius: float, frame: str) -> Marker:
    """Return a circle of lines, as the planner draws zones and people."""
    turn = np.linspace(0.0, 2.0 * np.pi, 17)
    ends = [(x + radius * np.cos(t), y + radius * np.sin(t)) for t in turn]
    marker = Marker(type=Marker.LINE_LIST, ns=name, color=ColorRGBA(r=1.0, a=1.0))
    marker.header.frame_id = frame
    marker.pose.orientation.w = 1.0
    for start, end in zip(ends, ends[1:], strict=False):
        marker.points += [Point(x=px, y=py) for px, py in (start, end)]
    return marker


class Scene:
    """The robot's nodes: the robot stands 1 m into its map, its laser 0.5 m ahead on it.

    Args:
        peer: The test's side.
        node: The live view; None to publish whether it hears or not.
        namespace: Of the robot, such as `/r2`.
        prefix: Of its frames, such as `r2/`.
        tf: Its TF topic.
    """

    def __init__(
        self, peer: Peer, node: NodeProcess, namespace: str = "", prefix: str = "", tf: str = "/tf"
    ) -> None:
        self.peer, self.prefix, self.ns = peer, prefix, namespace
        self.tf = peer.publisher(TFMessage, tf, 100, to=node)
        self.maps = self._publisher(OccupancyGrid, "map", LATCHED, node)
        self.scans = self._publisher(LaserScan, "scan", 10, node)

    def _publisher(self, kind: type, topic: str, qos: Any, node: NodeProcess) -> Any:
        return self.peer.publisher(kind, f"{self.ns}/{topic}", qos, to=node)

    def stand(self) -> None:
        """Say where the robot is, and what its laser sees: walls 2 m ahead and 1 m to the left."""
        stamp_ns = self.peer.node.get_clock().now().nanoseconds
        chain = (("map", "odom", 1.0), ("odom", "base_link", 0.0), ("base_link", "laser", 0.5))
        transforms: list[Any] = []
        for parent, child, x in chain:
            names = self.prefix + parent, self.prefix + child
            transforms += tf_of(*names, stamp_ns, x).transforms
        self.tf.publish(TFMessage(transforms=transforms))
        msg = LaserScan(angle_increment=np.pi / 2, range_min=0.1, range_max=10.0)
        msg.ranges = [2.0, 1.0]
        msg.header.stamp, msg.header.frame_id = time_of(stamp_ns), f"{self.prefix}laser"
        self.scans.publish(msg)
        self.peer.spin(0.05)

    def begin_all(self, node: NodeProcess) -> None:
        """Make the publishers of all that is not needed."""
        self.glass = self._publisher(OccupancyGrid, "map/glass", LATCHED, node)
        self.paths = self._publisher(Path, "path", LATCHED, node)
        self.sonars = self._publisher(Range, "sonar", 10, node)
        self.markers = self._publisher(MarkerArray, "planner/markers", 10, node)
        self.states = self._publisher(DiagnosticStatus, "planner/state", 10, node)
        self.images = self._publisher(Image, "floor/overlay", 10, node)
        self.diagnostics = self.peer.publisher(DiagnosticArray, "/diagnostics", 10, to=None)
        self.maps.publish(room(room_cells(), self.prefix + "map"))
        self.glass.publish(room(glass_cells(), self.prefix + "map"))
        self.paths.publish(self.path([(1.0, 0.0), (1.0, 2.0), (3.5, 2.0)]))

    def path(self, places: list[tuple[float, float]]) -> Path:
        """Return a way over places."""
        msg = Path()
        msg.header.frame_id = f"{self.prefix}map"
        for x, y in places:
            pose = PoseStamped(header=msg.header)
            pose.pose.position.x, pose.pose.position.y = x, y
            msg.poses.append(pose)
        return msg

    def say_all(self) -> None:
        """Say everything that goes on and on."""
        base = f"{self.prefix}base_link"
        sonar = Range(field_of_view=0.5, min_range=0.1, max_range=3.0, range=0.8)
        sonar.header.frame_id = f"{self.prefix}laser"
        self.sonars.publish(sonar)
        zone, person = circle("zones", 0.0, 0.0, 0.6, base), circle("people", 1.5, 1.5, 0.3, base)
        self.markers.publish(MarkerArray(markers=[zone, person]))
        values = {"state": "waiting", "reason": "a person is on the way", "waited (s)": "1.5"}
        self.states.publish(
            DiagnosticStatus(
                level=DiagnosticStatus.WARN,
                name="planning",
                message="waiting",
                values=[KeyValue(key=k, value=v) for k, v in values.items()],
            )  # fmt: skip
        )
        parts = [
            DiagnosticStatus(level=DiagnosticStatus.ERROR, name="/driver: motor", message="hot"),
            DiagnosticStatus(level=DiagnosticStatus.OK, name="/driver: wheels", message="turn"),
        ]
        self.diagnostics.publish(DiagnosticArray(status=parts))
        image = Image(encoding="bgr8", height=40, width=60, step=180)
        image.data = np.tile(np.array([20, 160, 20], np.uint8), 40 * 60).tobytes()
        self.images.publish(image)
        self.stand()
