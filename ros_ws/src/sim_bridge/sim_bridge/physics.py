"""The pybullet side: bodies, contacts, rays. Nothing else in the package knows pybullet.

Robots move in the plane: each step their floor velocity is set, the engine resolves contacts,
and height and tilt are put back. A robot against a wall stands while its wheels turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.bodies import FLOOR, make_robot, make_solid
from sim_bridge.drawn_shapes import DrawnShapes
from sim_bridge.drive import Velocity
from sim_bridge.engine import PybulletMissingError, connect, require_pybullet
from sim_bridge.engine_picture import engine_picture, paint
from sim_bridge.ray_scene import RayScene
from sim_bridge.rays import Hits
from sim_bridge.robot_model import RobotModel
from sim_bridge.solids import Solid

__all__ = ["Physics", "PybulletMissingError", "require_pybullet"]

_SCENERY_GROUP = 1
_GLASS_GROUP = 2
_ALL_GROUPS = 0x3FFFFFFF
_STANDING_GROUP = 1 << 29  # for contacts only


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
        self._bodies: dict[str, int] = {}
        self._groups: dict[str, int] = {}
        self._body_groups: dict[int, int] = {}
        self._panes: list[int] = []
        self._solids: dict[int, Solid] = {}
        # The engine's own renderer knows only opaque and absent; its window can blend.
        self._glass_alpha = 0.3 if has_window else 0.0
        self._floor = self._add_solid(FLOOR)
        for solid in solids:
            self._add_solid(solid)
        self._movers = [(self._add_solid(m), m.bottom + m.size[2] / 2.0) for m in movers]
        for name, (model, pose) in robots.items():
            self._add_robot(name, model, pose)
        engine, client = self._engine, self._client
        engine.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        engine.setPhysicsEngineParameter(
            fixedTimeStep=dt, deterministicOverlappingPairs=1, physicsClientId=client
        )
        self._start, self._dt = engine.saveState(physicsClientId=client), dt
        self._rays = RayScene(engine, client, self._body_groups, self._moving_bodies())

    def close(self) -> None:
        """Free the engine."""
        if self._engine.isConnected(self._client):
            self._engine.disconnect(physicsClientId=self._client)

    def reset(self) -> None:
        """Put every body back to where it started."""
        self._engine.restoreState(stateId=self._start, physicsClientId=self._client)
        self._rays.moved()

    def step(self, velocities: dict[str, Velocity]) -> None:
        """Move everything on by one step; every robot needs its floor velocity."""
        for name, velocity in velocities.items():
            self._set_velocity(name, velocity)
        self._engine.stepSimulation(physicsClientId=self._client)
        for name in velocities:
            self._set_pose(name, self.pose(name))
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
        contacts = self._engine.getContactPoints(
            bodyA=self._bodies[name], physicsClientId=self._client
        )
        return any(c[2] != self._floor and c[8] <= 1e-4 for c in contacts)

    def cast(self, name: str, T_base_sensor: np.ndarray, rays_sensor: np.ndarray) -> np.ndarray:
        """Return how far light rays of a robot's sensor reach, in shares of their length.

        Args:
            name: The robot; its own body does not stop its rays, nor does glass.
            T_base_sensor: Pose of the sensor on the robot, (4, 4).
            rays_sensor: End of each ray in the sensor frame, shape (N, 3), m.

        Returns:
            Shape (N,): 0..1 where something is hit, inf where nothing is.
        """
        T = self.sensor_pose(name, T_base_sensor)
        ends = rays_sensor @ T[:3, :3].T + T[:3, 3]
        starts = np.broadcast_to(T[:3, 3], ends.shape)
        mask = _ALL_GROUPS & ~self._groups[name] & ~_GLASS_GROUP
        return self._rays.cast(starts, ends, mask).shares

    def cast_sound(self, name: str, starts: np.ndarray, ends: np.ndarray) -> Hits:
        """Return where rays of sound end, from and to points in the world, (N, 3) each, m.

        Glass stops them; the robot that sends them does not.
        """
        mask = _ALL_GROUPS & ~self._groups[name]
        return self._rays.cast(starts, ends, mask)

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

    def _set_velocity(self, name: str, velocity: Velocity) -> None:
        # Along the middle direction of the step, with the chord of the arc: no curve is cut.
        turn = velocity.yaw_rate * self._dt
        middle = self.pose(name).yaw + turn / 2.0
        shrunk = float(np.sinc(turn / (2.0 * np.pi)))
        ahead, aside = shrunk * velocity.speed, shrunk * velocity.side_speed
        c, s = math.cos(middle), math.sin(middle)
        self._engine.resetBaseVelocity(
            self._bodies[name],
            [ahead * c - aside * s, ahead * s + aside * c, 0.0],
            [0.0, 0.0, velocity.yaw_rate],
            physicsClientId=self._client,
        )

    def _set_pose(self, name: str, pose: SE2) -> None:
        quat_xyzw = [0.0, 0.0, math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)]
        self._engine.resetBasePositionAndOrientation(
            self._bodies[name], [pose.x, pose.y, 0.0], quat_xyzw, physicsClientId=self._client
        )

    def _add_solid(self, solid: Solid) -> int:
        alpha = 1.0 if solid.glass is None else self._glass_alpha
        body = make_solid(self._engine, self._client, solid, alpha)
        group = _SCENERY_GROUP if solid.glass is None else _GLASS_GROUP
        # What stands for ever need not be tested against each other: that is most of a step.
        stands = solid.mass == 0.0
        self._set_group(body, group, _ALL_GROUPS & ~_STANDING_GROUP if stands else _ALL_GROUPS)
        if solid.glass is not None:
            self._panes.append(body)
        self._solids[body] = solid
        return body

    def _add_robot(self, name: str, model: RobotModel, pose: SE2) -> None:
        body = make_robot(self._engine, self._client, model, pose, self._floor)
        self._bodies[name] = body
        self._groups[name] = 1 << (len(self._bodies) + 1)
        self._set_group(body, self._groups[name])

    def _moving_bodies(self) -> list[int]:
        pushed = [body for body, solid in self._solids.items() if solid.mass > 0.0]
        return [*pushed, *(body for body, _ in self._movers), *self._bodies.values()]

    def _set_group(self, body: int, group: int, mask: int = _ALL_GROUPS) -> None:
        self._body_groups[body] = group
        if mask != _ALL_GROUPS:
            group = _STANDING_GROUP
        for link in range(-1, self._engine.getNumJoints(body, physicsClientId=self._client)):
            self._engine.setCollisionFilterGroupMask(
                body, link, group, mask, physicsClientId=self._client
            )
