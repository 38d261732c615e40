"""Pictures by the engine's own renderer: no textures, and glass either painted or not there."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

Point = tuple[float, float, float]


def engine_picture(
    engine: Any,
    client: int,
    eye: Point,
    target: Point,
    size: tuple[int, int],
    fov_deg: float,
    up: Point,
) -> np.ndarray:
    """Return what is seen from a point, shape (height, width, 3), RGB uint8.

    Args:
        engine: Pybullet.
        client: Its client.
        eye: Where the camera is, m.
        target: Where it looks, m.
        size: (width, height), pixels.
        fov_deg: Vertical field of view.
        up: What is up in the picture.
    """
    width, height = size
    view = engine.computeViewMatrix(eye, target, up)
    lens = engine.computeProjectionMatrixFOV(fov_deg, width / height, 0.1, 100.0)
    image = engine.getCameraImage(
        width, height, view, lens, shadow=0, lightDirection=[-4.0, -6.0, 14.0],
        renderer=engine.ER_TINY_RENDERER, physicsClientId=client,
    )[2]  # fmt: skip
    return np.reshape(np.asarray(image, dtype=np.uint8), (height, width, 4))[:, :, :3]


def paint(engine: Any, client: int, bodies: Iterable[int], alpha: float) -> None:
    """Give bodies an opacity; the renderer knows only 0 and all else."""
    for body in bodies:
        color = engine.getVisualShapeData(body, physicsClientId=client)[0][7]
        engine.changeVisualShape(body, -1, rgbaColor=[*color[:3], alpha], physicsClientId=client)
