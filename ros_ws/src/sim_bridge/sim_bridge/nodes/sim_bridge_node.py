"""A simulated world on ROS topics.

In: `cmd_vel` (Twist, or TwistStamped with `enable_stamped_cmd_vel`) of each robot.
Out: `scan`, `sonar` (or one topic a sonar), `odom` (drifting), `ground_truth/odom`,
`ground_truth/contact` (latched, on change), `ground_truth/people` (where there are people),
`robot_description` (latched), `/clock`, `/tf` odom->base_link, `/tf_static`; images of cameras,
drawn only while somebody subscribes.
Services: `~/reset`, `~/step` (Trigger).

A robot with a name has its topics below that name; by `tf_scheme` the name is the prefix of its
frames too, or it has TF topics of its own. All stamps are simulated time, which begins at 0 and
goes back there on `~/reset`. With `pace_nodes` or `pace_topics` time waits, bounded, for answers.
"""

from __future__ import annotations

import sys
import time

from rclpy.clock import Clock, ClockType
from rosgraph_msgs.msg import Clock as ClockMsg
from std_srvs.srv import Trigger

from floornav_common.ros.main import run_node
from floornav_common.ros.messages import ns_to_stamp
from floornav_common.ros.node import FloornavNode
from floornav_common.ros.parameters import ParameterError, declare_config
from floornav_common.ros.qos import CLOCK_QOS, create_publisher
from sim_bridge.config import SimBridgeConfig
from sim_bridge.display import NO_DISPLAY, has_display
from sim_bridge.nodes.pacing_listener import PacingListener
from sim_bridge.nodes.run_watch import RunWatch
from sim_bridge.nodes.world_ports import PeoplePort, robot_ports
from sim_bridge.physics import PybulletMissingError
from sim_bridge.placement import oddities
from sim_bridge.ranging import is_due
from sim_bridge.schema import WorldError, parsed_parameters
from sim_bridge.simulation import STEP_NS, Simulation
from sim_bridge.world import load_world

_TIMER_PERIOD_S = 0.002
_MAX_BURST_S = 0.02
_MAX_STEPS = 1000
_PACED_STEPS = 2


class SimBridgeNode(FloornavNode):
    """Steps a `Simulation` and publishes what its robots see."""

    def __init__(self) -> None:
        """Build the world and start its time, unless in lockstep."""
        super().__init__("sim_bridge")
        self._config = declare_config(self, SimBridgeConfig, on_change=self._set_config)
        if self._config.view and not has_display():
            raise ParameterError(f"view:=true {NO_DISPLAY}: leave it out")
        self.get_logger().info(
            f"building world {self._config.world!r}; the first time on a machine the ray casters "
            "are compiled, which takes some ten seconds"
        )
        try:
            self._sim = Simulation(
                load_world(self._config.world, parsed_parameters(self._config.world_parameters)),
                seed=self._config.seed,
                has_window=self._config.view,
                num_threads=self.get_parameter("num_threads").value,
            )
        except (WorldError, PybulletMissingError) as error:
            raise ParameterError(str(error)) from error
        for oddity in oddities(self._sim.world):
            self.get_logger().warning(oddity)
        self._ports = robot_ports(self, self._config, self._sim.models)
        self._people = PeoplePort(self) if self._sim.has_people else None
        self._clock_pub = create_publisher(self, ClockMsg, "/clock", CLOCK_QOS)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(Trigger, "~/step", self._on_step)
        self._pace = PacingListener(self, self._config, lambda: self._sim.stamp_ns)
        self._watch = RunWatch(self)
        self.time.on_look(self._look)
        self._owed_s, self._looked_at = 0.0, time.monotonic()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(_TIMER_PERIOD_S, self._on_timer, clock=steady)
        self.ready()

    def _set_config(self, config: SimBridgeConfig) -> None:
        self._config = config

    def _look(self) -> None:
        config = self._config
        is_held = config.lockstep or config.paused or self._pace.is_waiting_for_listeners
        self._watch.look(self._sim.stamp_ns, config.real_time_factor, is_held=is_held)

    def _on_timer(self) -> None:
        now = time.monotonic()
        factor = self._config.real_time_factor
        # What was missed for longer than a burst stays missed: time is slower, never jumpy.
        passed, self._looked_at = min(now - self._looked_at, _MAX_BURST_S), now
        if self._config.lockstep or self._config.paused:
            return
        self._owed_s = self._owed_s + factor * passed if factor else float("inf")
        # Paced, answers must be heard between steps, not after a burst of them.
        num_steps = _PACED_STEPS if self._pace.is_in_use else _MAX_STEPS
        for _ in range(num_steps):
            is_enough = self._owed_s < STEP_NS * 1e-9 or time.monotonic() - now > _MAX_BURST_S
            if is_enough or not self._pace.may_go_on(now):
                break
            self._owed_s -= STEP_NS * 1e-9
            self._step()
        self._owed_s = min(self._owed_s, max(factor, 1.0) * _MAX_BURST_S)

    def _step(self) -> None:
        commands = {name: port.take_command() for name, port in self._ports.items()}
        given = {name: c for name, c in commands.items() if c is not None}
        seen = self._sim.step(given, lambda name, camera: self._ports[name].is_watched(camera))
        if is_due(seen.stamp_ns, self._config.clock_period_s, STEP_NS):
            self._clock_pub.publish(ClockMsg(clock=ns_to_stamp(seen.stamp_ns)))
        for name, port in self._ports.items():
            port.publish(seen.stamp_ns, seen.robots[name])
        if self._people is not None:
            self._people.publish(seen)

    def _on_step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        for _step in range(round(self._config.step_s * 1e9 / STEP_NS)):
            self._step()
        response.success, response.message = True, f"at {self._sim.stamp_ns * 1e-9:.2f} s"
        return response

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._sim.reset()
        self._pace.restart()
        for port in self._ports.values():
            port.take_command()
        self._clock_pub.publish(ClockMsg(clock=ns_to_stamp(0)))
        response.success, response.message = True, "back at the start"
        return response

    def destroy_node(self) -> None:
        """Free the physics engine too."""
        self._sim.close()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the node."""
    return run_node(SimBridgeNode, args)


if __name__ == "__main__":
    sys.exit(main())
