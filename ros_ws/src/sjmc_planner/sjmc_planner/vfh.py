"""VFH (Borenstein and Koren 1991): a polar histogram of densities, smoothed, and its valleys.

"The vector field histogram: fast obstacle avoidance for mobile robots", IEEE Transactions on
Robotics and Automation 7(3). The robot is a point here: the smoothing
has to keep it off the sides, which VFH+ does by enlarging obstacles.

Magnitudes are in units of one sure cell at the robot: m = c^2 (a - b d) with a = 1 and nothing at
the window's border. Where the paper is silent: a valley that holds the goal's sector with half of
s_max clear on both sides is driven straight for the goal; a direction that no beam looked along is
in no valley. The paper's V_min is a share here.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.openings import openings
from sjmc_planner.windowed import Choice, View, WindowedMethod

_TURN = 2.0 * math.pi


@numba.njit(cache=True, nogil=True)
def density(points, certainty, reach, num):  # type: ignore[no-untyped-def]
    """Return the polar obstacle density of each sector, shape (num,).

    Args:
        points: Middles of the occupied cells, in the base frame, shape (M, 2), m.
        certainty: Of each, in (0, 1], shape (M,).
        reach: Radius of the window, m.
        num: Number of sectors.
    """
    found = np.zeros(num)
    for i in range(len(points)):
        d = np.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        if d < reach:
            sector = np.rint(np.arctan2(points[i, 1], points[i, 0]) * (num / _TURN))
            found[int(sector) % num] += certainty[i] ** 2 * (1.0 - d / reach)
    return found


def smoothed(histogram: np.ndarray, reach: int) -> np.ndarray:
    """Return the smoothed histogram, shape (num,).

    The print gives the sector itself the weight l where the row 1, 2, ... has l + 1; that is taken.

    Args:
        histogram: Densities, shape (num,).
        reach: Sectors to each side (l).
    """
    total = (reach + 1) * histogram
    for i in range(1, reach + 1):
        total = total + (reach + 1 - i) * (np.roll(histogram, i) + np.roll(histogram, -i))
    return total / (2 * reach + 1)


def valley_direction(is_open: np.ndarray, goal: float, wide: int) -> float | None:
    """Return the direction through the valley nearest the goal, rad; None if there is none.

    Args:
        is_open: Sectors below the threshold, shape (num,), bool.
        goal: Bearing of the goal, rad.
        wide: Most sectors that a direction keeps between a valley's sides (s_max).
    """
    num = len(is_open)
    alpha = _TURN / num
    best, least = None, math.inf
    for right, left in openings(~is_open).tolist():
        sector = right + (goal / alpha - right) % num
        is_round = left - right == num - 1
        half = 0.5 * min(wide, left - right)
        if is_round or right + half <= sector <= left - half:
            return goal
        for border, middle in ((right, right + half), (left, left - half)):
            off = abs(math.remainder(border * alpha - goal, _TURN))
            off = 0.0 if right <= sector <= left else off
            off += 1e-6 * abs(math.remainder(middle * alpha - goal, _TURN))
            if off < least:
                best, least = math.remainder(middle * alpha, _TURN), off
    return best


class Vfh(WindowedMethod):
    """The method."""

    def _choose(self, view: View) -> Choice:
        """Return the direction of the valley nearest the goal, and the speed for it."""
        config = self._config
        histogram = density(view.cells.points, view.cells.certainty, view.reach, config.num_sectors)
        histogram = smoothed(histogram, config.vfh_smoothing)
        is_unseen = view.ends.unseen(self._sectors, self._robot.radius_m, view.reach)
        is_open = (histogram < config.vfh_threshold) & ~is_unseen
        bearing = valley_direction(is_open, view.goal.bearing, config.vfh_wide_sectors)
        if bearing is None:
            return Choice(np.zeros(0), -1, 0.0)
        ahead = histogram[round(view.heading * len(histogram) / _TURN) % len(histogram)]
        # V' = V_max (1 - h''_c / h_m); slower in turns, by Omega, is `steering`'s part.
        share = 1.0 - min(float(ahead), config.vfh_full_stop) / config.vfh_full_stop
        speed = self._steering.fastest(view.goal)
        return Choice(np.array([bearing]), 0, speed * max(share, config.least_speed))
