"""Rays and segments in the plane, compiled: what a ray meets first, and what a sonar faces."""

from __future__ import annotations

import math

import numba
import numpy as np


@numba.njit(cache=True)
def first_hit(x, y, ux, uy, segments):  # type: ignore[no-untyped-def]
    """Return the distance along a ray to the nearest segment, and its index; (inf, -1) for none.

    Args:
        x: Start of the ray, m.
        y: Likewise.
        ux: Its direction, a unit vector.
        uy: Likewise.
        segments: Rows (x1, y1, x2, y2), m.
    """
    nearest, which = np.inf, -1
    for k in range(len(segments)):
        ax, ay = segments[k, 0] - x, segments[k, 1] - y
        ex, ey = segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1]
        cross = ux * ey - uy * ex
        if cross == 0.0:
            continue
        t, s = (ax * ey - ay * ex) / cross, (ax * uy - ay * ux) / cross
        if 0.0 < t < nearest and 0.0 <= s <= 1.0:
            nearest, which = t, k
    return nearest, which


@numba.njit(cache=True)
def first_hits(place, rays, segments):  # type: ignore[no-untyped-def]
    """Return distances, shape (N,), and indices of what unit rays (N, 2) from a place meet."""
    distances, which = np.empty(len(rays)), np.empty(len(rays), np.int64)
    for k in range(len(rays)):
        distances[k], which[k] = first_hit(place[0], place[1], rays[k, 0], rays[k, 1], segments)
    return distances, which


@numba.njit(cache=True)
def count_faced(  # type: ignore[no-untyped-def]
    sonars, points, normals, blockers, half_opening, reach, critical, slack
):
    """Return how many of the sonars' firings face each point, shape (N,), int.

    Args:
        sonars: Pose of each firing, rows (x, y, yaw), shape (F, 3).
        points: On panes, shape (N, 2), m.
        normals: Of the pane at each point, shape (N, 2).
        blockers: What hides points: segments.
        half_opening: Half a cone, rad.
        reach: Longest range, m.
        critical: Angle of incidence up to which a pane answers, rad.
        slack: A blocker nearer than this before a point is the pane itself, m.
    """
    counts = np.zeros(len(points), np.int64)
    for f in range(len(sonars)):
        x, y, yaw = sonars[f]
        cx, cy = math.cos(yaw), math.sin(yaw)
        for k in range(len(points)):
            dx, dy = points[k, 0] - x, points[k, 1] - y
            distance = math.hypot(dx, dy)
            if distance >= reach or distance == 0.0:
                continue
            ux, uy = dx / distance, dy / distance
            if ux * cx + uy * cy < math.cos(half_opening):
                continue
            if abs(ux * normals[k, 0] + uy * normals[k, 1]) < math.cos(critical):
                continue
            free, _ = first_hit(x, y, ux, uy, blockers)
            if free > distance - slack:
                counts[k] += 1
    return counts
