"""Key frames: the scans that the pose graph's nodes stand for, and places made of several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.config import MotionConfig
from grid_mapper.motion import odometry_motion, rotated
from grid_mapper.surface_points import SurfacePoints

MAX_POINTS = 400
"""Points kept of a frame: more change no match by as much as it is uncertain."""


VAGUE_COV = np.diag([0.3, 0.3, 0.2]) ** 2
"""Of a place that no match speaks for."""
UNKNOWN_COV = np.diag([20.0, 20.0, np.pi]) ** 2
"""Of the motion over a jump: it holds the graph together and says nothing."""


@dataclass(frozen=True)
class KeyFrame:
    """A scan that a node of the graph stands for.

    Attributes:
        stamp_ns: Of the scan.
        T_local_base: Pose by the front end, in its frame, which drifts and never jumps.
        information: Of the match that gave the pose, (x, y, yaw) in local axes, shape (3, 3).
        points: Surface points in the base frame.
        scan: The scan, for what it sees through.
        T_base_laser: Pose of the laser on the robot.
    """

    stamp_ns: int
    T_local_base: SE2
    information: np.ndarray
    points: SurfacePoints
    scan: Scan
    T_base_laser: SE2


@dataclass(frozen=True)
class Edge:
    """A measured motion between two nodes.

    Attributes:
        first: Number of the node it is seen from.
        second: Number of the node that is seen.
        T_first_second: The motion.
        cov: Of (x, y, yaw) in the axes of the second node, shape (3, 3), SI.
        is_loop: False for the chain of motions from node to node.
    """

    first: int
    second: int
    T_first_second: SE2
    cov: np.ndarray
    is_loop: bool

    @cached_property
    def row(self) -> np.ndarray:
        """First, second, motion (x, y, yaw) and inverse covariance row by row, shape (14,)."""
        ends = (self.first, self.second)
        return np.concatenate((ends, self.T_first_second.as_array(), np.linalg.inv(self.cov).flat))


def chain_edge(
    number: int, before: KeyFrame, frame: KeyFrame, motion: MotionConfig,
    drift: tuple[float, float],
) -> Edge:  # fmt: skip
    """Return the motion from the frame before, as odometry and the match together know it.

    Args:
        number: Of the second node; the first is the one before.
        before: Frame of the first node.
        frame: Frame of the second node.
        motion: Says how far odometry can be trusted.
        drift: Deviation (m, rad) added to what the match says.
    """
    ends = before.T_local_base, frame.T_local_base
    cov = chain_cov(*ends, frame.information, motion, drift)
    return Edge(number - 1, number, ends[0].between(ends[1]), cov, is_loop=False)


def chain_cov(
    T_local_first: SE2, T_local_second: SE2, information: np.ndarray, motion: MotionConfig,
    drift: tuple[float, float],
) -> np.ndarray:  # fmt: skip
    """Return the covariance of a motion in the axes of its end, shape (3, 3).

    Args:
        T_local_first: Where it begins.
        T_local_second: Where it ends.
        information: Of the match at its end, (x, y, yaw) in local axes, shape (3, 3).
        motion: Says how far odometry can be trusted.
        drift: Deviation (m, rad) added to what the match says.
    """
    cov = odometry_motion(T_local_first.between(T_local_second), motion)
    cov = rotated(cov, T_local_first.yaw)
    cov = np.linalg.inv(np.linalg.inv(cov) + information)
    return rotated(cov, -T_local_second.yaw) + np.diag([drift[0], drift[0], drift[1]]) ** 2


def edge_after_jump(
    anchor: int, number: int, T_anchor_frame: SE2, frame: KeyFrame, motion: MotionConfig,
    sigma: tuple[float, float],
) -> Edge:  # fmt: skip
    """Return the edge of a robot that was found again: as a loop it may turn out to be false.

    The match that found it is added to what it would be off had it been driven from the anchor:
    so far as the map is unsure of itself there, the edge is too.

    Args:
        anchor: Number of the node beside which it was found.
        number: Of the frame's node.
        T_anchor_frame: Where it was found, seen from there.
        frame: The first one after the jump.
        motion: Says how far odometry can be trusted.
        sigma: Deviation (m, rad) of a loop.
    """
    driven = rotated(odometry_motion(T_anchor_frame, motion), -T_anchor_frame.yaw)
    information = frame.information + np.linalg.inv(VAGUE_COV)
    matched = rotated(np.linalg.inv(information), -frame.T_local_base.yaw)
    cov = driven + matched + np.diag([sigma[0], sigma[0], sigma[1]]) ** 2
    return Edge(anchor, number, T_anchor_frame, cov, is_loop=True)


def thinned(points: SurfacePoints) -> SurfacePoints:
    """Return at most MAX_POINTS of the points, evenly taken."""
    return points.every(max(1, -(-len(points) // MAX_POINTS)))


def place_of(
    frames: Sequence[KeyFrame], poses: Sequence[SE2], numbers: Sequence[int], center: int
) -> SurfacePoints:
    """Return the points of several frames in the frame of one of them.

    Args:
        frames: All frames.
        poses: Their poses in one frame.
        numbers: Which make up the place.
        center: The one whose axes are used.
    """
    parts = [frames[k].points.moved(poses[center].between(poses[k])) for k in numbers]
    return SurfacePoints(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.covs for part in parts]),
        np.concatenate([part.normals for part in parts]),
    )
