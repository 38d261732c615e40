"""The pybullet side: bodies, contacts, rays. Nothing else in the package knows pybullet.

Robots move in the plane: each step their floor velocity is set, the engine resolves contacts,
and height and tilt are put back. A robot against a wall stands while its wheels turn; one that
meets a person goes on no farther than it comes on its own way, and people do not move it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.bodies import FLOOR, make_robot, make_solid
from sim_bridge.drawn_shapes import DrawnShapes
from sim_bridge.drive import Velocity
from sim_bridge.engine import PybulletMissingError, connect, require_pybullet
from sim_bridge.engine_picture import engine_picture, paint
from sim_bridge.floor_motion import floor_velocity, on_its_way
from sim_bridge.ray_scene import RayScene
from sim_bridge.rays import Hits
from sim_bridge.robot_model import RobotModel
from sim_bridge.solids import Solid
from sim_bridge.surfaces import NAMES

__all__ = ["Physics", "PybulletMissingError", "require_pybullet"]

_SCENERY_GROUP = 1
_GLASS_GROUP = 2
_FIRST_ROBOT_GROUP = 3
_ALL_COLLIDE = 0x3FFFFFFF
_STANDS = 1 << 29  # what stands for ever need not be tested against itself: most of a step
_FARTHEST = 0.01  # that a robot goes between two looks for contacts, m


class Physics:
    """One engine with the bodies of a world.

    Args:
        solids: The scenery.
        robots: Model and start pose of each robot.
        dt: Length of a step, s.
        movers: Solids that are put somewhere each step (people); nothing pushes them.
        has_window: True opens pybullet's window.
    """

    def __init__(
        self,
        solids: list[Solid],
        robots: dict[str, tuple[RobotModel, SE2]],
        dt: float,
        *,
        movers: Sequence[Solid] = (),
        has_window: bool = False,
    ) -> None:
        self._engine, self._client = connect(has_window)
        self._scenery, self._mover_solids, self._robots = solids, movers, robots
        self._dt = dt
        # The engine's own renderer knows only opaque and absent; its window can blend.
        self._glass_alpha = 0.3 if has_window else 0.0
        self._build()

    def close(self) -> None:
        """Free the engine."""
        if self._engine.isConnected(self._client):
            self._engine.disconnect(physicsClientId=self._client)

    def reset(self) -> None:
        """Put every body back to where it started.

        The engine is built again: a state that it saves leaves out in which order it met bodies.
        Bodies get the numbers that they had.
        """
        self._engine.resetSimulation(physicsClientId=self._client)
        self._build()

    def step(self, velocities: dict[str, Velocity]) -> None:
        """Move everything on by one step; every robot needs its floor velocity."""
        before = {name: self.pose(name) for name in velocities}
        floor = {
            name: floor_velocity(before[name].yaw, v, self._dt) for name, v in velocities.items()
        }
        for name, (x, y, turn) in floor.items():
            self._engine.resetBaseVelocity(
                self._bodies[name], (x, y, 0.0), (0.0, 0.0, turn), physicsClientId=self._client
            )
        self._engine.stepSimulation(physicsClientId=self._client)
        for name in velocities:
            pose = self.pose(name)
            if self._meets_person(name):
                pose = on_its_way(before[name], pose, np.array(floor[name]) * self._dt)
            self._set_pose(name, pose)
        self._rays.moved()

    def drawn_shapes(self) -> DrawnShapes:
        """Return everything that cameras see but the floor."""
        return DrawnShapes(self._engine, self._client, self._floor, self._solids)

    def place_movers(self, places: np.ndarray) -> None:
        """Put each mover somewhere: x, y and how far above its height, (movers, 3), m."""
        for (body, height), (x, y, z) in zip(self._movers, places.tolist(), strict=True):
            self._engine.resetBasePositionAndOrientation(
                body, (x, y, height + z), (0.0, 0.0, 0.0, 1.0), physicsClientId=self._client
            )
        self._rays.moved()

    def pose(self, name: str) -> SE2:
        """Return where a robot truly is."""
        (x, y, _), (qx, qy, qz, qw) = self._engine.getBasePositionAndOrientation(
            self._bodies[name], physicsClientId=self._client
        )
        yaw = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        return SE2(x, y, yaw)

    def is_touching(self, name: str) -> bool:
        """Tell whether a robot touches anything but the floor."""
        return any(c[2] != self._floor and c[8] <= 1e-4 for c in self._contacts(name))

    def cast_light(self, name: str, starts: np.ndarray, ends: np.ndarray) -> Hits:
        """Return where rays of light end, from and to points in the world, (N, 3) each, m.

        Neither glass stops them nor the robot that sends them.
        """
        return self._rays.cast(starts, ends, (self._groups[name], _GLASS_GROUP))

    def cast_sound(self, name: str, starts: np.ndarray, ends: np.ndarray) -> Hits:
        """Return where rays of sound end, from and to points in the world, (N, 3) each, m.

        Glass stops them; the robot that sends them does not.
        """
        return self._rays.cast(starts, ends, (self._groups[name],))

    def nearest_in_cone(
        self, name: str, place: np.ndarray, axis: np.ndarray, cos_half: float, reach: float
    ) -> np.ndarray:
        """Return unit vectors to the nearest points in a cone of sound, as `RayScene` does."""
        return self._rays.nearest_in_cone(place, axis, cos_half, reach, (self._groups[name],))

    def sensor_pose(self, name: str, T_base_sensor: np.ndarray) -> np.ndarray:
        """Return `T_world_sensor`, (4, 4)."""
        pose = self.pose(name)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        T_world_base = np.array([[c, -s, 0, pose.x], [s, c, 0, pose.y], [0, 0, 1, 0], [0, 0, 0, 1]])
        return np.asarray(T_world_base @ T_base_sensor)

    def picture(
        self,
        eye: tuple[float, float, float],
        target: tuple[float, float, float],
        size: tuple[int, int],
        fov_deg: float = 50.0,
        *,
        up: tuple[float, float, float] = (0.0, 1.0, 0.0),
        has_glass: bool = False,
    ) -> np.ndarray:
        """Return a picture of everything from a point, shape (height, width, 3), RGB uint8.

        Args:
            eye: Where the camera is, m.
            target: Where it looks, m.
            size: (width, height), pixels.
            fov_deg: Vertical field of view.
            up: What is up in the picture.
            has_glass: True paints panes over what is behind them; False leaves them out.
        """
        engine, client = self._engine, self._client
        paint(engine, client, self._panes, 1.0 if has_glass else self._glass_alpha)
        return engine_picture(engine, client, eye, target, size, fov_deg, up)

    def _meets_person(self, name: str) -> bool:
        contacts = () if not self._movers else self._contacts(name)
        return any(contact[2] in self._mover_bodies for contact in contacts)

    def _contacts(self, name: str) -> tuple[Any, ...]:
        body = self._bodies[name]
        found = self._engine.getContactPoints(bodyA=body, physicsClientId=self._client)
        return tuple(found or ())

    def _set_pose(self, name: str, pose: SE2) -> None:
        quat_xyzw = [0.0, 0.0, math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)]
        self._engine.resetBasePositionAndOrientation(
            self._bodies[name], [pose.x, pose.y, 0.0], quat_xyzw, physicsClientId=self._client
        )

    def _build(self) -> None:
        """Fill an empty engine."""
        self._bodies: dict[str, int] = {}
        self._groups: dict[str, int] = {}
        self._body_groups: dict[int, int] = {}
        self._panes: list[int] = []
        self._solids: dict[int, Solid] = {}
        engine, client = self._engine, self._client
        self._floor = self._add_solid(FLOOR)
        for solid in self._scenery:
            self._add_solid(solid)
        self._movers = [
            (self._add_solid(m), m.bottom + m.size[2] / 2.0) for m in self._mover_solids
        ]
        self._mover_bodies = {body for body, _ in self._movers}
        for name, (model, pose) in self._robots.items():
            self._add_robot(name, model, pose)
        engine.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        engine.setPhysicsEngineParameter(
            fixedTimeStep=self._dt, deterministicOverlappingPairs=1,
            numSubSteps=self._num_looks(), physicsClientId=client,
        )  # fmt: skip
        made_of = {body: NAMES.index(solid.surface) for body, solid in self._solids.items()}
        robots = dict.fromkeys(self._bodies.values(), NAMES.index("rough"))
        self._rays = RayScene(
            engine, client, self._body_groups, self._moving_bodies(), {**made_of, **robots}
        )

    def _add_solid(self, solid: Solid) -> int:
        alpha = 1.0 if solid.glass is None else self._glass_alpha
        body = make_solid(self._engine, self._client, solid, alpha)
        self._body_groups[body] = _SCENERY_GROUP if solid.glass is None else _GLASS_GROUP
        if solid.mass == 0.0:
            self._engine.setCollisionFilterGroupMask(
                body, -1, _STANDS, _ALL_COLLIDE & ~_STANDS, physicsClientId=self._client
            )
        if solid.glass is not None:
            self._panes.append(body)
        self._solids[body] = solid
        return body

    def _add_robot(self, name: str, model: RobotModel, pose: SE2) -> None:
        body = make_robot(self._engine, self._client, model, pose, self._floor)
        self._groups[name] = _FIRST_ROBOT_GROUP + len(self._bodies)
        self._bodies[name] = body
        self._body_groups[body] = self._groups[name]

    def _num_looks(self) -> int:
        """Return how often contacts are looked for in a step, so that nothing is passed through."""
        drives = [model.config.drive for model, _ in self._robots.values()]
        farthest = self._dt * max((drive.max_speed_m_s for drive in drives), default=0.0)
        return max(math.ceil(farthest / _FARTHEST), 1)

    def _moving_bodies(self) -> list[int]:
        pushed = [body for body, solid in self._solids.items() if solid.mass > 0.0]
        return [*pushed, *self._mover_bodies, *self._bodies.values()]
