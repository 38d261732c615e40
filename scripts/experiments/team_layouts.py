"""Where robots stand in the team experiment: seeded layouts on the team paper's field.

The field is 8220 x 4575 mm with a goal 1500 mm wide at each end, as in the paper; the layouts of
its Fig. 10 and 11 are not in the text, so robots and obstacles are drawn at random. Landmarks are
the four goal posts (4.2). A post is told from the other one of its goal by the side on which the
goal lies, so each is a class of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FIELD_X, FIELD_Y, GOAL_WIDTH = 8.22, 4.575, 1.5
BODY_RADIUS = 0.15
OBSTACLE_RADIUS = 0.2
LEAST_GAP = 0.15
POSTS = {
    "yellow_left": np.array([[0.5 * FIELD_X, 0.5 * GOAL_WIDTH]]),
    "yellow_right": np.array([[0.5 * FIELD_X, -0.5 * GOAL_WIDTH]]),
    "blue_left": np.array([[-0.5 * FIELD_X, -0.5 * GOAL_WIDTH]]),
    "blue_right": np.array([[-0.5 * FIELD_X, 0.5 * GOAL_WIDTH]]),
}
"""Posts by class, (1, 2) each; left and right as seen from the field."""
_MOST_TRIES = 20_000


@dataclass(frozen=True, eq=False)
class Layout:
    """What is true: known to the simulation and the judge, never to what is judged.

    Attributes:
        poses: Of the robots, (N, 3): x, y, yaw.
        obstacles: Middles of round things that hide what is behind them, (K, 2).
    """

    poses: np.ndarray
    obstacles: np.ndarray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the robots; they say nothing of where these stand."""
        return tuple(f"r{k}" for k in range(len(self.poses)))


def random_layout(seed: int, num_robots: int, num_obstacles: int = 0) -> Layout:
    """Return robots and obstacles scattered evenly over the field, none touching another.

    Raises:
        ValueError: If so many find no room.
    """
    rng = np.random.default_rng([seed, num_robots, num_obstacles])
    radii = np.array([BODY_RADIUS] * num_robots + [OBSTACLE_RADIUS] * num_obstacles)
    half = np.array([0.5 * FIELD_X, 0.5 * FIELD_Y]) - OBSTACLE_RADIUS
    places = np.empty((0, 2))
    for _ in range(_MOST_TRIES):
        if len(places) == len(radii):
            break
        place = rng.uniform(-half, half)
        gaps = np.hypot(*(places - place).T) - radii[: len(places)] - radii[len(places)]
        if np.all(gaps >= LEAST_GAP):
            places = np.vstack((places, place))
    else:
        raise ValueError(f"{num_robots} robots and {num_obstacles} obstacles find no room")
    yaws = rng.uniform(-np.pi, np.pi, num_robots)
    return Layout(np.column_stack((places[:num_robots], yaws)), places[num_robots:])
