"""Brings a lost robot back: its scans go to a `Relocalizer` in the background, until it is found.

While the robot is lost it is followed by odometry alone. A look is sent when it has moved on since
the last one and that was answered; the answer is moved on by what was driven meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from floornav_common.grid import OccupancyMap
from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from grid_mapper.background import Worker
from grid_mapper.config import GridMapperConfig
from grid_mapper.localizer import MIN_VARIANCE, VAGUE_COV
from grid_mapper.map_surfaces import round_place, surfaces_of
from grid_mapper.motion import odometry_motion, rotated
from grid_mapper.relocalizer import SURROUNDINGS_M
from grid_mapper.relocation_messages import Forget, Found, Look, NewMap, NotFound, Prior
from grid_mapper.surface_points import SurfacePoints

LOOKS_AT_PRIOR = 4
"""After so many looks nobody's word on where the robot is counts any more."""
UNHEARD = "waiting for the first look"


@dataclass(frozen=True)
class Recovered:
    """Where a robot is that was found.

    Attributes:
        T_map_base: Now.
        cov: Of (x, y, yaw) in map axes, shape (3, 3).
        seen: Surfaces round it in the map frame.
    """

    T_map_base: SE2
    cov: np.ndarray
    seen: SurfacePoints


class Recovery:
    """Looks for the robot while it is active.

    Attributes:
        is_active: Whether it looks.
        reason: Why the robot is not found yet.
        num_found: How often it was.
    """

    def __init__(
        self,
        config: GridMapperConfig,
        make_worker: Callable[[], Worker],
        current_map: Callable[[], OccupancyMap | None],
    ) -> None:
        """Look for nothing yet.

        Args:
            config: When to look, and when a place is believed.
            make_worker: Makes the background when it is first needed.
            current_map: Gives the map to look in; None while there is none.
        """
        self._config, self._make_worker, self._current_map = config, make_worker, current_map
        self._worker: Worker | None = None
        self._map: OccupancyMap | None = None
        self._surfaces: tuple[OccupancyMap, SurfacePoints] | None = None
        self.is_active, self.reason, self.num_found = False, "", 0
        self._number = 0
        self._prior: Prior | None = None
        self._looked: dict[int, SE2] = {}
        self._last: SE2 | None = None

    def start(self, prior: Prior | None = None) -> bool:
        """Look from now on; tell whether there is a map to look in.

        Args:
            prior: About where somebody says the robot is at the next scan; None for anywhere.
        """
        grid = self._current_map()
        if grid is None:
            return False
        if self._worker is None:
            self._worker = self._make_worker()
        if self._worker.failure:
            self._worker.begin_anew()
            self._map = None
        if grid is not self._map:
            self._worker.send(NewMap(grid))
            self._map = grid
        self._worker.send(Forget())
        self._prior, self._num_looks = _usable(prior), 0
        self._first_odom: SE2 | None = None
        self.is_active, self.reason = True, UNHEARD
        self._looked, self._last = {}, None
        return True

    def restart(self) -> bool:
        """Look from now on after odometry jumped; what somebody said lately stays said.

        Returns:
            Whether there is a map to look in.
        """
        return self.start(self._prior if self.is_active else None)

    @property
    def current_map(self) -> OccupancyMap | None:
        """The map to look in; None while there is none."""
        return self._current_map()

    def stop(self) -> None:
        """Look no more: somebody else knows."""
        self.is_active, self._looked = False, {}

    def surroundings(self, pose: SE2) -> SurfacePoints | None:
        """Return the surfaces of the map round a pose; None where there are none."""
        grid = self._current_map()
        if grid is None:
            return None
        if self._surfaces is None or self._surfaces[0] is not grid:
            self._surfaces = grid, surfaces_of(grid)
        near = round_place(self._surfaces[1], pose.x, pose.y, SURROUNDINGS_M)
        return near if len(near) else None

    def look(self, scan: Scan, T_base_laser: SE2, T_odom_base: SE2) -> Recovered | None:
        """Take a scan of the lost robot; return where it is once that is known."""
        assert self._worker is not None
        while (answer := self._worker.receive()) is not None:
            odom = self._looked.pop(answer.number, None)
            if odom is None:
                continue  # of before the last start
            if isinstance(answer, Found):
                return self._recovered(answer, odom.between(T_odom_base))
            self._take(answer)
        if self._worker.failure:
            self.reason = self._worker.failure
        if not self._looked and self._is_apart(T_odom_base):
            self._send(scan, T_base_laser, T_odom_base)
        return None

    def close(self) -> None:
        """End the background."""
        if self._worker is not None:
            self._worker.close()

    def _take(self, answer: NotFound) -> None:
        self.reason = answer.reason
        if self._prior is not None and self._num_looks >= LOOKS_AT_PRIOR:
            self._prior = None

    def _is_apart(self, T_odom_base: SE2) -> bool:
        if self._last is None:
            return True
        moved, config = self._last.between(T_odom_base), self._config.relocation
        is_far = moved.distance >= config.look_distance_m
        return is_far or abs(moved.yaw) >= config.look_turn_rad

    def _send(self, scan: Scan, T_base_laser: SE2, T_odom_base: SE2) -> None:
        assert self._worker is not None
        if self._first_odom is None:
            self._first_odom = T_odom_base
        prior, moved = self._prior, self._first_odom.between(T_odom_base)
        if prior is not None:
            drift = rotated(odometry_motion(moved, self._config.motion), prior.T_map_base.yaw)
            prior = Prior(prior.T_map_base @ moved, prior.cov + drift)
        self._number += 1
        self._num_looks += 1
        self._looked[self._number] = self._last = T_odom_base
        self._worker.send(Look(self._number, scan, T_base_laser, T_odom_base, prior))

    def _recovered(self, found: Found, moved: SE2) -> Recovered:
        self.stop()
        self.num_found += 1
        drift = odometry_motion(moved, self._config.motion)
        cov = found.cov + rotated(drift, found.T_map_base.yaw)
        return Recovered(found.T_map_base @ moved, cov, found.seen)


def _usable(prior: Prior | None) -> Prior | None:
    """Return a prior; one that claims to know a coordinate exactly is taken as a vague one."""
    if prior is None or np.linalg.eigvalsh(prior.cov).min() >= MIN_VARIANCE:
        return prior
    return Prior(prior.T_map_base, VAGUE_COV)
