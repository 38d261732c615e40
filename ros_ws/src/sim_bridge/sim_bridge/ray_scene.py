"""Rays against all bodies of an engine, by a kernel of ours instead of the engine's own.

Sensors cast tens of thousands of rays in a simulated second; the engine takes about 7 us for each
in a furnished floor (107 bodies), most of it for lists of Python numbers, the kernel under 1 us.
Shapes are the collision shapes: boxes, cylinders and spheres; nothing else is taken.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numba
import numpy as np
from scipy.spatial.transform import Rotation

from sim_bridge.nearest import nearest_in_cone
from sim_bridge.ray_shapes import HALF, NUM_COLUMNS, meet, normal_at, turned
from sim_bridge.rays import Hits
from sim_bridge.schema import WorldError
from sim_bridge.shape_kinds import BOX, CYLINDER, SPHERE


class RayScene:
    """The collision shapes of an engine, ready for rays.

    Args:
        engine: Pybullet.
        client: Its client.
        groups: Number of the group of each body, by body.
        moving: Bodies that may move.
        surfaces: What each body is made of, as a number of `surfaces.NAMES`, by body.

    Raises:
        WorldError: A body has a collision shape that is no box, cylinder or sphere.
    """

    def __init__(
        self,
        engine: Any,
        client: int,
        groups: Mapping[int, int],
        moving: Iterable[int],
        surfaces: Mapping[int, int],
    ) -> None:
        self._engine, self._client, self._moving = engine, client, list(moving)
        shapes = [
            (body, link, kind, half, T_link_shape)
            for body in groups
            for link in range(-1, engine.getNumJoints(body, physicsClientId=client))
            for kind, half, T_link_shape in _shapes_of(engine, client, body, link)
        ]
        self._kinds = np.array([shape[2] for shape in shapes], dtype=np.int64)
        self._seen_rows: dict[tuple[int, ...], np.ndarray] = {}
        self._groups = np.array([groups[shape[0]] for shape in shapes], dtype=np.int64)
        self._T_body_shape = np.array([shape[4] for shape in shapes]).reshape(-1, 4, 4)
        self._places = np.zeros((len(shapes), NUM_COLUMNS))
        self._places[:, HALF : HALF + 3] = np.array([s[3] for s in shapes]).reshape(-1, 3)
        self._middles = np.zeros((len(shapes), 3))
        self._surfaces = np.array([surfaces[shape[0]] for shape in shapes], dtype=np.int64)
        bodies = np.array([shape[0] for shape in shapes])
        self._rows = {body: np.flatnonzero(bodies == body) for body in groups}
        self._place(list(groups))
        self._is_old = False
        # Compiles the kernels, if they are not yet.
        self.cast(np.zeros((0, 3)), np.zeros((0, 3)))
        self.nearest_in_cone(np.zeros(3), np.zeros(3), 0.0, 0.0)

    def moved(self) -> None:
        """Note that bodies may have moved."""
        self._is_old = True

    def cast(self, starts: np.ndarray, ends: np.ndarray, unseen: tuple[int, ...] = ()) -> Hits:
        """Return where rays from `starts` to `ends`, (N, 3) each, m, meet the first shape.

        Shapes of the groups `unseen` do not stop them.
        """
        self._bring_up_to_date()
        shares, normals = np.empty(len(ends)), np.zeros((len(ends), 3))
        firsts = np.empty(len(ends), dtype=np.int64)
        seen = self._seen(unseen)
        _cast(
            np.ascontiguousarray(starts, dtype=float), np.ascontiguousarray(ends, dtype=float),
            self._places, self._kinds, self._middles, seen, shares, normals, firsts,
        )  # fmt: skip
        return Hits(shares, normals, np.where(firsts < 0, 0, self._surfaces[firsts]))

    def nearest_in_cone(
        self,
        place: np.ndarray,
        axis: np.ndarray,
        cos_half: float,
        reach: float,
        unseen: tuple[int, ...] = (),
    ) -> np.ndarray:
        """Return unit vectors to the nearest point of each shape that has it in a cone, (K, 3).

        Args:
            place: Tip of the cone in the world, (3,), m.
            axis: Unit vector along it, (3,).
            cos_half: Cosine of its half angle.
            reach: Points farther than this are left out, m.
            unseen: As for `cast`.
        """
        self._bring_up_to_date()
        seen = self._seen(unseen)
        headings = np.empty((len(seen), 3))
        num = nearest_in_cone(
            np.ascontiguousarray(place), np.ascontiguousarray(axis), float(cos_half), float(reach),
            self._places, self._kinds, self._middles, seen, headings,
        )  # fmt: skip
        return headings[:num]

    def _bring_up_to_date(self) -> None:
        if self._is_old:
            self._place(self._moving)
            self._is_old = False

    def _seen(self, unseen: tuple[int, ...]) -> np.ndarray:
        """Return the rows of shapes of all groups but `unseen`."""
        if unseen not in self._seen_rows:
            self._seen_rows[unseen] = np.flatnonzero(~np.isin(self._groups, unseen))
        return self._seen_rows[unseen]

    def _place(self, bodies: list[int]) -> None:
        """Read where bodies are, and turn that into the kernel's rows."""
        bodies = [body for body in bodies if len(self._rows[body])]
        if not bodies:
            return
        poses = [
            self._engine.getBasePositionAndOrientation(body, physicsClientId=self._client)
            for body in bodies
        ]
        T = np.tile(np.eye(4), (len(bodies), 1, 1))
        T[:, :3, 3] = [position for position, _ in poses]
        T[:, :3, :3] = Rotation.from_quat([quat_xyzw for _, quat_xyzw in poses]).as_matrix()
        rows = np.concatenate([self._rows[body] for body in bodies])
        counts = [len(self._rows[body]) for body in bodies]
        T_world_shape = np.repeat(T, counts, axis=0) @ self._T_body_shape[rows]
        R_shape_world = np.swapaxes(T_world_shape[:, :3, :3], 1, 2)
        self._middles[rows] = T_world_shape[:, :3, 3]
        self._places[rows, :9] = R_shape_world.reshape(-1, 9)


