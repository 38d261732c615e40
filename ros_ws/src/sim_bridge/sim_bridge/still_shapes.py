"""Boxes and columns for the renderer without an engine: rooms to take pictures in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.shape_kinds import BOX, CYLINDER
from sim_bridge.solids import Solid


class Drawable(Protocol):
    """What a `Scene` draws; see `DrawnShapes` for shapes and units."""

    kinds: np.ndarray
    halves: np.ndarray
    colors: np.ndarray
    is_glass: np.ndarray
    textures: list[str]

    def poses(self) -> np.ndarray:
        """Return `T_world_shape` of each shape now, (N, 4, 4)."""


class StillShapes:
    """Upright solids where they stand, until one is put elsewhere.

    Args:
        solids: Boxes and columns; neither balls nor glass.

    Raises:
        ValueError: There is a ball or a pane.
    """

    def __init__(self, solids: Sequence[Solid]) -> None:
        if any(s.is_ball or s.glass is not None for s in solids):
            raise ValueError("solids must be boxes and columns, got a ball or a pane of glass")
        self.kinds = np.array([CYLINDER if s.is_round else BOX for s in solids], dtype=np.int64)
        self.halves = np.array([s.size for s in solids]) / 2.0
        self.colors = np.array([s.color for s in solids], dtype=float)
        self.is_glass = np.zeros(len(solids), dtype=bool)
        self.textures = [s.texture for s in solids]
        self._T = np.stack([solid_pose(s) for s in solids])

    def poses(self) -> np.ndarray:
        """Return `T_world_shape` of each shape now, (N, 4, 4)."""
        return self._T

    def put(self, index: int, pose: SE2, color: tuple[float, float, float]) -> None:
        """Stand a shape elsewhere on the floor, in another color."""
        self._T[index] = upright_pose(pose, self.halves[index, 2])
        self.colors[index] = color


def solid_pose(solid: Solid) -> np.ndarray:
    """Return `T_world_middle` of a solid, (4, 4)."""
    return upright_pose(solid.pose, solid.bottom + solid.size[2] / 2.0)


def upright_pose(pose: SE2, up: float) -> np.ndarray:
    """Return a pose on the floor lifted by `up`, (4, 4)."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    T = np.eye(4)
    T[:2, :2], T[:3, 3] = ((c, -s), (s, c)), (pose.x, pose.y, up)
    return T
