"""The planner over DDS: it drives to goals, and it stops for every reason it has."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402, I001
from nav_msgs.msg import Path as PathMsg
from robot_messages import LATCHED, tf_of, time_of  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import LaserScan  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402

NODE = (Path(__file__).with_name("listening.py"), "sjmc_planner.nodes.local_planner_node")
GOAL_POSE = ("-p", "goal_source:=goal_pose")
STEP_NS = 50_000_000
OPEN, NUM_BEAMS = 3.0, 180
EVENTUALLY_S = 60.0  # what must come at last, on a slow and busy machine too


class Robot:
    """Stands at the origin of `odom` and says what a robot says, on the clock of this machine."""

    def __init__(
        self, peer: Any, node: Any, command: type = Twist, clock: Any = None, scan: str = "scan"
    ) -> None:
        from tf2_msgs.msg import TFMessage

        from floornav_common.ros.qos import RELIABLE_QOS

        self.peer, self.clock = peer, clock
        self.commands = peer.collect(command, "cmd_vel", RELIABLE_QOS)
        self.states = peer.collect(DiagnosticStatus, "planner/state", RELIABLE_QOS)
        self.diagnostics = peer.collect(DiagnosticArray, "/diagnostics", 10)
        statics = peer.publisher(TFMessage, "/tf_static", LATCHED, to=node)
        statics.publish(tf_of("base_link", "laser", 0, 0.0))
        self._tf = peer.publisher(TFMessage, "/tf", 10, to=node)
        self._scan = peer.publisher(LaserScan, scan, RELIABLE_QOS, to=node)
        self._odom = peer.publisher(Odometry, "odom", RELIABLE_QOS, to=node)
        self.silent: set[str] = set()
        self.ranges = np.full(NUM_BEAMS, np.inf)
        self.noise_m = 1e-6  # no laser measures the very same twice
        self.stamp_ns: int | None = None
        self.frame = "laser"
        self.child = "base_link"
        self.speed = 0.0
        self.range_min = 0.1
        self.age_ns = {"scan": 0, "odom": 0, "tf": 0}
        peer.wait_to_hear("cmd_vel", "planner/state")
        node.wait_for("/cmd_vel is sent to 1")

    def beat(self) -> None:
        """Send all inputs once and spin a control period."""
        stamp_ns = self.stamp_ns
        if stamp_ns is None:
            stamp_ns = self.peer.node.get_clock().now().nanoseconds
        elif "clock" not in self.silent:
            self.stamp_ns = stamp_ns = stamp_ns + STEP_NS
            self.clock.publish(Clock(clock=time_of(stamp_ns)))
        if "tf" not in self.silent:
            self._tf.publish(tf_of("odom", "base_link", stamp_ns - self.age_ns["tf"], 0.0))
        if "odom" not in self.silent:
            msg = Odometry(child_frame_id=self.child)
            odom_ns = stamp_ns - self.age_ns["odom"]
            msg.header.stamp, msg.header.frame_id = time_of(odom_ns), "odom"
            msg.twist.twist.linear.x = self.speed
            self._odom.publish(msg)
        if "scan" not in self.silent:
            step = 2.0 * np.pi / NUM_BEAMS
            msg = LaserScan(angle_min=-np.pi, angle_increment=step, range_max=OPEN)
            msg.range_min = self.range_min
            msg.header.stamp = time_of(stamp_ns - self.age_ns["scan"])
            msg.header.frame_id = self.frame
            self.noise_m = -self.noise_m
            msg.ranges = (self.ranges + self.noise_m).astype(np.float32).tolist()
            self._scan.publish(msg)
        self.peer.spin(0.05)

    def until(self, is_so: Callable[[], bool], beats: int = 200) -> None:
        """Send inputs until something is so; on a slow machine more of them."""
        end = time.monotonic() + EVENTUALLY_S
        while beats > 0 or time.monotonic() < end:
            if is_so():
                return
            self.beat()
            beats -= 1
        pytest.fail(f"not so; state: {self.state()}")

    def state(self) -> tuple[str, str]:
        """Return state and reason as said last."""
        if not self.states:
            return "", ""
        values = {v.key: v.value for v in self.states[-1].values}
        return values["state"], values["reason"]

    def is_in(self, state: str, reason: str = "") -> Callable[[], bool]:
        return lambda: self.state()[0] == state and reason in self.state()[1]

    def until_stopped(self, reason: str) -> None:
        """Wait for the state, then for a zero command sent since."""
        self.until(self.is_in("stopped", reason))
        self.commands.clear()
        self.until(lambda: bool(self.commands))
        assert speed_of(self.commands[-1]) == 0.0


def speed_of(msg: Any) -> float:
    twist = getattr(msg, "twist", msg)
    return float(np.hypot(twist.linear.x, twist.linear.y)) + abs(twist.angular.z)


def goal_of(x: float, y: float = 0.0, frame: str = "odom") -> PoseStamped:
    msg = PoseStamped()
    msg.header.frame_id = frame
    msg.pose.position.x, msg.pose.position.y, msg.pose.orientation.w = x, y, 1.0
    return msg


@pytest.fixture
def launch(start: Callable[..., Any], peer: Any) -> Callable[..., SimpleNamespace]:
    """Return what starts the planner with arguments, a robot around it, and a goal ahead."""

    def _launch(*words: str, command: type = Twist, goal: bool = True) -> SimpleNamespace:
        node = start(*NODE, "--ros-args", *GOAL_POSE, *words)
        node.wait_for("ready", 60.0)
        robot = Robot(peer, node, command)
        goals = peer.publisher(PoseStamped, "goal_pose", 5, to=node)
        if goal:
            goals.publish(goal_of(2.0))
            robot.until(robot.is_in("driving"))
            robot.until(lambda: robot.commands and speed_of(robot.commands[-1]) > 0.1)
        return SimpleNamespace(node=node, robot=robot, goals=goals, peer=peer)

    return _launch


def test_it_drives_at_a_goal_within_its_limits_and_says_so(launch):
    run = launch()
    commands = run.robot.commands
    assert all(m.linear.y == 0.0 and m.angular.z == 0.0 for m in commands)
    steps = np.diff([m.linear.x for m in commands])
    assert (steps <= 0.3 * 0.05 + 1e-9).all() and (steps >= -1e-9).all()
    said = {v.key: v.value for v in run.robot.states[-1].values}
    assert said["distance left (m)"] == "2.00" and run.robot.states[-1].level == b"\x00"


def test_an_obstacle_ahead_turns_it(launch):
    run = launch()
    run.robot.ranges[80:100] = 0.6
    run.robot.until(lambda: abs(run.robot.commands[-1].linear.y) > 0.05)


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("scan", "/scan: no longer arriving"),
        ("odom", "/odom: no longer"),
        ("tf", "pose: 'odom' to"),
    ],
)
def test_a_stale_input_stops_it_and_it_goes_on_when_it_comes_back(launch, what, reason):
    run = launch()
    run.robot.silent = {what}
    run.robot.until_stopped(reason)
    run.robot.silent = set()
    run.robot.until(run.robot.is_in("driving"))


@pytest.mark.parametrize("what", ["scan", "odom"])
def test_an_old_stamp_stops_it_however_often_the_message_comes(launch, what):
    run = launch()
    run.robot.age_ns[what] = 20_000_000_000
    run.robot.until_stopped(f"/{what}: its stamp is 20")
    run.robot.age_ns[what] = 0
    run.robot.until(run.robot.is_in("driving"))


@pytest.mark.parametrize("what", ["scan", "odom", "tf"])
def test_a_stamp_from_the_future_stops_it_for_it_would_never_be_old(launch, what):
    run = launch()
    run.robot.age_ns[what] = -30_000_000_000
    run.robot.until_stopped("s in the future: two clocks?")
    assert run.robot.state()[1].startswith("pose: 'odom' to" if what == "tf" else f"/{what}:")


def test_stamps_of_another_clock_are_called_that(launch):
    run = launch()
    run.robot.age_ns["scan"] = 10**18
    run.robot.until_stopped("stamped by another clock: use_sim_time?")


def test_a_twist_that_is_no_number_stops_it(launch):
    run = launch()
    run.robot.speed = float("nan")
    run.robot.until_stopped("/odom: the twist must be finite")
    run.robot.speed = 0.0
    run.robot.until(run.robot.is_in("driving"))


def test_a_twist_of_a_frame_that_nobody_placed_stops_it(launch):
    run = launch()
    run.robot.child = "base_footprint"
    run.robot.until_stopped("/odom: child_frame_id: ")
    assert "base_footprint" in run.robot.state()[1]


@pytest.mark.parametrize("frame", ["base_link", "laser"])
def test_a_goal_that_would_move_on_with_the_robot_is_refused(launch, frame):
    run = launch()
    run.goals.publish(goal_of(1.0, frame=frame))
    run.robot.until_stopped(f"'{frame}' is fixed to the robot")


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_told_to_end_while_driving_its_last_word_is_zero(launch, sign):
    run = launch()
    assert speed_of(run.robot.commands[-1]) > 0.0
    assert run.node.stop(sign) == 0
    run.peer.spin_until(lambda: speed_of(run.robot.commands[-1]) == 0.0)


def test_an_error_of_its_own_while_driving_ends_in_zero_too(start, peer):
    node = start(Path(__file__).with_name("failing_planner.py"), "--ros-args", *GOAL_POSE)
    node.wait_for("ready", 60.0)
    robot = Robot(peer, node)
    peer.publisher(PoseStamped, "goal_pose", 5, to=node).publish(goal_of(2.0))
    robot.until(lambda: node.has_ended)
    assert node.wait_for_exit() == 1 and "broken on purpose" in node.text
    peer.spin_until(lambda: robot.commands and speed_of(robot.commands[-1]) == 0.0)
    assert max(speed_of(m) for m in robot.commands) > 0.05


def test_a_planner_that_drives_nobody_ends_without_a_word(launch):
    run = launch(goal=False)
    run.robot.until(run.robot.is_in("idle"))
    run.robot.commands.clear()
    run.node.stop()
    run.peer.spin(0.5)
    assert not run.robot.commands


def test_a_scan_without_its_transform_stops_it(launch):
    run = launch()
    run.robot.frame = "nowhere"
    run.robot.until_stopped("nowhere")


def test_a_goal_in_an_unknown_frame_stops_it(launch):
    run = launch(goal=False)
    run.goals.publish(goal_of(1.0, frame="mars"))
    run.robot.until_stopped("mars")


def test_a_scan_that_shows_nothing_lets_it_stand(launch):
    run = launch()
    run.robot.ranges = np.full(NUM_BEAMS, np.nan)
    run.robot.until(lambda: run.robot.state()[0] in ("blocked", "braking"))
    run.robot.until(lambda: speed_of(run.robot.commands[-1]) == 0.0)


def test_disabling_stops_it_at_once_and_enabling_lets_it_go(launch):
    run = launch()
    answer = run.peer.call(SetBool, "local_planner/enable", SetBool.Request(data=False), run.node)
    assert answer.success
    run.robot.until(run.robot.is_in("disabled"))
    assert speed_of(run.robot.commands[-1]) == 0.0
    run.peer.call(SetBool, "local_planner/enable", SetBool.Request(data=True), run.node)
    run.robot.until(run.robot.is_in("driving"))


def test_at_the_goal_it_says_reached_and_falls_silent(launch):
    run = launch(goal=False)
    run.goals.publish(goal_of(0.01))
    run.robot.until(run.robot.is_in("reached"))
    for _ in range(30):
        run.robot.beat()
    run.robot.commands.clear()
    for _ in range(10):
        run.robot.beat()
    assert not run.robot.commands


def test_changes_of_state_come_to_the_log_and_the_state_names_the_goal(launch):
    run = launch(goal=False)
    run.robot.until(lambda: "idle: no goal" in run.node.text)
    run.goals.publish(goal_of(2.0, -0.5))
    run.robot.until(lambda: "driving" in run.node.text)
    assert {v.key: v.value for v in run.robot.states[-1].values}["goal"] == "odom (2.000, -0.500)"
    run.goals.publish(goal_of(0.01))
    run.robot.until(lambda: "]: reached" in run.node.text)
    assert run.node.text.count("]: driving") == run.node.text.count("]: reached") == 1


def test_a_second_publisher_on_cmd_vel_is_named(launch, make_peer):
    run = launch()
    other = make_peer("other_driver")
    other.publisher(Twist, "cmd_vel", 5)
    line = run.node.wait_for("/cmd_vel: also published by")
    assert "/other_driver" in line

    def is_error() -> bool:
        said = [s for a in run.robot.diagnostics for s in a.status if s.name.endswith(": cmd_vel")]
        return bool(said) and said[-1].level == b"\x02" and "/other_driver" in said[-1].message

    run.robot.until(is_error)


def test_stamped_commands_carry_stamp_and_frame(launch):
    run = launch("-p", "enable_stamped_cmd_vel:=true", command=TwistStamped)
    header = run.robot.commands[-1].header
    assert header.frame_id == "base_link" and header.stamp.sec > 0


def test_a_clock_that_stands_still_stops_it(start, peer):
    node = start(*NODE, "--ros-args", *GOAL_POSE, "-p", "use_sim_time:=true")
    node.wait_for("ready", 60.0)
    clock = peer.publisher(Clock, "/clock", 5)
    robot = Robot(peer, node, clock=clock)
    robot.stamp_ns = 1_000_000_000
    goals = peer.publisher(PoseStamped, "goal_pose", 5, to=node)
    goals.publish(goal_of(2.0))
    robot.until(robot.is_in("driving"))
    robot.silent = {"clock"}
    robot.until_stopped("/clock stands still")
    robot.silent = set()
    robot.until(robot.is_in("driving"))


@pytest.fixture
def timed(start, peer) -> SimpleNamespace:
    """Return a planner on the test's own clock that drives at a goal ahead."""
    node = start(*NODE, "--ros-args", *GOAL_POSE, "-p", "use_sim_time:=true")
    node.wait_for("ready", 60.0)
    robot = Robot(peer, node, clock=peer.publisher(Clock, "/clock", 5))
    robot.stamp_ns = 1_000_000_000
    goals = peer.publisher(PoseStamped, "goal_pose", 5, to=node)
    goals.publish(goal_of(2.0))
    robot.until(robot.is_in("driving"))
    return SimpleNamespace(node=node, robot=robot)


