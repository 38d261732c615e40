"""What is said between a robot that lost its place and the one that looks for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.surface_points import SurfacePoints

SIGMAS = 3.0
MAX_WINDOW_M = 8.0
SLACK_M, SLACK_RAD = 0.1, 0.1


@dataclass(frozen=True)
class Prior:
    """About where somebody says the robot is: `T_map_base` at a look, with its covariance."""

    T_map_base: SE2
    cov: np.ndarray

    @property
    def window(self) -> tuple[float, float]:
        """How far to each side (m) and how far round (rad) it may be."""
        sigma = np.sqrt(np.diag(self.cov))
        reach = min(SIGMAS * float(sigma[:2].max()) + SLACK_M, MAX_WINDOW_M)
        return reach, min(SIGMAS * float(sigma[2]), float(np.pi))

    def has(self, pose: SE2) -> bool:
        """Tell whether a pose is one that it allows."""
        off, (reach, turn) = self.T_map_base.between(pose), self.window
        return off.distance <= np.sqrt(2.0) * reach and abs(off.yaw) <= turn + SLACK_RAD


@dataclass(frozen=True)
class Look:
    """A scan of a robot that does not know where it is.

    Attributes:
        number: Given back with the answer.
        scan: In the laser's frame, its ranges clipped.
        T_base_laser: Pose of the laser on the robot.
        T_odom_base: Odometry at the scan.
        prior: About where it is; None for anywhere.
    """

    number: int
    scan: Scan
    T_base_laser: SE2
    T_odom_base: SE2
    prior: Prior | None = None


@dataclass(frozen=True)
class NewMap:
    """The map to look in from now on; what was looked at before is forgotten."""

    grid: OccupancyMap


@dataclass(frozen=True)
class Forget:
    """Says that the robot may be elsewhere now: looks of before count no longer."""


@dataclass(frozen=True)
class Found:
    """Where the robot was at a look.

    Attributes:
        number: Of the look.
        T_map_base: The pose.
        cov: Of (x, y, yaw) in map axes, shape (3, 3).
        seen: Surfaces of the map round it, in the map frame.
    """

    number: int
    T_map_base: SE2
    cov: np.ndarray
    seen: SurfacePoints


@dataclass(frozen=True)
class NotFound:
    """Why a look was not enough."""

    number: int
    reason: str
