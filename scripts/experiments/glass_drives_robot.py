"""A robot that maps by laser and sonars while it drives: mapper, wavefront, method, in lockstep.

It does what the nodes do, at their rates: `grid_mapper` (every scan a pose, a map a second, the map
a moment after), `wavefront_planner` (a way when the map changes, and twice a second), and
`local_planner` (20 commands a second, sent one period later). It knows scans, echoes and odometry;
the goal is given on the map, whose origin is where it starts. Where the map does not reach to the
goal yet when it starts, it looks round first, on the spot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import GridMapperConfig
from grid_mapper.layers import LayeredMapper
from sim_bridge import drive as base
from sim_bridge.observations import RobotObservation
from sim_bridge.robot_model import RobotModel
from sjmc_planner.config import LocalPlannerConfig, RobotConfig
from sjmc_planner.known_obstacles import near_points, occupied_corners
from sjmc_planner.limited_motion import ramped
from sjmc_planner.methods import make_method
from sjmc_planner.near_echoes import Heard, NearEchoes
from sjmc_planner.path_target import PathTarget
from sjmc_planner.planning import REACHED, STILL, Obstacles, RobotState, Velocity
from sjmc_planner.route_keeper import NO_WAY, ON_ITS_WAY, RouteKeeper
from sjmc_planner.wavefront_config import WavefrontConfig

PERIOD_NS = 50_000_000
_MAP_NS, _MAP_DELAY_NS = 1_000_000_000, 150_000_000
_LOOK_NS = 500_000_000
_LOOKS_ROUND = Velocity(0.0, 0.0, 0.5)
# The simulated robot: its outline, and the limits of docs/drive-among-people.md.
ROBOT = RobotConfig(
    drive="differential", radius_m=0.57, margin_m=0.1, front_m=0.20, rear_m=0.49,
    half_width_m=0.28, speed_m_s=0.6, accel_m_s2=0.6, idle_time_s=0.1,
)  # fmt: skip
# A way keeps off by all of the robot, also for `sjmc`, which knows its box and could pass nearer:
# who comes near beside a pane before it is known has little room to turn.
WAY = WavefrontConfig(radius_m=ROBOT.radius_m)


@dataclass(frozen=True)
class Row:
    """How a robot drives.

    Attributes:
        method: Of `local_planner`.
        has_sonar: Whether its sonars enter the map.
        minds_map: Whether its method minds the map's glass.
        listens: Whether its method minds echoes from close by.
    """

    method: str
    has_sonar: bool = True
    minds_map: bool = True
    listens: bool = True


class MappingRobot:
    """One robot.

    Args:
        row: How it drives.
        model: The simulated robot.
        goal: On the map, shape (2,), m.
    """

    def __init__(self, row: Row, model: RobotModel, goal: np.ndarray) -> None:
        fusion = "bayes" if row.has_sonar else "none"
        self._mapper = LayeredMapper(GridMapperConfig(fusion=fusion), SE2.identity())
        self._row, self._keeper = row, RouteKeeper(WAY)
        self._config = LocalPlannerConfig(
            method=row.method, robot=ROBOT, goal_tolerance_m=0.15, lookahead_m=1.0
        )
        self._method = make_method(self._config)
        assert model.laser_m is not None and model.config.sonar is not None
        self._T_base_laser = SE2(*model.laser_m, 0.0)
        self._sonars = [_in_plane(model.mounts[f]) for f in model.config.sonar_frames]
        self._velocity, self._command = STILL, STILL
        self._odometry: SE2 | None = None
        self._asked_at = SE2.identity()
        self._T_map_odom = SE2.identity()
        self._scan: tuple[Scan, SE2] | None = None
        self._coming: tuple[int, OccupancyMap, OccupancyMap] | None = None
        self._mapped_ns, self._num_mapped = 0, 0
        self._has_driven = self._looks_round = False
        self._target: PathTarget | None = None
        self._known = np.zeros((0, 2))
        self._heard: list[Heard] = []
        self._echoes = NearEchoes(self._config.known)
        self.map: OccupancyMap | None = None
        self.glass: OccupancyMap | None = None
        self.set_goal(goal)

    def set_goal(self, goal: np.ndarray) -> None:
        """Go to another place on the map, shape (2,), m."""
        self._keeper.set_goal(goal)
        self._target, self.state = None, ("", "")
        self._looked_ns = -_LOOK_NS

    @property
    def T_map_base(self) -> SE2:  # noqa: N802, frames rule of the transforms
        """Where it thinks that it is."""
        odometry = SE2.identity() if self._odometry is None else self._odometry
        return self._T_map_odom @ odometry

    def take(self, stamp_ns: int, seen: RobotObservation) -> None:
        """Take what its sensors gave."""
        if seen.odometry is not None:
            v = seen.odometry.velocity
            self._velocity = Velocity(v.speed, v.side_speed, v.yaw_rate)
            if self._odometry is None:
                self._asked_at = seen.odometry.pose
                self._T_map_odom = seen.odometry.pose.inverse()
            self._odometry = seen.odometry.pose
        if self._odometry is None:
            return
        if seen.scan is not None:
            self._scan = seen.scan, self._odometry
            found = self._mapper.insert_scan(
                stamp_ns, seen.scan, self._T_base_laser, self._odometry
            )
            self._T_map_odom = found.T_map_base @ self._odometry.inverse()
        for k, reading in enumerate(seen.sonar or ()):
            if self._row.has_sonar and not math.isnan(reading.range):  # others fired
                self._mapper.insert_range(stamp_ns, reading, self._sonars[k], f"sonar_{k}")
                self._heard.append((reading, self._sonars[k]))
        self._make_maps(stamp_ns)

    def command(self, stamp_ns: int) -> base.Velocity:
        """Return what was decided a period ago, to be sent now, and decide the next."""
        now = self._command
        self._look(stamp_ns)
        if self._target is None or self._scan is None or self._odometry is None:
            wanted = _LOOKS_ROUND if self._looks_round else STILL
            self._command = ramped(now, wanted, ROBOT, PERIOD_NS * 1e-9)
            return base.Velocity(now.x, now.yaw_rate, now.y)
        moved = self._asked_at.between(self._odometry)
        self._asked_at = self._odometry
        goal = self._target.goal(self.T_map_base)
        decision = self._method.decide(
            RobotState(self._velocity, now, moved), self._obstacles(self._scan, moved), goal
        )
        self.state = decision.state, decision.reason
        self._command = ramped(now, decision.command, ROBOT, PERIOD_NS * 1e-9)
        return base.Velocity(now.x, now.yaw_rate, now.y)

    @property
    def is_there(self) -> bool:
        """Whether it stands at its goal."""
        return self.state[0] == REACHED and self._velocity.speed < 0.05

    def _obstacles(self, scan: tuple[Scan, SE2], moved: SE2) -> Obstacles:
        """Return the scan, and what the map and the sonars know beside it."""
        assert self._odometry is not None
        seen = Obstacles(scan[0], self._odometry.between(scan[1]) @ self._T_base_laser)
        known, config = [], self._config.known
        heard, self._heard = self._heard, []
        if self._row.listens:
            known.append(self._echoes.update(heard, seen, moved, PERIOD_NS * 1e-9))
        if self._row.minds_map:
            known.append(near_points(self._known, self.T_map_base, config.reach_m))
        return replace(seen, known=np.concatenate([np.zeros((0, 2)), *known]))

    def _make_maps(self, stamp_ns: int) -> None:
        """Make the maps once a second; they are there a moment later."""
        if self._coming is not None and stamp_ns >= self._coming[0]:
            _, self.map, self.glass = self._coming
            self._coming = None
            self._known = occupied_corners(self.glass, self._config.known.occupied_from)
            self._keeper.set_grid(self.map)
            self._looked_ns = -_LOOK_NS
        is_new = self._mapper.num_changes != self._num_mapped
        if is_new and self._coming is None and stamp_ns - self._mapped_ns >= _MAP_NS:
            self._mapped_ns, self._num_mapped = stamp_ns, self._mapper.num_changes
            layers = self._mapper.layers()
            self._coming = stamp_ns + _MAP_DELAY_NS, layers.occupancy, layers.glass

    def _look(self, stamp_ns: int) -> None:
        """Ask for a way; take a new one."""
        if stamp_ns - self._looked_ns < _LOOK_NS or self._odometry is None:
            return
        self._looked_ns = stamp_ns
        here = self.T_map_base
        route = self._keeper.update(np.array([here.x, here.y]))
        self._has_driven = self._has_driven or route.state == ON_ITS_WAY
        self._looks_round = route.state == NO_WAY and not self._has_driven
        if route.points is not None:
            new = len(route.points) > 0
            self._target = PathTarget(route.points, self._config.lookahead_m) if new else None


def _in_plane(T: np.ndarray) -> SE2:
    return SE2(float(T[0, 3]), float(T[1, 3]), math.atan2(T[1, 0], T[0, 0]))
