"""VFF (Borenstein and Koren 1989): certain cells push, the goal pulls, the sum steers.

"Real-time obstacle avoidance for fast mobile robots", IEEE Transactions on Systems, Man and
Cybernetics 19(5). The repulsive constant F_cr is given for a square meter of sure cells at 1 m
beside a pull F_ct of 1, so that it does not depend on the cells' size. Its known weaknesses stay:
it swings in narrow passages and is caught where the forces cancel.

A cell pushes as if it were no nearer than the robot's own circle. The published damping, V_max
(1 - |cos|) of the angle between motion and push, counts by the push's share of the pull, or the
faintest push from straight ahead would stop the robot.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.windowed import Choice, View, WindowedMethod

_NO_FORCE = 1e-9


@numba.njit(cache=True, nogil=True)
def repulsion(points, certainty, reach, nearest, area):  # type: ignore[no-untyped-def]
    """Return the force of all cells for a constant F_cr of 1: F = C / d^2, away from the cell.

    Args:
        points: Middles of the occupied cells, in the base frame, shape (M, 2), m.
        certainty: Of each, in (0, 1], shape (M,).
        reach: Radius of the window, m.
        nearest: A cell nearer than this pushes as from there, m.
        area: Of a cell, m^2.
    """
    x, y = 0.0, 0.0
    for i in range(len(points)):
        d = np.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        if 0.0 < d < reach:
            force = certainty[i] * area / (max(d, nearest) ** 2 * d)
            x -= force * points[i, 0]
            y -= force * points[i, 1]
    return x, y


def damped_share(moving: float, push: tuple[float, float]) -> float:
    """Return the share of full speed: less where the robot drives against the push, or with it.

    Args:
        moving: Direction of motion, rad.
        push: Repulsive force F_r, in units of the pull.
    """
    size = math.hypot(*push)
    if size < _NO_FORCE:
        return 1.0
    cosine = (math.cos(moving) * push[0] + math.sin(moving) * push[1]) / size
    return 1.0 - abs(cosine) * min(size, 1.0)


class Vff(WindowedMethod):
    """The method."""

    def _choose(self, view: View) -> Choice:
        """Return the direction of the sum of forces, and the speed for it."""
        config, goal = self._config, view.goal.bearing
        x, y = repulsion(
            view.cells.points, view.cells.certainty, view.reach, self._robot.grown_radius,
            config.cell_m**2,
        )  # fmt: skip
        push = config.vff_repulsion * x, config.vff_repulsion * y
        x, y = math.cos(goal) + push[0], math.sin(goal) + push[1]
        if math.hypot(x, y) < _NO_FORCE:
            return Choice(np.zeros(0), -1, 0.0)
        share = max(damped_share(view.heading, push), config.least_speed)
        speed = share * self._steering.fastest(view.goal)
        return Choice(np.array([math.atan2(y, x)]), 0, speed)
