"""A drive along a world's route, by the true pose, with what the robot's sensors gave."""

from __future__ import annotations

import math

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.config import RouteConfig
from sim_bridge.drive import STOP
from sim_bridge.observations import RobotObservation
from sim_bridge.robot_model import RobotModel
from sim_bridge.route import RouteFollower
from sim_bridge.simulation import Simulation
from sim_bridge.world import World, load_world

_LONGEST_S = 900.0
_LONGEST_STILL_S = 20.0
_WAITS_M, _WAITS_BESIDE_M = 0.9, 0.45


def follow_route(name: str, seed: int, speed: float) -> dict[str, np.ndarray]:
    """Drive a world's route once and return what was taken, as the fields of a `GlassLog`.

    Raises:
        ValueError: The world has no route, or its robot no laser or sonars.
    """
    return drive_world(load_world(name), seed, speed)


def drive_world(
    world: World, seed: int, speed: float, longest_s: float = _LONGEST_S,
    patience_s: float = math.inf,
) -> dict[str, np.ndarray]:  # fmt: skip
    """Drive the route of a world; the robot waits for people who are in its way.

    Args:
        world: With one robot and a route.
        seed: Of every random number.
        speed: Along the route, m/s.
        longest_s: Where the drive ends at the latest.
        patience_s: After having stood so long the robot goes on; who waits for it steps aside.

    Raises:
        ValueError: The world has no route, or its robot no laser or sonars.
    """
    if world.route is None or len(world.robots) != 1:
        raise ValueError(f"{world.name} must have one robot and a route")
    simulation = Simulation(world, seed=seed)
    try:
        (robot,) = simulation.models
        model = simulation.models[robot]
        if model.config.laser is None or model.config.sonar is None:
            raise ValueError(f"the robot of {world.name} must have a laser and sonars")
        route = tuple(float(v) for v in np.ravel(world.route.waypoints_m))
        follower = RouteFollower(RouteConfig(route_m=route, speed_m_s=speed))
        taken, people = _Taken(simulation.starts[robot]), np.zeros((0, 2))
        while simulation.stamp_ns < longest_s * 1e9 and not taken.is_stuck(simulation.stamp_ns):
            command = follower.step(taken.pose)
            if command is None:
                taken.is_complete = True
                break
            has_patience = taken.still_s(simulation.stamp_ns) < patience_s
            command = STOP if has_patience and _is_in_the_way(taken.pose, people) else command
            seen = simulation.step({robot: command})
            people = np.array([(p.pose.x, p.pose.y) for p in seen.ground_truth_people])
            taken.take(seen.stamp_ns, seen.robots[robot])
    finally:
        simulation.close()
    return {**taken.arrays(), **_mounting(model)}


def _is_in_the_way(pose: SE2, people: np.ndarray) -> bool:
    """Tell whether anybody stands right before the robot."""
    if not len(people):
        return False
    off = pose.inverse() @ people.reshape(-1, 2)
    is_before = (off[:, 0] > 0.0) & (off[:, 0] < _WAITS_M) & (np.abs(off[:, 1]) < _WAITS_BESIDE_M)
    return bool(is_before.any())


class _Taken:
    """What a drive has given so far."""

    def __init__(self, start: SE2) -> None:
        self.pose = start
        self.is_complete = False
        self._num_touches = 0
        self._moved_ns, self._moved_from = 0, start
        self._odometry: list[tuple[int, float, float, float]] = [(0, 0.0, 0.0, 0.0)]
        self._scans: list[tuple[int, np.ndarray, np.ndarray]] = []
        self._ranges: list[tuple[int, int, float, np.ndarray]] = []

    def take(self, stamp_ns: int, seen: RobotObservation) -> None:
        """Keep what sensors gave in a step."""
        self.pose = seen.ground_truth.pose
        self._num_touches += seen.ground_truth.is_touching
        moved = self._moved_from.between(self.pose)
        if moved.distance > 0.05 or abs(moved.yaw) > 0.05:
            self._moved_ns, self._moved_from = stamp_ns, self.pose
        true = self.pose.as_array()
        if seen.odometry is not None:
            self._odometry.append((stamp_ns, *seen.odometry.pose.as_array().tolist()))
        if seen.scan is not None:
            self._scans.append((stamp_ns, seen.scan.ranges.astype(np.float32), true))
        for number, reading in enumerate(seen.sonar or ()):
            if not math.isnan(reading.range):  # others fired
                self._ranges.append((stamp_ns, number, reading.range, true))

    def still_s(self, stamp_ns: int) -> float:
        """Return for how long the robot has not come on."""
        return 1e-9 * (stamp_ns - self._moved_ns)

    def is_stuck(self, stamp_ns: int) -> bool:
        """Tell whether that is too long."""
        return self.still_s(stamp_ns) > _LONGEST_STILL_S

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what there is as the log's fields."""
        scan_ns = np.array([scan[0] for scan in self._scans], np.int64)
        range_ns = np.array([reading[0] for reading in self._ranges], np.int64)
        return {
            "scan_ns": scan_ns,
            "scan_ranges": np.array([scan[1] for scan in self._scans]),
            "scan_odom": self._odometry_at(scan_ns),
            "scan_true": np.array([scan[2] for scan in self._scans]),
            "range_ns": range_ns,
            "range_sensor": np.array([reading[1] for reading in self._ranges], np.int64),
            "range_m": np.array([reading[2] for reading in self._ranges]),
            "range_odom": self._odometry_at(range_ns),
            "range_true": np.array([reading[3] for reading in self._ranges]),
            "num_touches": np.array(self._num_touches),
            "is_complete": np.array(self.is_complete),
        }

    def _odometry_at(self, stamps_ns: np.ndarray) -> np.ndarray:
        track = np.array(self._odometry)
        columns = (track[:, 1], track[:, 2], np.unwrap(track[:, 3]))
        return np.column_stack([np.interp(stamps_ns, track[:, 0], values) for values in columns])


def _mounting(model: RobotModel) -> dict[str, np.ndarray]:
    """Return where a robot's range sensors sit and what their messages say of them."""
    laser, sonar = model.config.laser, model.config.sonar
    assert laser is not None and sonar is not None
    T_laser = model.mounts[laser.frame]
    mounts = [model.mounts[frame] for frame in model.config.sonar_frames]
    is_full_turn = laser.fov_rad > 2.0 * math.pi - 1e-6
    step = laser.fov_rad / (laser.num_beams if is_full_turn else laser.num_beams - 1)
    limits = (-laser.fov_rad / 2.0, step, laser.range_min_m, laser.range_max_m)
    return {
        "laser_limits": np.array(limits),
        "sonar_limits": np.array(
            (sonar.opening_rad, sonar.range_min_m, sonar.range_max_m, sonar.critical_rad)
        ),
        "laser_pose": _in_plane(T_laser),
        "laser_height": T_laser[2, 3],
        "sonar_poses": np.array([_in_plane(T) for T in mounts]),
    }


def _in_plane(T: np.ndarray) -> np.ndarray:
    return np.array((T[0, 3], T[1, 3], math.atan2(T[1, 0], T[0, 0])))
