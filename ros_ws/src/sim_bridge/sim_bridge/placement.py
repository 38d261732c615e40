"""Where robots may start: not inside anything, nor inside each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.bodies import FLOOR
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.robot_model import RobotModel
from sim_bridge.schema import WorldError
from sim_bridge.solids import Solid
from sim_bridge.world import World

_PER_EDGE = 20
_RINGS = 12
_PERSON_HEIGHT = 1.7
_STEPPED_OVER = 0.1


def require_free(
    models: Mapping[str, RobotModel], starts: Mapping[str, SE2], solids: Sequence[Solid]
) -> None:
    """Check that every robot starts in free space.

    Raises:
        WorldError: A robot starts inside a solid or another robot; both are named.
    """
    names = list(models)
    for number, name in enumerate(names):
        model, start = models[name], starts[name]
        footprint = start @ _filled(model)
        where = f"robot {_called(name)} at ({start.x:g}, {start.y:g})"
        if (FLOOR.signed_distance(footprint) > 0.0).any():
            raise WorldError(f"{where} is off the floor, {FLOOR.size[0]:g} x {FLOOR.size[1]:g} m")
        for solid in solids:
            reaches = solid.bottom < model.config.height_m
            if reaches and (solid.signed_distance(footprint) <= 0.0).any():
                raise WorldError(f"{where} is inside {solid.name!r}")
        for other in names[:number]:
            if _is_inside(models[other], starts[other].inverse() @ footprint).any():
                raise WorldError(f"{where} is inside robot {_called(other)}")


def oddities(world: World) -> list[str]:
    """Return what is allowed in a world but hardly meant, a sentence each."""
    found = []
    if not world.robots:
        found.append(f"world {world.name}: no robots, nothing but /clock and people will move")
    ends = np.array([end for wall in world.walls for end in (wall.from_m, wall.to_m)])
    for robot in world.robots if len(ends) > 2 else ():
        place = np.array(robot.position_m)
        if (place < ends.min(axis=0)).any() or (place > ends.max(axis=0)).any():
            x, y = robot.position_m
            found.append(f"robot {_called(robot.name)} at ({x:g}, {y:g}) is outside all walls")
    return found


def require_people_free(
    plans: Sequence[WalkerPlan],
    radius: float,
    T_world_file: SE2,
    models: Mapping[str, RobotModel],
    starts: Mapping[str, SE2],
    solids: Sequence[Solid],
) -> None:
    """Check that everyone with a plan starts in free space.

    Args:
        plans: The people.
        radius: Of a body, m.
        T_world_file: How the world was moved; plans are in the coordinates of its file.
        models: Robots by name.
        starts: Their poses.
        solids: The scenery, as it was moved.

    Raises:
        WorldError: Somebody starts inside a solid or a robot; both are named.
    """
    for plan in plans:
        point = T_world_file @ np.array([plan.path_m[0]])
        where = f"person {plan.name!r} at ({plan.path_m[0][0]:g}, {plan.path_m[0][1]:g})"
        for solid in solids:
            is_near = solid.bottom < _PERSON_HEIGHT and solid.size[2] + solid.bottom > _STEPPED_OVER
            if is_near and solid.signed_distance(point)[0] < radius:
                raise WorldError(f"{where} stands in {solid.name!r}")
        for name, start in starts.items():
            off = np.hypot(*(start @ _filled(models[name]) - point).T)
            if off.min() < radius:
                raise WorldError(f"{where} stands in robot {_called(name)}")


def _filled(model: RobotModel) -> np.ndarray:
    """Return points all over a footprint, in the base frame, (N, 2)."""
    corners = np.array(model.config.footprint_m)
    middle = corners.mean(axis=0)
    edge = np.linspace(corners, np.roll(corners, -1, axis=0), _PER_EDGE).reshape(-1, 2)
    return np.vstack([middle + s * (edge - middle) for s in np.linspace(0.0, 1.0, _RINGS)])


def _is_inside(model: RobotModel, points: np.ndarray) -> np.ndarray:
    """Tell which points (N, 2) in the base frame lie in a convex footprint, shape (N,)."""
    corners = np.array(model.config.footprint_m)
    edges = np.roll(corners, -1, axis=0) - corners
    off = points[:, None, :] - corners
    side = edges[:, 0] * off[..., 1] - edges[:, 1] * off[..., 0]
    return np.asarray((side >= 0.0).all(axis=1) | (side <= 0.0).all(axis=1))


def _called(name: str) -> str:
    return name or "(unnamed)"
