"""Solids and robots as bodies of the engine."""

from __future__ import annotations

import math
from typing import Any

from floornav_common.se2 import SE2
from sim_bridge.robot_model import RobotModel
from sim_bridge.solids import Solid

FLOOR = Solid("floor", SE2.identity(), (100.0, 100.0, 0.1), -0.1, False, (0.62, 0.60, 0.56), 0.0)

_UNTILTABLE = 1e6  # kg m^2


def make_solid(engine: Any, client: int, solid: Solid, alpha: float) -> int:
    """Return the body of a solid; `alpha` is how opaque it is drawn, 0..1."""
    half = [extent / 2.0 for extent in solid.size]
    shape: dict[str, Any] = {"radius": half[0]} if solid.is_round else {"halfExtents": half}
    lengths: tuple[dict[str, float], dict[str, float]] = {}, {}
    kind = engine.GEOM_BOX
    if solid.is_ball:
        kind = engine.GEOM_SPHERE
    elif solid.is_round:
        kind = engine.GEOM_CYLINDER
        lengths = {"height": solid.size[2]}, {"length": solid.size[2]}
    color = [*solid.color, alpha]
    body: int = engine.createMultiBody(
        solid.mass,
        engine.createCollisionShape(kind, **shape, **lengths[0], physicsClientId=client),
        engine.createVisualShape(
            kind, rgbaColor=color, **shape, **lengths[1], physicsClientId=client
        ),
        [solid.pose.x, solid.pose.y, solid.bottom + half[2]],
        _turned(solid.pose.yaw),
        physicsClientId=client,
    )
    return body


def make_robot(engine: Any, client: int, model: RobotModel, pose: SE2, floor: int) -> int:
    """Return the body of a robot, which the floor body does not touch: it moves in the plane.

    It is as good as infinitely hard to tilt: what is met far from the height of its middle of mass
    must stop it, and not tip it.
    """
    body: int = engine.loadURDF(
        str(model.urdf_path),
        [pose.x, pose.y, 0.0],
        _turned(pose.yaw),
        flags=engine.URDF_USE_IMPLICIT_CYLINDER,  # not a polyhedron
        physicsClientId=client,
    )
    izz = engine.getDynamicsInfo(body, -1, physicsClientId=client)[2][2]
    engine.changeDynamics(
        body, -1, localInertiaDiagonal=[_UNTILTABLE, _UNTILTABLE, izz], physicsClientId=client
    )
    for link in range(-1, engine.getNumJoints(body, physicsClientId=client)):
        engine.changeDynamics(
            body, link, linearDamping=0.0, angularDamping=0.0, lateralFriction=0.2,
            physicsClientId=client,
        )  # fmt: skip
        engine.setCollisionFilterPair(body, floor, link, -1, 0, physicsClientId=client)
    return body


def _turned(yaw: float) -> list[float]:
    return [0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)]
