"""How the demo drives robots that no planner drives yet: along a route, off what a scan shows."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from sim_bridge.config import RouteConfig
from sim_bridge.drive import STOP, Velocity
from sim_bridge.robot_model import RobotModel
from sim_bridge.route import RouteFollower
from sim_bridge.world import World

_AHEAD_RAD = math.radians(50.0)
_NEAR, _CLEAR = 0.9, 2.0
_CIRCLE = Velocity(0.15, 0.3)


class Driver:
    """Steers one robot for the pictures; a script, not a planner.

    With a route it follows that by the true pose; else, with a laser, it drives ahead and turns to
    the freer side before what the scan shows; else it drives a circle.

    Args:
        world: For the route, which is for the only robot.
        model: The robot.
    """

    def __init__(self, world: World, model: RobotModel) -> None:
        limits = model.config.drive
        self._speed = min(0.6, 0.5 * limits.max_speed_m_s)
        self._yaw_rate = min(0.8, 0.5 * limits.max_yaw_rate_rad_s)
        self._has_laser = model.config.laser is not None
        self._route: RouteFollower | None = None
        if world.route is not None and len(world.robots) == 1:
            numbers = tuple(float(v) for v in np.ravel(world.route.waypoints_m))
            speed = min(world.route.speed_m_s, limits.max_speed_m_s)
            self._route = RouteFollower(
                RouteConfig(route_m=numbers, speed_m_s=speed, max_yaw_rate_rad_s=self._yaw_rate)
            )

    def command(self, pose: SE2, scan: Scan | None) -> Velocity:
        """Return the next command.

        Args:
            pose: True pose in the world.
            scan: The newest, or None if there is none yet.
        """
        if self._route is not None:
            return self._route.step(pose) or STOP
        if not self._has_laser:
            return _CIRCLE
        return STOP if scan is None else self._off(scan)

    def _off(self, scan: Scan) -> Velocity:
        # A lost beam tells nothing, one too near everything.
        ranges = np.where(np.isnan(scan.ranges), np.inf, np.maximum(scan.ranges, 0.0))
        ahead = np.abs(scan.angles) < _AHEAD_RAD
        nearest = float(ranges[ahead].min())
        share = min(max((nearest - _NEAR) / (_CLEAR - _NEAR), 0.0), 1.0)
        near = np.minimum(ranges, 4.0)
        left, right = near[scan.angles > 0.0].mean(), near[scan.angles < 0.0].mean()
        turn = math.copysign(self._yaw_rate, float(left - right)) if share < 1.0 else 0.0
        return Velocity(share * self._speed, (1.0 - share) * turn)
