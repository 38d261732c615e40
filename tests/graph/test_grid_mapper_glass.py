"""Glass over DDS: layers beside our own poses, and beside another localizer in its own process."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "grid_mapper"))

from robot_messages import hear_diagnostics, statuses
from worlds import scan_at, square_room

from floornav_common.grid import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from floornav_common.readings import RangeReading
from floornav_common.se2 import SE2
from floornav_common.transform3 import Transform3
from grid_mapper.map_files import load_map

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")

HERE = Path(__file__).parent
NODE = (HERE / "listening.py", "grid_mapper.nodes.grid_mapper_node")
LOCALIZER = HERE / "localizer_process.py"
LASER, SONAR = SE2(0.1, 0.0, 0.0), SE2(0.0, 0.0, math.pi / 2.0)
T0_NS, PERIOD_NS = 1_000_000_000_000, 100_000_000
READY_S = 120.0
PANE_M, STEP_M, NUM_STEPS = 0.8, 0.06, 30
START = SE2(-2.5, -1.8, 0.0)  # in the room; the pane is to the left of the way
LAYERS = ("map/laser", "map/sonar", "map/glass")


class Robot:
    """Drives along a pane that its laser does not see, a sonar to the left."""

    def __init__(self, peer: Any, node: Any, num_tf: int, has_laser: bool = True) -> None:
        from geometry_msgs.msg import PoseWithCovarianceStamped
        from nav_msgs.msg import OccupancyGrid
        from sensor_msgs.msg import LaserScan, Range
        from tf2_msgs.msg import TFMessage

        from floornav_common.ros.qos import LATCHED_QOS, RELIABLE_QOS, TF_QOS
        from floornav_common.ros.transforms import StaticTransformBroadcaster

        self.peer, self.start_ns = peer, T0_NS
        names = ("map", *LAYERS)
        self.maps = {name: peer.collect(OccupancyGrid, name, LATCHED_QOS) for name in names}
        self.poses = peer.collect(PoseWithCovarianceStamped, "pose", RELIABLE_QOS)
        self.transforms = peer.collect(TFMessage, "/tf", TF_QOS)
        self.statics = StaticTransformBroadcaster(peer.node)
        self.statics.send("base_link", "laser", 0, Transform3.from_se2(LASER))
        self.statics.send("base_link", "sonar_0", 0, Transform3.from_se2(SONAR))
        node.wait_to_hear("/tf_static")
        self._tf_message = TFMessage
        self._tf = peer.publisher(TFMessage, "/tf", TF_QOS, to=node, num=num_tf)
        self.range = peer.publisher(Range, "sonar", RELIABLE_QOS, to=node)
        self._scan = peer.publisher(LaserScan, "scan", RELIABLE_QOS, to=node) if has_laser else None
        peer.wait_to_hear("map/sonar", "/tf")

    def send(self, step: int) -> int:
        """Send all that one step gives; return its stamp."""
        from std_msgs.msg import Header

        from floornav_common.ros.messages import ns_to_stamp, range_to_msg, scan_to_msg

        stamp_ns, odom = self.start_ns + step * PERIOD_NS, SE2(step * STEP_M, 0.0, 0.0)
        stamp = ns_to_stamp(stamp_ns)
        reading = RangeReading(PANE_M, 0.35, 0.1, 4.0)
        self.range.publish(range_to_msg(reading, stamp, "sonar_0"))
        if self._scan is not None:
            scan = scan_at(START @ odom @ LASER, square_room())
            self._scan.publish(scan_to_msg(scan, Header(stamp=stamp, frame_id="laser")))
        self.send_odometry(stamp_ns, odom)
        return stamp_ns

    def send_odometry(self, stamp_ns: int, odom: SE2) -> None:
        from floornav_common.ros.transforms import _stamped

        sample = _stamped("odom", "base_link", stamp_ns, Transform3.from_se2(odom))
        self._tf.publish(self._tf_message(transforms=[sample]))

    def drive(
        self, answer: list[Any], num_steps: int = NUM_STEPS, unanswered: range = range(0)
    ) -> None:
        """Send every step and await its stamp among the messages that answer it."""
        for step in range(num_steps):
            self.send(step)
            if step in unanswered:
                continue
            self.peer.spin_until(lambda s=step: self.has_answer(answer, s))

    def has_answer(self, answer: list[Any], step: int) -> bool:
        stamp = answer[-1].header.stamp if answer else None
        return (
            stamp is not None
            and stamp.sec * 10**9 + stamp.nanosec == self.start_ns + step * PERIOD_NS
        )

    def newest(self, name: str) -> OccupancyMap:
        from floornav_common.ros.messages import grid_from_msg

        return grid_from_msg(self.maps[name][-1])


def at(grid: OccupancyMap, pose: SE2, x: float, y: float) -> int:
    """Return the greatest cell about a point of a frame (within a cell's reach)."""
    near = np.array([[x + dx, y + dy] for dx in (-0.05, 0, 0.05) for dy in (-0.05, 0, 0.05)])
    cells = grid.to_cells(pose @ near)
    inside = ((cells >= 0) & (cells < grid.cells.shape)).all(axis=1)
    return max((int(grid.cells[r, c]) for r, c in cells[inside]), default=UNKNOWN)


def has_pane(grid: OccupancyMap, pose: SE2) -> bool:
    """Tell whether the pane stands in a map, seen from where the drive began."""
    return all(at(grid, pose, x, PANE_M) == OCCUPIED for x in np.arange(0.4, 1.3, 0.05))


def assert_only_the_pane(grid: OccupancyMap) -> None:
    """Check that the pane is mapped, and nothing behind it."""
    assert has_pane(grid, SE2.identity())
    obstacles = grid.to_points(np.argwhere(grid.cells == OCCUPIED))
    assert np.abs(obstacles[:, 1] - PANE_M).max() < 0.15


def start_mapper(start, *parameters):
    fixed = ("map_period_s:=0.05", "transform_timeout_s:=5.0", "scan_timeout_s:=1000.0")
    given = [word for parameter in (*fixed, *parameters) for word in ("-p", parameter)]
    node = start(*NODE, "--ros-args", *given)
    node.wait_for("ready", READY_S)
    return node


@pytest.mark.parametrize("fusion", ["overlay", "bayes"])
def test_a_drive_gives_glass_in_map_and_layer_and_both_are_saved(start, peer, tmp_path, fusion):
    name = f"map_file:={tmp_path / 'floor'}"
    node = start_mapper(start, name, "keepout_margin_m:=0.2", f"fusion:={fusion}")
    robot = Robot(peer, node, num_tf=2)
    robot.drive(robot.poses)
    here = SE2.identity()
    peer.spin_until(lambda: robot.maps["map"] and has_pane(robot.newest("map"), here))
    peer.spin_until(lambda: has_pane(robot.newest("map/glass"), here))
    peer.spin_until(lambda: has_pane(robot.newest("map/sonar"), here))
    glass = robot.newest("map/glass")
    assert at(robot.newest("map/laser"), here, 1.0, PANE_M) == FREE
    points = glass.to_points(np.argwhere(glass.cells == OCCUPIED))
    assert np.abs(points[:, 1] - PANE_M).max() < 0.15
    assert set(np.unique(glass.cells)) == {UNKNOWN, OCCUPIED}
    answer = peer.trigger("grid_mapper/save_map", node)
    assert answer.success and Path(answer.message) == tmp_path / "floor.yaml"
    assert has_pane(load_map(tmp_path / "floor_glass.yaml"), here)
    mask = load_map(tmp_path / "floor_keepout.yaml")
    assert at(mask, here, 1.0, PANE_M - 0.15) == OCCUPIED and at(mask, here, 1.0, 0.0) == FREE


def test_beside_another_localizer_only_layers_come_in_its_frame(start, peer):
    localizer = start(LOCALIZER)
    localizer.wait_for("ready", READY_S)
    node = start_mapper(start, "pose_source:=tf")
    robot = Robot(peer, node, num_tf=2)
    robot.drive(robot.maps["map/sonar"])
    place = SE2(2.0, 1.0, math.pi / 2.0)
    peer.spin_until(lambda: has_pane(robot.newest("map/glass"), place))
    assert at(robot.newest("map/laser"), place, 1.0, PANE_M) == FREE
    wall = place @ START.inverse() @ np.array([[0.0, -3.0]])
    assert at(robot.newest("map/laser"), SE2.identity(), *wall[0]) == OCCUPIED
    assert peer.node.count_publishers("map") == peer.node.count_publishers("pose") == 0
    senders = {t.header.frame_id for m in robot.transforms for t in m.transforms}
    names = {info.node_name for info in peer.node.get_publishers_info_by_topic("/tf")}
    assert senders == {"map", "odom"} and "grid_mapper" not in names


def test_a_jump_of_the_given_pose_is_said_and_does_not_smear(start, peer):
    jump_step = NUM_STEPS // 2
    localizer = start(LOCALIZER, str(T0_NS + jump_step * PERIOD_NS))
    localizer.wait_for("ready", READY_S)
    node = start_mapper(start, "pose_source:=tf", "sonar.min_points:=2.0")
    robot = Robot(peer, node, num_tf=2)
    # a second is left out, of the pose after the jump too: then it has shown that it stays
    robot.drive(robot.maps["map/sonar"], 40, range(jump_step, jump_step + 10))
    assert "jumped by 1.00 m" in node.wait_for("given pose jumped")
    place = SE2(2.0, 1.0, math.pi / 2.0)
    jumped = SE2(1.0, 0.0, 0.0) @ place
    here = [at(robot.newest("map/sonar"), place, x, PANE_M) for x in np.arange(0.3, 0.6, 0.05)]
    there = [at(robot.newest("map/sonar"), jumped, x, PANE_M) for x in np.arange(1.7, 2.1, 0.05)]
    assert set(here) == set(there) == {OCCUPIED}
    grid = robot.newest("map/sonar")
    obstacles = place.inverse() @ grid.to_points(np.argwhere(grid.cells == OCCUPIED))
    beside = np.abs(obstacles[:, 1] - PANE_M) > 0.15  # the jump is along -y of that frame
    assert (np.abs(obstacles[beside, 1] - (PANE_M - 1.0)) < 0.15).all()


def test_the_glass_layer_takes_the_cells_of_a_reference_map(start, peer):
    from nav_msgs.msg import OccupancyGrid

    from floornav_common.ros.messages import grid_to_msg, ns_to_stamp
    from floornav_common.ros.qos import LATCHED_QOS

    localizer = start(LOCALIZER)
    localizer.wait_for("ready", READY_S)
    node = start_mapper(start, "pose_source:=tf", "reference_map:=floor_plan")
    reference = OccupancyMap(np.full((70, 50), FREE, np.int8), 0.1, SE2(-1.03, -0.52, 0.1))
    plan = peer.publisher(OccupancyGrid, "floor_plan", LATCHED_QOS, to=node)
    robot = Robot(peer, node, num_tf=2)
    plan.publish(grid_to_msg(reference, ns_to_stamp(T0_NS), "map"))
    peer.spin_until(lambda: bool(robot.maps["map/glass"]))  # before there is any glass
    assert (robot.newest("map/glass").cells == UNKNOWN).all()
    robot.drive(robot.maps["map/sonar"])
    place = SE2(2.0, 1.0, math.pi / 2.0)
    peer.spin_until(lambda: has_pane(robot.newest("map/glass"), place))
    for msg in robot.maps["map/glass"]:
        assert (msg.info.width, msg.info.height) == (50, 70)
        assert msg.info.resolution == pytest.approx(0.1)
        assert (msg.info.origin.position.x, msg.info.origin.position.y) == (-1.03, -0.52)


def test_a_robot_of_sonars_alone_maps_in_its_odometry_frame(start, peer):
    node = start_mapper(start, "pose_source:=tf", "use_scan:=false", "map_frame:=odom")
    robot = Robot(peer, node, num_tf=1, has_laser=False)
    robot.drive(robot.maps["map/sonar"])
    grid = robot.newest("map/sonar")
    assert has_pane(grid, SE2.identity()) and at(grid, SE2.identity(), 1.0, 0.4) == FREE
    assert robot.maps["map/sonar"][-1].header.frame_id == "odom"


def test_sonars_alone_without_a_pose_are_refused_in_one_line(start):
    node = start(*NODE, "--ros-args", "-p", "use_scan:=false")
    assert node.wait_for_exit() == 2
    assert "use_scan false needs pose_source tf" in node.text and "Traceback" not in node.text


def test_a_sonar_without_a_transform_is_named_and_the_one_beside_it_maps_as_ever(start, peer):
    from floornav_common.ros.messages import ns_to_stamp, range_to_msg

    node = start_mapper(
        start, "pose_source:=tf", "use_scan:=false", "map_frame:=odom", "transform_timeout_s:=0.2"
    )
    robot = Robot(peer, node, num_tf=1, has_laser=False)
    far = RangeReading(2.5, 0.35, 0.1, 4.0)  # were it placed anywhere, an echo not at the pane
    for step in range(NUM_STEPS):
        stamp = ns_to_stamp(T0_NS + step * PERIOD_NS)
        robot.range.publish(range_to_msg(far, stamp, "nowhere"))
        robot.send(step)
        peer.spin_until(lambda s=step: robot.has_answer(robot.maps["map/sonar"], s))
    assert "dropped" in node.wait_for("nowhere")
    assert_only_the_pane(robot.newest("map/sonar"))


def test_an_infrared_ranger_is_named_once_and_changes_nothing(start, peer):
    from sensor_msgs.msg import Range

    from floornav_common.ros.messages import ns_to_stamp, range_to_msg

    node = start_mapper(start, "pose_source:=tf", "use_scan:=false", "map_frame:=odom")
    robot = Robot(peer, node, num_tf=1, has_laser=False)
    far = RangeReading(2.5, 0.35, 0.1, 4.0)
    for step in range(NUM_STEPS):
        msg = range_to_msg(far, ns_to_stamp(T0_NS + step * PERIOD_NS), "sonar_0")
        msg.radiation_type = Range.INFRARED
        robot.range.publish(msg)
        robot.send(step)
        peer.spin_until(lambda s=step: robot.has_answer(robot.maps["map/sonar"], s))
    node.wait_for("sonar_0: infrared rangers see through glass")
    assert node.text.count("infrared rangers") == 1
    assert_only_the_pane(robot.newest("map/sonar"))


@pytest.mark.parametrize(
    ("parameters", "warned"),
    [(["sonar_topics:=[sonar/fornt, sonar/left]"], "/sonar/fornt, /sonar/left"), ([], None)],
)
def test_a_sonar_topic_that_nothing_comes_on_is_named_but_no_robot_must_have_sonars(
    start, peer, parameters, warned
):
    from diagnostic_msgs.msg import DiagnosticStatus

    start_mapper(start, *parameters)
    arrays = hear_diagnostics(peer)

    def sonars() -> list[Any]:
        return statuses(arrays, "sonars")

    if warned is None:
        peer.spin_until(lambda: len(sonars()) >= 7)  # more than five seconds of silence
        assert all(s.level == DiagnosticStatus.OK for s in sonars())
    else:
        said = f"nothing heard on {warned}"
        peer.spin_until(
            lambda: any(s.level == DiagnosticStatus.WARN and s.message == said for s in sonars())
        )


def test_a_sonar_with_a_clock_ahead_holds_no_other_up_and_alone_it_is_told(start, peer):
    from diagnostic_msgs.msg import DiagnosticStatus

    from floornav_common.ros.messages import ns_to_stamp, range_to_msg

    node = start_mapper(start, "fusion:=overlay")
    robot = Robot(peer, node, num_tf=2)
    robot.statics.send("base_link", "sonar_ahead", 0, Transform3.from_se2(SONAR))

    def ahead(step: int) -> Any:
        stamp = ns_to_stamp(T0_NS + 3600 * 10**9 + step * PERIOD_NS)
        return range_to_msg(RangeReading(2.5, 0.35, 0.1, 4.0), stamp, "sonar_ahead")

    for step in range(NUM_STEPS):
        robot.range.publish(ahead(step))
        robot.send(step)
        peer.spin_until(lambda s=step: robot.has_answer(robot.poses, s))
    here = SE2.identity()
    peer.spin_until(lambda: robot.maps["map/sonar"] and has_pane(robot.newest("map/sonar"), here))
    assert_only_the_pane(robot.newest("map/sonar"))
    arrays = hear_diagnostics(peer)
    peer.publish_until(
        robot.range,
        ahead(NUM_STEPS),
        lambda: any(
            s.level == DiagnosticStatus.WARN and "no reading finds its pose" in s.message
            for s in statuses(arrays, "sonars")
        ),
    )


def test_beside_another_localizer_maps_go_on_after_stamps_have_jumped_back(start, peer):
    node = start_mapper(start, "pose_source:=tf", "use_scan:=false", "map_frame:=odom")
    robot = Robot(peer, node, num_tf=1, has_laser=False)
    robot.start_ns = T0_NS + 1000 * 10**9
    robot.drive(robot.maps["map/sonar"], 3)
    for k in range(500):  # several old samples in a row tell that time jumped
        robot.send_odometry(T0_NS - (600 - k) * 10_000_000, SE2.identity())
        if peer.spin_until(lambda: "starting afresh" in node.text, 0.1, must=False):
            break
    robot.start_ns = T0_NS
    robot.drive(robot.maps["map/sonar"])  # each map is stamped with the new time
    assert_only_the_pane(robot.newest("map/sonar"))
