"""Keeps the way to a goal: makes it, makes it anew when the map changes, drops it at the end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floornav_common.grid import OccupancyMap
from sjmc_planner.wavefront_config import WavefrontConfig
from sjmc_planner.wavefront_plan import CostMap, NoWayError

IDLE, WAITING, ON_ITS_WAY, NO_WAY, DONE = "idle", "waiting", "on its way", "no way", "done"
_NOTHING = np.zeros((0, 2))


@dataclass(frozen=True)
class Route:
    """How it stands.

    Attributes:
        state: `IDLE`, `WAITING`, `ON_ITS_WAY`, `NO_WAY` or `DONE`.
        text: Why, in words.
        points: A new path to follow, shape (N, 2), m; of no points: follow none any more; None:
            nothing new.
    """

    state: str
    text: str = ""
    points: np.ndarray | None = None


class RouteKeeper:
    """The way of one robot.

    Args:
        config: Robot, weights, and when to make the way anew.
    """

    def __init__(self, config: WavefrontConfig) -> None:
        self._config = config
        self._grid: OccupancyMap | None = None
        self._costs: CostMap | None = None
        self._goal: np.ndarray | None = None
        self._points = _NOTHING
        self._is_due = False  # a way has to be made, or looked at again
        self._is_new_goal = False
        self._is_followed = False  # a path is out, and none that took it back
        self._no_way = ""  # why there is none, as far as is known

    def set_config(self, config: WavefrontConfig) -> None:
        """Take other settings."""
        self._config, self._costs, self._is_due = config, None, True

    def set_grid(self, grid: OccupancyMap) -> None:
        """Take a new map."""
        self._grid, self._costs, self._is_due = grid, None, True

    def set_goal(self, goal: np.ndarray | None) -> None:
        """Take a new goal, shape (2,), m; None for none. The old way does not count any more."""
        self._goal, self._is_new_goal = goal, True

    @property
    def has_goal(self) -> bool:
        """Whether there is something to do."""
        return self._goal is not None

    def wait(self, why: str) -> Route:
        """Return how it stands while something is missing; an old goal's path is taken back."""
        return Route(WAITING, why, self._dropped() if self._is_new_goal else None)

    def refuse(self, why: str) -> Route:
        """Return how it stands with a goal that cannot be; an old goal's path is taken back."""
        return Route(NO_WAY, why, self._dropped())

    def update(self, here: np.ndarray) -> Route:
        """Return how it stands with the robot at a place, shape (2,), m."""
        if self._goal is None:
            return Route(IDLE, "no goal", self._dropped())
        if self._grid is None:
            return self.wait("no map has come")
        is_there = np.hypot(*(self._goal - here)) <= self._config.goal_tolerance_m
        if is_there and not self._is_new_goal:
            self._goal, self._points = None, _NOTHING
            return Route(DONE, "the goal is reached")
        ahead = self._ahead(here)
        if not (self._is_due or self._is_new_goal or self._is_off(here, ahead)):
            if self._no_way:
                return Route(NO_WAY, self._no_way)
            return Route(ON_ITS_WAY, f"{_length(ahead):.1f} m left")
        return self._planned(here, ahead)

    def _planned(self, here: np.ndarray, ahead: np.ndarray) -> Route:
        """Return a way, or the old one if it is as good."""
        assert self._grid is not None and self._goal is not None
        is_new_goal, self._is_new_goal, self._is_due = self._is_new_goal, False, False
        self._no_way = ""
        if self._costs is None:
            self._costs = CostMap(self._grid, self._config)
        try:
            way = self._costs.plan(here, self._goal)
        except NoWayError as error:
            self._no_way = str(error)
            return Route(NO_WAY, str(error), self._dropped(must=is_new_goal))
        if not is_new_goal and len(ahead) > 1 and not self._is_off(here, ahead):
            old = self._costs.cost_of(np.concatenate((here[None], ahead)))
            if way.cost >= (1.0 - self._config.better_share) * old:
                return Route(ON_ITS_WAY, f"{_length(ahead):.1f} m left")
        self._points, self._is_followed = way.points, True
        return Route(ON_ITS_WAY, f"{_length(way.points):.1f} m left", way.points)

    def _dropped(self, *, must: bool = False) -> np.ndarray | None:
        """Return an empty path if there is one to take back, its end reached or not."""
        had, self._points, self._is_followed = self._is_followed, _NOTHING, False
        return _NOTHING if had or must else None

    def _ahead(self, here: np.ndarray) -> np.ndarray:
        """Return the part of the path that is still to be driven."""
        if not len(self._points):
            return self._points
        return self._points[int(np.hypot(*(self._points - here).T).argmin()) :]

    def _is_off(self, here: np.ndarray, ahead: np.ndarray) -> bool:
        if not len(ahead):
            return len(self._points) > 0
        return bool(np.hypot(*(ahead[0] - here)) > self._config.off_path_m)


def _length(points: np.ndarray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0
