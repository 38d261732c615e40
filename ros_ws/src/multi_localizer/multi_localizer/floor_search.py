"""Where on the whole plan a border may fit: tried out, when nothing better is known.

What every place of a grid over the plan has around it, as inverse distances by bearing, is worked
out once. The border seen, in as many bearings, is held against each place at each yaw: a turn by a
whole step is a shift along the row.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from multi_localizer.floor_kernels import NUM_VALUES, residuals
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_walls import NUM_SEEN, wall_ahead, walls_from, walls_of

SPACING_M = 0.13
MAX_PLACES = 800
NUM_BEARINGS = 64
PIECES = 4 * NUM_BEARINGS
NEAR = 6.0 / 700.0  # of the border's length: how far off what fits a grid of places may be
NUM_STARTS = 8
APART = 0.4, 0.4  # m, rad: starts nearer to each other than this lead to one fit
WORST = 0.7  # of how well the best start fits; less than this is not begun with
SLIDE_M, SLIDE_PIECES, SLIDE_PX, NUM_SLIDES = 0.04, 120, 1.5, 4
MAX_WAYS, SAME_WAY = 4, 0.98


def places_of(plan: FloorPlan) -> np.ndarray:
    """Return places spread evenly over a plan, (N, 2), m."""
    low, high = plan.corners.min(axis=0), plan.corners.max(axis=0)
    spacing = max(SPACING_M, float(np.sqrt((high - low).prod() / MAX_PLACES)))
    x, y = (
        np.linspace(a, b, int((b - a) / spacing) + 2)[1:-1] for a, b in zip(low, high, strict=True)
    )
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid[[plan.contains(px, py) for px, py in grid]]


class PlanSearch:
    """Finds starts for a fit anywhere on a plan.

    Args:
        plan: The floor. Of places that a symmetry makes of each other one is tried.
    """

    def __init__(self, plan: FloorPlan) -> None:
        self._symmetries = np.array([s.as_array() for s in plan.symmetries])
        self._places = _of_different_looks(places_of(plan), plan)
        self._around = _around(self._places, walls_of(plan))

    def starts(self, values: np.ndarray) -> np.ndarray:
        """Return the likeliest poses, different ones, the likeliest first, (S, 3).

        Args:
            values: Of `BorderRays`, (N, 7).
        """
        if not len(values) or not len(self._places):
            return np.empty((0, 3))
        seen, weights = _by_bearing(values, max(1, len(values) // PIECES), NEAR * len(values))
        costs = _costs_around(self._around, seen, weights)
        return _lowest(costs, self._places, self._symmetries)


def slides(
    values: np.ndarray, walls: np.ndarray, pose: np.ndarray, offset: float, reach: float
) -> np.ndarray:
    """Return starts along the walls from a pose, (S, 3): where more fits than beside it.

    With much of the border hidden, two side walls fit all along, and little says how far along.

    Args:
        values: Of `BorderRays`, (N, 7).
        walls: Of `walls_of`, (W, 8).
        pose: That fits some walls, (3,).
        offset: Of the border there, px.
        reach: Of the plan, m.
    """
    step = max(1, len(values) // SLIDE_PIECES)
    along = np.arange(-reach, reach, SLIDE_M)
    starts = []
    for way in _ways(walls):
        places = pose[:2] + along[:, None] * way
        costs = _costs(values, step, walls, places, pose[2], offset, SLIDE_PX)
        inner = (costs[1:-1] < costs[:-2]) & (costs[1:-1] <= costs[2:])
        (low,) = np.nonzero(inner)
        for k in low[np.argsort(costs[low + 1])][:NUM_SLIDES] + 1:
            starts.append((*places[k], pose[2]))
    return np.array(starts).reshape(-1, 3)


def _ways(walls: np.ndarray) -> list[np.ndarray]:
    """Return the different directions of walls, (2,) each."""
    ways: list[np.ndarray] = []
    for tangent in walls[np.argsort(-walls[:, 7]), 2:4]:
        if all(abs(tangent @ way) < SAME_WAY for way in ways):
            ways.append(tangent)
    return ways[:MAX_WAYS]


def _of_different_looks(places: np.ndarray, plan: FloorPlan) -> np.ndarray:
    """Return places (N, 2) without those that a symmetry makes of one that is kept."""
    kept: list[np.ndarray] = []
    for place in places:
        mates = np.array([(s @ place[None])[0] for s in plan.symmetries[1:]]).reshape(-1, 2)
        if not any(np.hypot(*(mates - other).T).min(initial=np.inf) < 1e-6 for other in kept):
            kept.append(place)
    return np.array(kept)


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _around(places, walls):  # type: ignore[no-untyped-def]
    """Return 1 over the distance of the first wall by bearing, twice around, (M, 2 B), float32."""
    around = np.empty((len(places), 2 * NUM_BEARINGS), np.float32)
    seen = np.empty((len(walls), NUM_SEEN))
    for k in range(len(places)):
        num = walls_from(walls, places[k, 0], places[k, 1], seen)
        for i in range(2 * NUM_BEARINGS):
            bearing = 2.0 * math.pi / NUM_BEARINGS * i
            around[k, i] = wall_ahead(seen, num, math.cos(bearing), math.sin(bearing))[1]
    return around


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _by_bearing(values, step, near_px):  # type: ignore[no-untyped-def]
    """Return inverse distances by bearing and how much a difference counts, (B,) each; 0: none.

    Of the pieces of one bearing the one that lies nearest to it speaks.
    """
    seen, weights = np.zeros(NUM_BEARINGS, np.float32), np.zeros(NUM_BEARINGS, np.float32)
    off = np.full(NUM_BEARINGS, np.inf)
    for i in range(0, len(values), step):
        at = math.atan2(values[i, 1], values[i, 0]) * NUM_BEARINGS / (2.0 * math.pi)
        nearest = round(at)
        k = int(nearest) % NUM_BEARINGS
        if abs(at - nearest) < off[k]:
            off[k] = abs(at - nearest)
            seen[k] = values[i, 2]
            weights[k] = 1.0 / (near_px * math.sqrt(values[i, 5]))
    return seen, weights


@numba.njit(cache=True, error_model="numpy", nogil=True, fastmath=True)
def _costs_around(around, seen, weights):  # type: ignore[no-untyped-def]
    """Return how badly a border fits at each place and yaw, (M, B)."""
    costs = np.empty((len(around), NUM_BEARINGS), np.float32)
    one = np.float32(1.0)
    num = np.float32(max((weights > 0.0).sum(), 1))
    for k in range(len(around)):
        for j in range(NUM_BEARINGS):
            row = around[k, j : j + NUM_BEARINGS]
            cost = np.float32(0.0)
            for i in range(NUM_BEARINGS):
                off = (seen[i] - row[i]) * weights[i]
                off *= off
                cost += off / (one + off)
            costs[k, j] = cost / num
    return costs


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _lowest(costs, places, symmetries):  # type: ignore[no-untyped-def]
    """Return the poses of least cost that are apart from each other, (S, 3)."""
    starts = np.empty((NUM_STARTS, 3))
    least, num = 1.0, 0
    while num < NUM_STARTS:
        k, j = divmod(costs.argmin(), NUM_BEARINGS)
        if num == 0:
            least = costs[k, j]
        if 1.0 - costs[k, j] < WORST * (1.0 - least) or costs[k, j] >= 1.0:
            break
        yaw = 2.0 * math.pi / NUM_BEARINGS * j
        starts[num, 0], starts[num, 1], starts[num, 2] = places[k, 0], places[k, 1], yaw
        for m in range(len(symmetries)):
            _take_out(costs, places, starts[num], symmetries[m])
        num += 1
    return starts[:num]


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _take_out(costs, places, pose, motion):  # type: ignore[no-untyped-def]
    """Set the costs near a pose (3,), moved by a symmetry (3,), to 2: nothing more begins there."""
    c, s = math.cos(motion[2]), math.sin(motion[2])
    x, y = motion[0] + c * pose[0] - s * pose[1], motion[1] + s * pose[0] + c * pose[1]
    reach = int(APART[1] * NUM_BEARINGS / (2.0 * math.pi))
    middle = round((pose[2] + motion[2]) * NUM_BEARINGS / (2.0 * math.pi))
    for k in range(len(places)):
        if math.hypot(places[k, 0] - x, places[k, 1] - y) < APART[0]:
            for j in range(middle - reach, middle + reach + 1):
                costs[k, j % NUM_BEARINGS] = 2.0


@numba.njit(cache=True, error_model="numpy", nogil=True)
def _costs(values, step, walls, places, yaw, offset, near_px):  # type: ignore[no-untyped-def]
    """Return how badly the border fits at each place with one yaw, (M,)."""
    costs = np.empty(len(places))
    rows = np.empty((len(values) // step + 1, NUM_VALUES))
    for k in range(len(places)):
        pose = np.array((places[k, 0], places[k, 1], yaw))
        num = residuals(values, step, pose, walls, rows)
        cost = 0.0
        for i in range(num):
            ratio = ((rows[i, 0] - offset) / near_px) ** 2 if rows[i, 4] >= 0 else 1e9
            cost += ratio / (1.0 + ratio)
        costs[k] = cost / num
    return costs
