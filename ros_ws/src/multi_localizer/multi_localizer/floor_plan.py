"""The known shape of a floor: a polygon of walls, and where its goals are.

A file holds `corners_m`, counter-clockwise, of a convex, a rectilinear or any other polygon:

    name: small_size_field
    corners_m: [[1.37, -0.76], ...]
    unused_edges: [1, 3]                # edges (from corner k) that the published fit leaves out
    goals_m: {goal_yellow: [1.55, 0.0]} # what tells the two ends apart, by class of bearing
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from floornav_common.config_files import coerce, refuse_unknown
from floornav_common.package_files import find_file
from floornav_common.se2 import SE2

SYMMETRY_TOL_M = 1e-3
MAX_REACH_M = 200.0
"""No camera sees the border of a larger floor: its file is in other units."""
_KEYS = ("name", "corners_m", "unused_edges", "goals_m")


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """A floor's border.

    Attributes:
        corners: Of the polygon, counter-clockwise, (N, 2), m, in the map frame.
        name: What it is called.
        goals: Places by class of bearing, m.
        unused_edges: Edges that the published step 6 does not know.
    """

    corners: np.ndarray
    name: str = ""
    goals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    unused_edges: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        corners = np.array(self.corners, dtype=float)
        if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 3:
            raise ValueError(f"corners must be (N, 2), N >= 3, got {corners.shape}")
        if not np.isfinite(corners).all():
            raise ValueError("corners must be finite")
        extent = float(np.ptp(corners, axis=0).max())
        if extent > MAX_REACH_M:
            raise ValueError(f"corners_m spans {extent:g} m: are they millimeters?")
        if np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).min() <= 0.0:
            raise ValueError("corners must differ from their neighbors")
        if _crosses_itself(corners):
            raise ValueError("corners must make a border that does not cross itself")
        if _area(corners) <= 0.0:
            raise ValueError("corners must run counter-clockwise around an area")
        _refuse_far_goals(self.goals, corners, extent)
        if any(not 0 <= k < len(corners) for k in self.unused_edges):
            raise ValueError(f"unused_edges must be in 0..{len(corners) - 1}: {self.unused_edges}")
        corners.flags.writeable = False
        object.__setattr__(self, "corners", corners)

    @cached_property
    def tangents(self) -> np.ndarray:
        """Unit vectors along the edges, (N, 2)."""
        along = np.roll(self.corners, -1, axis=0) - self.corners
        return np.asarray(along / self.lengths[:, None])

    @cached_property
    def lengths(self) -> np.ndarray:
        """Of the edges, (N,), m."""
        along = np.roll(self.corners, -1, axis=0) - self.corners
        return np.asarray(np.hypot(along[:, 0], along[:, 1]))

    @cached_property
    def normals(self) -> np.ndarray:
        """Unit normals that point out of the floor, (N, 2)."""
        return np.stack((self.tangents[:, 1], -self.tangents[:, 0]), axis=-1)

    @cached_property
    def offsets(self) -> np.ndarray:
        """Distances of the edges' lines from the origin, c in n . p = c, (N,), m."""
        return np.asarray((self.normals * self.corners).sum(axis=1))

    @cached_property
    def symmetries(self) -> tuple[SE2, ...]:
        """Motions that leave the border as it is, the one that moves nothing first."""
        middle = self.corners.mean(axis=0)
        around = self.corners - middle
        found = [SE2.identity()]
        for k in range(1, len(around)):
            to = np.roll(around, -k, axis=0)
            cross = (around[:, 0] * to[:, 1] - around[:, 1] * to[:, 0]).sum()
            turn = SE2(0.0, 0.0, math.atan2(cross, (around * to).sum()))
            if np.abs(turn @ around - to).max() < SYMMETRY_TOL_M:
                x, y = middle - (turn @ middle[None])[0]
                found.append(SE2(float(x), float(y), turn.yaw))
        return tuple(found)

    @cached_property
    def reach(self) -> float:
        """Largest distance between two corners, m."""
        apart = self.corners[:, None] - self.corners[None]
        return float(np.hypot(apart[..., 0], apart[..., 1]).max())

    def contains(self, x: float, y: float) -> bool:
        """Return whether a place is on the floor."""
        num = 0
        for (x1, y1), (x2, y2) in self._edges:
            if (y1 > y) != (y2 > y):
                num += x < x1 + (y - y1) * (x2 - x1) / (y2 - y1)
        return bool(num % 2)

    @cached_property
    def _edges(self) -> list[tuple[list[float], list[float]]]:
        """Both ends of each edge, m."""
        ends: list[list[float]] = self.corners.tolist()
        return list(zip(ends, ends[1:] + ends[:1], strict=True))


def load_plan(name_or_path: str) -> FloorPlan:
    """Return the plan of a file.

    Args:
        name_or_path: A path that ends in `.yaml` or `.yml`, or a plan of the package.

    Raises:
        ValueError: There is none, or it does not hold to the schema.
    """
    path = find_file(name_or_path, "multi_localizer", "plans")
    data = _read(path)
    refuse_unknown([str(key) for key in data], _KEYS, str(path))
    if not isinstance(data.get("corners_m"), list):
        raise ValueError(f"{path}: corners_m must be a list of [x, y]")
    try:
        corners = [coerce("corners_m", tuple[float, float], c) for c in data["corners_m"]]
        goals = {
            str(name): coerce(f"goals_m.{name}", tuple[float, float], place)
            for name, place in (data.get("goals_m") or {}).items()
        }
        unused = coerce("unused_edges", tuple[int, ...], data.get("unused_edges", []))
        return FloorPlan(np.array(corners), str(data.get("name", path.stem)), goals, unused)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _read(path: Path) -> dict[str, Any]:
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict):
        raise ValueError(f"{path}: must hold a mapping, got {type(data).__name__}")
    return data


def _refuse_far_goals(
    goals: Mapping[str, tuple[float, float]], corners: np.ndarray, extent: float
) -> None:
    """Raise for a goal farther from the border than the floor is long."""
    for kind, place in goals.items():
        outside = np.maximum(corners.min(axis=0) - place, place - corners.max(axis=0)).max()
        if not outside <= extent:
            raise ValueError(
                f"goals_m.{kind} at ({place[0]:g}, {place[1]:g}) lies {outside:g} m outside of a "
                f"floor of {extent:g} m: another unit?"
            )


def _area(corners: np.ndarray) -> float:
    (x1, y1), (x2, y2) = corners.T, np.roll(corners, -1, axis=0).T
    return float((x1 * y2 - x2 * y1).sum() / 2.0)


def _crosses_itself(corners: np.ndarray) -> bool:
    """Return whether two edges that are no neighbors meet."""
    starts, ends = corners, np.roll(corners, -1, axis=0)
    n = len(corners)

    def side(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
        (ax, ay), (bx, by) = (b - a).T, (p - a).T
        return np.asarray(np.sign(ax * by - ay * bx))

    i, j = np.triu_indices(n, 2)
    keep = (j - i) % n != n - 1
    a, b, c, d = starts[i[keep]], ends[i[keep]], starts[j[keep]], ends[j[keep]]
    crossing = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return bool(crossing.any())
