"""A world that steps: commands in, observations out; the same seed gives the same bytes."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.config import STEP_NS
from sim_bridge.drive import DriveState, Velocity, drive_step, refusal
from sim_bridge.observations import GroundTruth, Observations, RobotObservation
from sim_bridge.panes import panes_of
from sim_bridge.people.people import People, disk_of
from sim_bridge.physics import Physics
from sim_bridge.placement import require_free, require_people_free
from sim_bridge.ranging import RangeSensors, is_due
from sim_bridge.robot_model import load_robot
from sim_bridge.schema import WorldError
from sim_bridge.solids import moved, solids_of
from sim_bridge.views import IsWatched, Views, always
from sim_bridge.wheels import (
    OdometryState,
    WheelState,
    first_odometry,
    first_wheel_state,
    odometry_step,
    wheels_step,
)
from sim_bridge.world import World

__all__ = ["STEP_NS", "Simulation"]


@dataclass
class _RobotState:
    drive: DriveState
    wheels: WheelState
    odometry: OdometryState
    odometry_ns: int
    rng_wheels: np.random.Generator


class Simulation:
    """Model, state and step of a world.

    Args:
        world: What is simulated.
        seed: Seed of every random number.
        has_window: True shows pybullet's window.
        T_new_old: Moves the whole world, robots included (for the test that this changes nothing).
        num_threads: Threads that draw camera images; the images do not depend on it.

    Raises:
        WorldError: Unknown robot model, or a robot that starts inside something.
    """

    def __init__(
        self,
        world: World,
        *,
        seed: int = 0,
        has_window: bool = False,
        T_new_old: SE2 | None = None,
        num_threads: int = 1,
    ) -> None:
        T = SE2.identity() if T_new_old is None else T_new_old
        self.world = world
        self.solids = moved(solids_of(world), T)
        self.models = {placed.name: load_robot(placed) for placed in world.robots}
        self.starts = {placed.name: T @ placed.pose for placed in world.robots}
        require_free(self.models, self.starts, self.solids)
        body = world.people_model.torso_radius_m
        require_people_free(world.people, body, T, self.models, self.starts, self.solids)
        robots = {name: (model, self.starts[name]) for name, model in self.models.items()}
        self._people = _people_of(world, T)
        self._physics = Physics(
            self.solids, robots, STEP_NS * 1e-9, movers=self._people.parts, has_window=has_window
        )
        self._panes = panes_of(self.solids)
        self.views = Views(world, self._physics, self.models, T, STEP_NS, num_threads)
        self._seed = seed
        self._states: dict[str, _RobotState] = {}
        self.stamp_ns = 0
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Go back to the start, with the same seed or another one."""
        self._seed = self._seed if seed is None else seed
        self.stamp_ns = 0
        self._physics.reset()
        self._people.reset(self._seed)
        self._physics.place_movers(self._people.places())
        self.views.reset(self._seed)
        self._velocities = dict.fromkeys(self.models, (0.0, 0.0))
        self._states = {name: self._first_state(name) for name in self.models}
        self._ranging = {
            name: RangeSensors(name, model, self._panes, STEP_NS, self._seed)
            for name, model in self.models.items()
        }

    @property
    def has_people(self) -> bool:
        """Tell whether people may come."""
        return self._people.num > 0

    def close(self) -> None:
        """Free the physics engine."""
        self._physics.close()

    def overview(self, size: tuple[int, int] = (1320, 1000)) -> np.ndarray:
        """Return a picture of the world from above, shape (height, width, 3), RGB uint8."""
        return self.views.overview(self.solids, size)

    def step(
        self, commands: Mapping[str, Velocity], is_watched: IsWatched = always
    ) -> Observations:
        """Go on by `STEP_NS`.

        Args:
            commands: New commands by robot name; a robot without one keeps its last until that
                times out. A refused command stops its robot and is named in the observation.
            is_watched: Tells of (robot, camera), as in `Views`, whether an image that is due is
                drawn. Nothing else, later images neither, depends on the answer.
        """
        _require_commands(commands, self.models)
        dt = STEP_NS * 1e-9
        floor: dict[str, Velocity] = {}
        for name, model in self.models.items():
            state, config = self._states[name], model.config
            state.drive = drive_step(config.drive, state.drive, commands.get(name), dt)
            state.wheels, floor[name] = wheels_step(
                config.wheels, state.wheels, state.drive.velocity, dt, state.rng_wheels
            )
        before = {name: self._physics.pose(name) for name in self.models}
        self._move_people(before)
        self._physics.step(floor)
        self.stamp_ns += STEP_NS
        robots = {
            name: self._observe(name, commands.get(name), before[name], is_watched)
            for name in self.models
        }
        for name, seen in robots.items():
            pose = seen.ground_truth.pose
            self._velocities[name] = (
                (pose.x - before[name].x) / dt, (pose.y - before[name].y) / dt
            )  # fmt: skip
        return Observations(self.stamp_ns, robots, self._people.truth())

    def _move_people(self, poses: dict[str, SE2]) -> None:
        if self._people.num:
            robots = [
                disk_of(model.config.footprint_m, pose, self._velocities[name], model.laser_m)
                for (name, pose), model in zip(poses.items(), self.models.values(), strict=True)
            ]
            self._people.step(self.stamp_ns, STEP_NS * 1e-9, robots)
            self._physics.place_movers(self._people.places())

    def _observe(
        self, name: str, command: Velocity | None, before: SE2, is_watched: IsWatched
    ) -> RobotObservation:
        config = self.models[name].config
        pose, dt = self._physics.pose(name), STEP_NS * 1e-9
        velocity = _mean_velocity(before.between(pose), dt)
        return RobotObservation(
            scan=self._ranging[name].scan(self._physics, self.stamp_ns, velocity),
            odometry=self._odometry(name),
            refused="" if command is None else refusal(config.drive, command),
            ground_truth=GroundTruth(pose, velocity, self._physics.is_touching(name)),
            sonar=self._ranging[name].sonar(self._physics, self.stamp_ns),
            omni=self.views.omni(name, self.stamp_ns, is_watched),
            stereo=self.views.stereo(name, self.stamp_ns, is_watched),
        )

    def _odometry(self, name: str) -> OdometryState | None:
        config, state = self.models[name].config, self._states[name]
        if not is_due(self.stamp_ns, config.odometry.period_s, STEP_NS):
            return None
        dt = (self.stamp_ns - state.odometry_ns) * 1e-9
        state.odometry = odometry_step(config.wheels, state.odometry, state.wheels.turned, dt)
        state.odometry_ns = self.stamp_ns
        return state.odometry

    def _first_state(self, name: str) -> _RobotState:
        keys = np.random.SeedSequence([self._seed, zlib.crc32(name.encode())])
        rng_wheels = np.random.default_rng(keys.spawn(1)[0])
        wheels = first_wheel_state(self.models[name].config.wheels, rng_wheels)
        odometry = first_odometry(self.models[name].config.wheels)
        return _RobotState(DriveState(), wheels, odometry, 0, rng_wheels)


