"""How much of what the laser could see is in the map: beams cast from the true way, exact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from floornav_common.se2 import SE2
from sim_bridge.solids import Solid

FOUND_WITHIN_M = 0.10
_PATCH_M = 0.05
_OFF_ROUND_M = 0.0033  # faces stand at round numbers: off the borders of patches
_MIN_BEAMS = 3
_STEP_M, _STEP_RAD = 0.25, 0.25


def visible_surface(
    solids: Sequence[Solid], poses: Sequence[SE2], angles: np.ndarray, reach: float
) -> np.ndarray:
    """Return points of the surfaces that a laser sees on its way, one every 5 cm, (N, 2), m.

    Glass is not among them: beams pass it. A place counts once three exact beams of the poses,
    thinned to one every 0.25 m or 0.25 rad, end there: what only one beam grazed is left out.

    Args:
        solids: What stands at the height of the laser.
        poses: Of the laser in the world, in order.
        angles: Bearings of its beams, (B,), rad.
        reach: Its longest range, m.
    """
    outlines = [solid.outline() for solid in solids if solid.glass is None]
    if not outlines or not poses:
        return np.zeros((0, 2))
    starts = np.vstack(outlines)
    ends = np.vstack([np.roll(outline, -1, axis=0) for outline in outlines])
    hits = [_ends_of_beams(starts, ends, pose, angles, reach) for pose in _thinned(poses)]
    points = np.vstack(hits)
    _, first, counts = np.unique(
        np.floor((points + _OFF_ROUND_M) / _PATCH_M), axis=0, return_index=True, return_counts=True
    )
    return points[first[counts >= _MIN_BEAMS]]


def share_found(surface: np.ndarray, occupied: np.ndarray) -> float | None:
    """Return the share of surface points with an occupied cell's middle within 0.10 m.

    Args:
        surface: In the world, (N, 2), m.
        occupied: Middles of occupied cells in the world, (M, 2), m.

    Returns:
        None where no surface was to be seen.
    """
    if not len(surface):
        return None
    if not len(occupied):
        return 0.0
    distances, _ = cKDTree(occupied).query(surface)
    return float((distances <= FOUND_WITHIN_M).mean())


def _ends_of_beams(
    starts: np.ndarray, ends: np.ndarray, pose: SE2, angles: np.ndarray, reach: float
) -> np.ndarray:
    """Return where beams end on edges from starts to ends, those within reach, (N, 2)."""
    place = np.array([pose.x, pose.y])
    rays = np.column_stack((np.cos(pose.yaw + angles), np.sin(pose.yaw + angles)))
    to_start, along = starts - place, ends - starts
    # place + d ray = start + s along: both sides crossed with along, and with ray.
    across = rays[:, :1] * along[:, 1] - rays[:, 1:] * along[:, 0]
    over = to_start[:, 0] * along[:, 1] - to_start[:, 1] * along[:, 0]
    side = to_start[:, 0] * rays[:, 1:] - to_start[:, 1] * rays[:, :1]
    safe = np.where(np.abs(across) < 1e-12, np.nan, across)
    distance, share = over / safe, side / safe
    is_hit = (distance > 0.0) & (share >= 0.0) & (share <= 1.0)
    nearest = np.where(is_hit, distance, np.inf).min(axis=1)
    is_near = nearest <= reach
    return np.asarray(place + nearest[is_near, None] * rays[is_near])


def _thinned(poses: Sequence[SE2]) -> list[SE2]:
    kept = [poses[0]]
    for pose in poses[1:]:
        motion = kept[-1].between(pose)
        if np.hypot(motion.x, motion.y) >= _STEP_M or abs(motion.yaw) >= _STEP_RAD:
            kept.append(pose)
    return kept