def _shapes_of(
    engine: Any, client: int, body: int, link: int
) -> list[tuple[int, tuple[float, float, float], np.ndarray]]:
    """Return kind, half extents and pose in the body of each collision shape of a link."""
    T_body_link, shapes = np.eye(4), []
    data = engine.getCollisionShapeData(body, link, physicsClientId=client)
    if data and link >= 0:
        T_world_link = _matrix(*engine.getLinkState(body, link, physicsClientId=client)[:2])
        base = engine.getBasePositionAndOrientation(body, physicsClientId=client)
        T_body_link = np.linalg.inv(_matrix(*base)) @ T_world_link
    for _, _, geometry, (a, b, c), _, position, quat_xyzw in data:
        if geometry == engine.GEOM_BOX:
            kind, half = BOX, (a / 2.0, b / 2.0, c / 2.0)
        elif geometry == engine.GEOM_CYLINDER:
            kind, half = CYLINDER, (b, b, a / 2.0)
        elif geometry == engine.GEOM_SPHERE:
            kind, half = SPHERE, (a, a, a)
        else:
            raise WorldError("collision shapes must be boxes, cylinders or spheres")
        shapes.append((kind, half, T_body_link @ _matrix(position, quat_xyzw)))
    return shapes


def _matrix(position: Any, quat_xyzw: Any) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = position, Rotation.from_quat(quat_xyzw).as_matrix()
    return T


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _cast(  # type: ignore[no-untyped-def]
    starts, ends, places, kinds, middles, seen, shares, normals, firsts
):
    """Fill shares of the rays' lengths (inf for no hit), normals in the world, shapes (or -1)."""
    radii = np.empty(len(kinds))
    for i in seen:
        x, y, z = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
        radii[i] = x * x + y * y + z * z
    for n in range(len(ends)):
        sx, sy, sz = starts[n, 0], starts[n, 1], starts[n, 2]
        dx, dy, dz = ends[n, 0] - sx, ends[n, 1] - sy, ends[n, 2] - sz
        length2 = max(dx * dx + dy * dy + dz * dz, 1e-18)
        length, best, first = np.sqrt(length2), 1.0, len(kinds)
        for i in seen:
            mx, my, mz = middles[i, 0] - sx, middles[i, 1] - sy, middles[i, 2] - sz
            along = mx * dx + my * dy + mz * dz
            # A ray that misses the ball round a shape misses the shape.
            off2 = mx * mx + my * my + mz * mz - along * along / length2
            if off2 > radii[i]:
                continue
            ox, oy, oz = turned(places, i, -mx, -my, -mz)
            rx, ry, rz = turned(places, i, dx, dy, dz)
            hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
            rx, ry, rz = rx / length, ry / length, rz / length
            share = meet(kinds[i], hx, hy, hz, ox, oy, oz, rx, ry, rz) / length
            if share < best:
                best, first = share, i
        shares[n] = best if first < len(kinds) else np.inf
        firsts[n] = first if first < len(kinds) else -1
        if first < len(kinds):
            x, y, z = sx + best * dx, sy + best * dy, sz + best * dz
            _write_normal(kinds[first], places, middles, first, x, y, z, normals, n)


@numba.njit(cache=True, error_model="numpy")
def _write_normal(  # type: ignore[no-untyped-def]
    kind, places, middles, i, x, y, z, normals, n
):
    """Write the outward normal of shape i at a point, in the world, to row n of normals."""
    px, py, pz = turned(places, i, x - middles[i, 0], y - middles[i, 1], z - middles[i, 2])
    hx, hy, hz = places[i, HALF], places[i, HALF + 1], places[i, HALF + 2]
    a, b, c = normal_at(kind, hx, hy, hz, px, py, pz)
    for k in range(3):
        normals[n, k] = places[i, k] * a + places[i, 3 + k] * b + places[i, 6 + k] * c
