"""A robot's range sensors in the world: rays from where it stands, then each sensor's faults."""

from __future__ import annotations

import functools
import zlib

import numpy as np

from floornav_common.readings import RangeReading
from floornav_common.scan import Scan
from sim_bridge.drive import Velocity
from sim_bridge.echoes import echo_reach
from sim_bridge.laser import beam_directions, measure
from sim_bridge.panes import Panes, crossings, laser_distances
from sim_bridge.physics import Physics
from sim_bridge.rays import BEYOND
from sim_bridge.robot_model import RobotModel
from sim_bridge.sonar import first_echoes, readings
from sim_bridge.sonar_config import SonarConfig
from sim_bridge.sweep import beam_lags, earlier_poses


def sensor_stream(seed: int, robot: str, sensor: str) -> np.random.Generator:
    """Return a sensor's own random numbers: another sensor more or less changes none of them."""
    keys = [seed, zlib.crc32(robot.encode()), zlib.crc32(sensor.encode())]
    return np.random.default_rng(keys)


class RangeSensors:
    """The laser and the sonars of one robot.

    Args:
        name: The robot.
        model: Its model.
        panes: The world's glass.
        step_ns: Length of a step of the simulation.
        seed: Seed of the simulation.
    """

    def __init__(self, name: str, model: RobotModel, panes: Panes, step_ns: int, seed: int) -> None:
        self._name, self._model, self._panes, self._step_ns = name, model, panes, step_ns
        self._rng_laser = sensor_stream(seed, name, "laser")
        # Apart from the laser's own noise, which so does not depend on the glass in the world.
        self._rng_glass = sensor_stream(seed, name, "laser glass")
        self._rng_echo = sensor_stream(seed, name, "laser echo")
        self._seed = seed
        self._rng_sonar = sensor_stream(seed, name, "sonar")
        laser = model.config.laser
        self._beams = np.empty((0, 3)) if laser is None else beam_directions(laser)

    def scan(self, physics: Physics, stamp_ns: int, velocity: Velocity) -> Scan | None:
        """Return the sweep that ends with this step, None if none does.

        Args:
            physics: Where everything is.
            stamp_ns: End of the step.
            velocity: Of the base, with which it came here: the beams of a sweep that takes its
                time are cast from where it was (of what else moves, from where that is now).
        """
        laser = self._model.config.laser
        if laser is None or not is_due(stamp_ns, laser.period_s, self._step_ns):
            return None
        T_base_laser, length = self._model.mounts[laser.frame], BEYOND * laser.range_max_m
        T_world_base = physics.sensor_pose(self._name, np.eye(4))
        T = T_world_base @ earlier_poses(velocity, beam_lags(laser)) @ T_base_laser
        headings = np.einsum("nij,nj->ni", np.broadcast_to(T, (len(self._beams), 4, 4))[:, :3, :3],
                             self._beams)  # fmt: skip
        starts = np.broadcast_to(T[:, :3, 3], headings.shape)
        hits = physics.cast_light(self._name, starts, starts + length * headings)
        cos = np.einsum("ij,ij->i", headings, hits.normals)
        reach = echo_reach(laser, cos, hits.surfaces, self._rng_echo)
        met = crossings(self._panes, T[:, :3, 3], headings, length)
        distances = laser_distances(
            self._panes, met, length * hits.shares, reach, self._rng_glass, self._seed
        )
        return measure(laser, distances, self._rng_laser)

    def sonar(self, physics: Physics, stamp_ns: int) -> tuple[RangeReading, ...] | None:
        """Return the readings of the sonars that fire now, NaN for the others; None if none."""
        sonar = self._model.config.sonar
        fired = () if sonar is None else fired_sonars(sonar, stamp_ns, self._step_ns)
        if sonar is None or not fired:
            return None
        T_world_base, rng = physics.sensor_pose(self._name, np.eye(4)), self._rng_sonar
        mounts = [self._model.mounts[f"{sonar.frame}{k}"] for k in fired]
        poses = np.array([T_world_base @ mount for mount in mounts])
        critical = sonar.critical_rad + sonar.critical_sd_rad * rng.standard_normal(len(fired))
        cast = functools.partial(physics.cast_sound, self._name)
        nearest = functools.partial(physics.nearest_in_cone, self._name)
        return readings(sonar, first_echoes(sonar, poses, critical, cast, nearest), fired, rng)


def is_due(stamp_ns: int, period_s: float, step_ns: int) -> bool:
    """Tell whether a multiple of the period lies in the step that ends at the stamp."""
    period_ns = max(round(period_s * 1e9), step_ns)
    return stamp_ns // period_ns != (stamp_ns - step_ns) // period_ns


def fired_sonars(config: SonarConfig, stamp_ns: int, step_ns: int) -> tuple[int, ...]:
    """Return the sonars whose slot of the firing order begins with this step; () if none."""
    order = config.firing_order
    slot_ns = max(round(config.period_s * 1e9 / len(order)), step_ns)
    if not is_due(stamp_ns, slot_ns * 1e-9, step_ns):
        return ()
    return order[(stamp_ns // slot_ns - 1) % len(order)]
