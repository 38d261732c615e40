"""What the engine shows: shapes with their colors, and where they are now."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from sim_bridge.schema import WorldError
from sim_bridge.shape_kinds import BOX, CONE, CYLINDER, SPHERE
from sim_bridge.solids import Solid

_CONE_MESH = "cone.obj"


class _Shape(NamedTuple):
    kind: int
    half: tuple[float, float, float]
    up: float  # of its middle in the visual's frame, m


class DrawnShapes:
    """Every visual shape of an engine but the floor.

    Attributes:
        kinds: As in `ray_shapes`, (N,).
        halves: Half extents, (N, 3), m.
        colors: RGB, 0..1, (N, 3).
        is_glass: (N,).
        textures: Name of the pattern of each, "" for none.
    """

    def __init__(self, engine: Any, client: int, floor: int, solids: dict[int, Solid]) -> None:
        """Read all bodies of the engine.

        Raises:
            WorldError: A robot has a mesh other than the unit cone.
        """
        self._engine, self._client = engine, client
        shapes, places, links, colors, panes, names = [], [], [], [], [], []
        for body in (engine.getBodyUniqueId(k, client) for k in range(engine.getNumBodies(client))):
            if body == floor:
                continue
            solid = solids.get(body)
            for data in engine.getVisualShapeData(body, physicsClientId=client):
                for shape in _parts(engine, data):
                    shapes.append(shape)
                    places.append(_place(data[5], data[6]) @ _lifted(shape.up))
                    links.append((body, data[1]))
                    colors.append(data[7][:3] if solid is None else solid.color)
                    panes.append(solid is not None and solid.glass is not None)
                    names.append("" if solid is None else solid.texture)
        self.kinds = np.array([shape.kind for shape in shapes], dtype=np.int64)
        self.halves = np.array([shape.half for shape in shapes]).reshape(-1, 3)
        self.colors = np.array(colors, dtype=float).reshape(-1, 3)
        self.is_glass = np.array(panes, dtype=bool)
        self.textures: list[str] = names
        self._T_link_shape = np.array(places).reshape(-1, 4, 4)
        self._links = list(dict.fromkeys(links))
        self._link_of = np.array([self._links.index(link) for link in links], dtype=np.int64)

    def poses(self) -> np.ndarray:
        """Return `T_world_shape` of each shape now, (N, 4, 4)."""
        if not self._links:
            return np.zeros((0, 4, 4))
        now = [self._link_pose(body, link) for body, link in self._links]
        T = np.tile(np.eye(4), (len(now), 1, 1))
        T[:, :3, 3] = [position for position, _ in now]
        T[:, :3, :3] = Rotation.from_quat([quat_xyzw for _, quat_xyzw in now]).as_matrix()
        return np.asarray(T[self._link_of] @ self._T_link_shape)

    def _link_pose(self, body: int, link: int) -> tuple[Any, Any]:
        # A base's own frame is its middle of mass; robots have theirs at base_link's origin.
        if link < 0:
            return self._engine.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return self._engine.getLinkState(body, link, physicsClientId=self._client)[4:6]


def _parts(engine: Any, data: tuple[Any, ...]) -> list[_Shape]:
    kind, (a, b, c), mesh = data[2], data[3], PurePath(data[4].decode()).name
    if kind == engine.GEOM_BOX:
        return [_Shape(BOX, (a / 2.0, b / 2.0, c / 2.0), 0.0)]
    if kind == engine.GEOM_SPHERE:
        return [_Shape(SPHERE, (a, a, a), 0.0)]
    if kind == engine.GEOM_CYLINDER:
        return [_Shape(CYLINDER, (b, b, a / 2.0), 0.0)]
    if kind == engine.GEOM_CAPSULE:
        ends = [_Shape(SPHERE, (b, b, b), up) for up in (-a / 2.0, a / 2.0)]
        return [_Shape(CYLINDER, (b, b, a / 2.0), 0.0), *ends]
    if kind == engine.GEOM_MESH and mesh == _CONE_MESH:
        return [_Shape(CONE, (a, b, c / 2.0), c / 2.0)]
    raise WorldError(f"cameras draw boxes, spheres, cylinders, capsules and {_CONE_MESH}: {mesh!r}")


def _place(position: Any, quat_xyzw: Any) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = position, Rotation.from_quat(quat_xyzw).as_matrix()
    return T


def _lifted(up: float) -> np.ndarray:
    T = np.eye(4)
    T[2, 3] = up
    return T
