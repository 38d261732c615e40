"""Landmarks of a place: what is seen by class, and where it stands in the map.

A file is a mapping from classes to where their landmarks are; `bearings/<class>` is where they are
seen. Several of one class cannot be told apart by sight.

    pole: {positions_m: [[0.0, 2.0], [3.0, 2.0]]}        # thin things
    goal_blue:                                           # wide things: corners on the floor
      outlines_m: [[[-4.66, -0.8], [-4.11, -0.8], [-4.11, 0.8], [-4.66, 0.8]]]
    goal_blue_left:                                      # bearings of the left end of one
      outlines_m: [[[-4.66, -0.8], [-4.11, -0.8], [-4.11, 0.8], [-4.66, 0.8]]]
      seen: left
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from floornav_common.config_files import refuse_unknown
from floornav_common.package_files import find_file

PARTS = ("middle", "left", "right")
_SAME_M = 1e-3
_KEYS = ("positions_m", "outlines_m", "seen")
Landmarks = Mapping[str, tuple["Landmark", ...]]


class _OnceEach(yaml.SafeLoader):
    """Refuses a key that stands twice; YAML would silently take the last."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key.value for key, _ in node.value]
        doubled = sorted({key for key in keys if keys.count(key) > 1})
        if doubled:
            raise yaml.YAMLError(f"{doubled[0]!r} stands there twice")
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


@dataclass(frozen=True)
class Landmark:
    """One thing that is seen in a direction.

    Attributes:
        corners: Its outline on the floor, (x, y) each, m, in the map frame; one point: it is thin.
        seen: Which part of it a bearing is of: `middle` (between both ends), `left` or `right` end.
    """

    corners: tuple[tuple[float, float], ...]
    seen: str = "middle"

    def __post_init__(self) -> None:
        if self.seen not in PARTS:
            raise ValueError(f"seen must be one of {', '.join(PARTS)}, got {self.seen!r}")
        if not self.corners or not np.all(np.isfinite(self.corners)):
            raise ValueError(f"corners must be finite points, got {self.corners}")
        if len(self.corners) == 1 and self.seen != "middle":
            raise ValueError("a landmark of one point has no ends: seen must be middle")

    @cached_property
    def position(self) -> np.ndarray:
        """One point for it, (2,), m: the middle, or the end that is seen from the map's origin."""
        if self.seen == "middle":
            return self.middle
        return np.asarray(self.points_seen(np.zeros((1, 2)))[0])

    @cached_property
    def middle(self) -> np.ndarray:
        """Middle of the outline's box, (2,), m."""
        corners = np.array(self.corners)
        return np.asarray(0.5 * (corners.min(axis=0) + corners.max(axis=0)))

    def point_seen(self, place: np.ndarray) -> np.ndarray:
        """Return the point, (2,), that a bearing from `place` (2,) is taken of."""
        if len(self.corners) == 1:
            return self.middle
        return np.asarray(self.points_seen(place[None])[0])

    def points_seen(self, places: np.ndarray) -> np.ndarray:
        """Return the points, (N, 2), that bearings from places (N, 2) are taken of."""
        if len(self.corners) == 1:
            return np.broadcast_to(self.middle, places.shape)
        right, left = self.ends_seen(places)
        if self.seen != "middle":
            return left if self.seen == "left" else right
        a, b = left - places, right - places
        # Both at the same distance lie symmetrically to the bearing between them.
        d_a, d_b = np.hypot(*a.T), np.hypot(*b.T)
        share = (d_b / np.maximum(d_a + d_b, 1e-12))[:, None]
        return np.asarray(places + share * a + (1.0 - share) * b)

    def ends_seen(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners seen farthest right and left from places outside, (N, 2) each."""
        corners = np.array(self.corners)
        rays, middles = corners - places[:, None], (self.middle - places)[:, None]
        cross = middles[..., 0] * rays[..., 1] - middles[..., 1] * rays[..., 0]
        turns = np.arctan2(cross, (rays * middles).sum(axis=-1))  # of corners from the middle
        return corners[turns.argmin(axis=1)], corners[turns.argmax(axis=1)]


def positions(landmarks: Landmarks) -> dict[str, np.ndarray]:
    """Return the positions of each class, (K, 2), m."""
    return {kind: np.array([m.position for m in marks]) for kind, marks in landmarks.items()}


def load_landmarks(name_or_path: str | Path) -> dict[str, tuple[Landmark, ...]]:
    """Read a file of landmarks: by path, or by the name of one of the package.

    Raises:
        ValueError: No such name, no such mapping, unknown keys, or two landmarks of a class at one
            place.
        OSError: The file cannot be read.
    """
    path = find_file(str(name_or_path), "multi_localizer", "places")
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), _OnceEach)  # noqa: S506, a safe loader
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(data, dict) or not data:
        raise ValueError(f"{path}: expected a mapping of class names to landmarks")
    return {str(kind): _class_of(values, f"{path}: {kind}") for kind, values in data.items()}


def _class_of(values: Any, where: str) -> tuple[Landmark, ...]:
    if not isinstance(values, Mapping):
        raise ValueError(f"{where}: expected a mapping, got {values!r}")
    refuse_unknown([str(key) for key in values], _KEYS, where)
    if ("positions_m" in values) == ("outlines_m" in values):
        raise ValueError(f"{where}: give either positions_m or outlines_m")
    try:
        if "positions_m" in values:
            outlines = [[point] for point in values["positions_m"]]
        else:
            outlines = list(values["outlines_m"])
        seen = str(values.get("seen", "middle"))
        marks = tuple(Landmark(tuple(_point(p) for p in outline), seen) for outline in outlines)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{where}: {error}") from error
    _refuse_doubles(marks, where)
    return marks


def _point(values: Any) -> tuple[float, float]:
    if not isinstance(values, list) or len(values) != 2:
        raise ValueError(f"a point must be [x, y], got {values!r}")
    if not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        raise ValueError(f"a point must hold numbers, got {values!r}")
    return float(values[0]), float(values[1])


def _refuse_doubles(marks: tuple[Landmark, ...], where: str) -> None:
    if not marks:
        raise ValueError(f"{where}: has no landmarks")
    for k, mark in enumerate(marks):
        for other in marks[:k]:
            if np.hypot(*(mark.position - other.position)) < _SAME_M:
                x, y = mark.position
                raise ValueError(f"{where}: two landmarks at one place, ({x:g}, {y:g})")
