"""Rules for OccupancyGrid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from grid_mapper.contract.poses import quaternion_problem
from grid_mapper.contract.rule import Rule, Topic, Verdict, judge_each

SIZE = Rule(
    "size", "as many cells as width x height, resolution > 0",
    "Nav2's static layer, AMCL", "nav_msgs/OccupancyGrid.msg; nav2_costmap_2d static_layer.cpp",
)  # fmt: skip
CELLS = Rule(
    "cells", "-1 (unknown) or 0 to 100", "Nav2's static layer, AMCL", "nav_msgs/OccupancyGrid.msg"
)
ORIGIN = Rule(
    "origin", "finite, its orientation a unit quaternion", "AMCL, Nav2's static layer",
    "nav_msgs/MapMetaData.msg; nav2_amcl amcl_node.cpp convertMap",
)  # fmt: skip
UNTURNED = Rule(
    "not turned", "the origin has no yaw: costmaps lie along the axes of their frame",
    "Nav2's static layer, AMCL", "nav2_costmap_2d static_layer.cpp processMap, costmap_2d.hpp",
)  # fmt: skip

RULES = (SIZE, CELLS, ORIGIN, UNTURNED)


def judge_maps(topic: Topic) -> list[Verdict]:
    """Return the verdicts on a topic of OccupancyGrids."""
    checks = (
        (SIZE, size_problem), (CELLS, cells_problem), (ORIGIN, origin_problem),
        (UNTURNED, turned_problem),
    )  # fmt: skip
    return [judge_each(topic, rule, check) for rule, check in checks]


def size_problem(grid: Any) -> str:
    """Return what is wrong with the size."""
    info = grid.info
    if not (math.isfinite(info.resolution) and info.resolution > 0.0):
        return f"resolution {info.resolution:g}"
    if len(grid.data) != info.width * info.height:
        return f"{len(grid.data)} cells for {info.width} x {info.height}"
    return ""


def cells_problem(grid: Any) -> str:
    """Return how many cells have values that mean nothing."""
    cells = np.asarray(grid.data, dtype=np.int8)
    num = int(((cells < -1) | (cells > 100)).sum())
    return f"{num} cells are neither -1 nor 0 to 100" if num else ""


def origin_problem(grid: Any) -> str:
    """Return what is wrong with the origin."""
    at = grid.info.origin.position
    if not all(math.isfinite(v) for v in (at.x, at.y, at.z)):
        return "its position is not finite"
    return quaternion_problem(grid.info.origin.orientation)


def turned_problem(grid: Any) -> str:
    """Return how far the map is turned."""
    q = grid.info.origin.orientation
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
    return "" if abs(yaw) < 1e-3 else f"turned by {yaw:.4f} rad"