def check_world(world: World) -> None:
    """Check that a world can be simulated, without building it.

    Raises:
        WorldError: As `Simulation`.
    """
    models = {placed.name: load_robot(placed) for placed in world.robots}
    starts = {placed.name: placed.pose for placed in world.robots}
    require_free(models, starts, solids_of(world))
    _people_of(world, SE2.identity())


def _require_commands(commands: Mapping[str, Velocity], known: Mapping[str, object]) -> None:
    if not isinstance(commands, Mapping):
        kind = type(commands).__name__
        raise ValueError(
            f'commands must map names of robots to Velocity ("" without name), got {kind}'
        )
    for name, command in commands.items():
        if name not in known:
            there = ", ".join(repr(n) for n in known) or "none"
            raise ValueError(f"commands must name robots of the world ({there}), got {name!r}")
        if not isinstance(command, Velocity):
            kind = type(command).__name__
            raise ValueError(f"commands[{name!r}] must be a Velocity, got {kind}")


def _people_of(world: World, T_new_old: SE2) -> People:
    try:
        return People(
            world.people_model, world.people, world.crowd, world.recorded_people,
            solids_of(world), T_new_old,
        )  # fmt: skip
    except WorldError:
        raise
    except ValueError as error:
        raise WorldError(f"{world.name}: {error}") from error


def _mean_velocity(motion: SE2, dt: float) -> Velocity:
    """Return the steady velocity in the base frame that leads to a motion within dt."""
    c, s = math.cos(motion.yaw / 2.0), math.sin(motion.yaw / 2.0)
    shrunk = dt * float(np.sinc(motion.yaw / (2.0 * np.pi)))
    ahead, aside = c * motion.x + s * motion.y, c * motion.y - s * motion.x
    return Velocity(ahead / shrunk, motion.yaw / dt, aside / shrunk)