def test_a_scan_is_carried_forward_by_the_motion_since(timed):
    """A ring at 0.35 m leaves 0.24 m; at 0.3 m/s stopping takes 0.17 m, and 0.12 m went by."""
    robot = timed.robot
    robot.ranges, robot.speed = np.full(NUM_BEAMS, 0.35), 0.3
    for _ in range(10):
        robot.beat()
    assert robot.state()[0] == "driving"
    robot.age_ns["scan"] = 400_000_000
    robot.until(robot.is_in("braking"))


def test_what_went_too_near_to_be_seen_comes_nearer_as_the_robot_goes(timed):
    """Remembered at 0.4 m it leaves 0.29 m; at 0.3 m/s that is too little to stop in soon."""
    robot = timed.robot
    robot.range_min, robot.ranges[80:101] = 0.4, 0.42
    for _ in range(10):
        robot.beat()
    robot.ranges[80:101] = -np.inf
    for _ in range(10):
        robot.beat()
    assert robot.state()[0] == "driving"
    robot.speed = 0.3
    robot.until(robot.is_in("braking"))


def test_a_path_is_followed_even_when_it_came_before_the_planner(start, peer):
    pub = peer.node.create_publisher(PathMsg, "path", LATCHED)
    path = PathMsg()
    path.header.frame_id = "odom"
    path.poses = [goal_of(0.0), goal_of(0.0, 0.4), goal_of(0.0, 2.0)]
    pub.publish(path)
    node = start(*NODE)
    node.wait_for("ready", 60.0)
    robot = Robot(peer, node)
    robot.until(lambda: robot.commands and robot.commands[-1].linear.y > 0.1)
    pub.publish(PathMsg(header=path.header))
    robot.until(robot.is_in("idle"))


def test_follow_path_without_nav2_is_one_clear_line(start):
    node = start(*NODE, "--ros-args", "-p", "goal_source:=follow_path")
    assert node.wait_for_exit(30.0) == 2
    assert "follow_path needs nav2_msgs" in node.text and "Traceback" not in node.text
