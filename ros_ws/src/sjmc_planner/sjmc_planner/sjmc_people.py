"""How each person in the way is taken: moving or standing, waited for or judged not to yield.

D here is the strip that the robot's box drives through along a course: what it would sweep at the
velocity it would have there (3.7). The obstacle that counts (o_f) is the one in D whose model
leaves the least speed, of equals the nearest; the thesis takes the nearest. Who stands in D, or
does not leave it by going on, is Stable, others in it are Unstable (thesis, 3.6.1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_scene import Scene
from sjmc_planner.sjmc_speed import avoid_time, aware_time, stable_bound, unstable_bound
from sjmc_planner.sjmc_zones import DANGER, zone_of

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
_LEAVES_S = 4.0  # who takes longer to leave D does not leave it
_YIELDS = 0.3  # m/s: who was judged and goes this fast is given another chance
_LEAVING = 0.2  # m/s
_REGAIN = 0.1  # of the time without: regained of what bystanders took
_PAST_LINE = 0.17  # m: so far beyond the line who stands beside the way has let it come
_BRISK_S = 0.8  # to the line, once patience with bystanders is spent
_RESTS_S = 1.0  # without being in the way: patience is whole again


@dataclass(frozen=True)
class InTheWay:
    """The people in D along one course.

    Attributes:
        bound: What the speed models allow, m/s; inf with nobody in D.
        who: Row of the person in the scene that sets it; -1 for nobody.
        distance: From the robot's front to that person, m.
        is_stable: Whether that person is Stable.
    """

    bound: float
    who: int
    distance: float
    is_stable: bool


def people_in_the_way(
    course: float, scene: Scene, is_judged: np.ndarray, front: float, half: float,
    config: SjmcConfig,
) -> InTheWay:  # fmt: skip
    """Return who sets the speed along a course (eq. 3.5 and 3.7).

    Args:
        course: Bearing, rad.
        scene: Surroundings.
        is_judged: Who is judged not to yield and so not waited for, shape (N,), bool.
        front: How far the robot reaches ahead of its base, m.
        half: Half of the width of D, m.
        config: Zones and times.
    """
    zones = (config.danger_m, config.caution_m, config.aware_s, config.side_speed_m_s)
    args = course, scene.people, scene.is_moving, is_judged
    return InTheWay(*_in_the_way(*args, front, half, zones))


def is_not_yielding(ahead: InTheWay, scene: Scene, config: SjmcConfig) -> bool:
    """Tell whether who is ahead stands in the way where eq. 3.5 leaves no speed to speak of."""
    if ahead.who < 0 or scene.is_moving[ahead.who]:
        return False
    return _is_near(ahead, config) or ahead.bound <= config.end_m_s


def stands_near(ahead: InTheWay, config: SjmcConfig) -> bool:
    """Tell whether somebody stands in a course's Danger Zone (3.7)."""
    return ahead.who >= 0 and ahead.is_stable and _is_near(ahead, config)


def _is_near(ahead: InTheWay, config: SjmcConfig) -> bool:
    return zone_of(ahead.distance, config.danger_m, config.caution_m) == DANGER


@numba.njit(cache=True, nogil=True)
def _in_the_way(course, people, is_moving, is_judged, front, half, zones):  # type: ignore[no-untyped-def]
    danger, caution, aware, side_speed = zones
    c, s = math.cos(course), math.sin(course)
    best, who, at, best_stable = np.inf, -1, np.inf, False
    for i in range(len(people)):
        x, y, vx, vy, r = people[i]
        along, across = c * x + s * y, c * y - s * x
        edge = half + r
        distance = along - front - r
        if abs(across) >= edge or along <= 0.0 or distance > caution:
            continue  # not in D, or in the Safety Zone (eq. 3.3)
        closing, outward = -(c * vx + s * vy), c * vy - s * vx
        way_out = edge - across if outward > 0.0 else edge + across
        t_avoid = avoid_time(way_out, abs(outward))
        is_stable = not is_moving[i] or t_avoid > _LEAVES_S
        if is_judged[i] and not is_moving[i]:
            continue  # stands for a thing
        if is_stable:
            t_avoid = (edge - abs(across)) / side_speed
            t_aware = aware_time(distance, caution, aware)
            bound = stable_bound(distance, danger, closing, t_aware, t_avoid)
        else:
            bound = unstable_bound(distance, danger, closing, t_avoid)
        if bound < best or (bound == best and distance < at):
            best, who, at, best_stable = bound, i, distance, is_stable
    return best, who, at, best_stable


def bystander_in_reach(
    course: float, scene: Scene, is_known: np.ndarray, front: float, half: float,
    config: SjmcConfig, is_spent: bool = False,
) -> tuple[float, int]:  # fmt: skip
    """Return how fast to come up to who stands beside D and may step into it, and who that is.

    The distance is from the robot's front to the body, whichever way: who is as far off is as soon
    before the robot, also when the robot has drifted to the other side of its way.

    Args:
        course: Bearing, rad.
        scene: Surroundings.
        is_known: Who is not minded, shape (N,), bool.
        front: How far the robot reaches ahead of its base, m.
        half: Half of the width of D, m.
        config: `bystander_*`.
        is_spent: Whether patience with bystanders is: then it comes up to the line faster.

    Returns:
        m/s, inf for nobody; the row of the person, -1 for nobody.
    """
    if config.bystander_s == 0.0:
        return math.inf, -1
    args = course, scene.people, scene.is_moving, is_known, front, half, config.bystander_m
    gap, who = _beside(*args)
    if who < 0:
        return math.inf, -1
    room = gap - config.bystander_line_m
    if room < -_PAST_LINE:
        return config.bystander_pass_m_s, who
    if is_spent and room > 0.0:
        return config.bystander_pass_m_s + room / _BRISK_S, who
    return max(room / config.bystander_s, config.bystander_end_m_s), who


@numba.njit(cache=True, nogil=True)
def _beside(course, people, is_moving, is_known, front, half, reach):  # type: ignore[no-untyped-def]
    """Return how far from the front the nearest bystander is, and its row; inf, -1 for nobody."""
    c, s = math.cos(course), math.sin(course)
    nearest, who = np.inf, -1
    for i in range(len(people)):
        x, y, r = people[i, 0], people[i, 1], people[i, 4]
        ahead, aside = c * x + s * y - front, abs(c * y - s * x) - half
        is_there = ahead > r and r < aside < reach + r
        gap = math.hypot(ahead, aside) - r
        if is_there and not is_moving[i] and not is_known[i] and gap < nearest:
            nearest, who = gap, i
    return nearest, who


def _leaves(scene: Scene, course: float) -> np.ndarray:
    """Tell who walks away from a course to its side, shape (N,), bool."""
    c, s = math.cos(course), math.sin(course)
    across = c * scene.people[:, 1] - s * scene.people[:, 0]
    outward = c * scene.people[:, 3] - s * scene.people[:, 2]
    return np.asarray(across * outward > _LEAVING * np.abs(across))


def _are_in(numbers: np.ndarray, known: set[int]) -> np.ndarray:
    if not known:
        return np.zeros(len(numbers), dtype=bool)
    return np.array([n in known for n in numbers.tolist()], dtype=bool)


class Patience:
    """Remembers for whom the robot waited, and who is judged not to yield.

    Args:
        config: How long it waits.
        period: Time between two calls, s.
    """

    def __init__(self, config: SjmcConfig, period: float) -> None:
        self._config, self._period = config, period
        self._waited: dict[int, float] = {}
        self._free: dict[int, float] = {}
        self._judged: set[int] = set()
        self._harmless: set[int] = set()
        self._spent = 0.0

    def begin(self, scene: Scene, course: float) -> np.ndarray:
        """Return who is judged not to yield, shape (N,), bool, in a new scene."""
        known = set(scene.number.tolist())
        speed = np.hypot(scene.people[:, 2], scene.people[:, 3])
        moving = set(scene.number[speed > _YIELDS].tolist())
        self._judged = (self._judged & known) - moving
        for number in list(self._waited):
            self._free[number] = self._free.get(number, 0.0) + self._period
            if number not in known or self._free[number] > _RESTS_S:
                del self._waited[number], self._free[number]
        leaving = set(scene.number[_leaves(scene, course)].tolist())
        self._harmless = ((self._harmless & known) - moving) | leaving
        return _are_in(scene.number, self._judged)

    def known(self, scene: Scene) -> np.ndarray:
        """Return who stands beside the way and is not minded, shape (N,), bool."""
        return _are_in(scene.number, self._harmless | self._judged)

    @property
    def is_spent(self) -> bool:
        """Whether it came up slowly to bystanders for long enough."""
        return self._spent >= self._config.bystander_patience_s

    def mind(self, has_minded: bool) -> None:
        """Take note whether it came up slowly to a bystander for one period."""
        change = self._period if has_minded else -_REGAIN * self._period
        self._spent = min(max(self._spent + change, 0.0), 2.0 * self._config.bystander_patience_s)

    def judge(self, number: int) -> None:
        """Expect no more of a person."""
        self._judged.add(number)

    def wait_for(self, ahead: InTheWay, scene: Scene) -> tuple[float, bool]:
        """Wait for the person ahead, or the nearest; return for how long, and if that is it."""
        people = scene.people
        if not len(people):
            return 0.0, False  # it is slow for a thing
        who = ahead.who if ahead.who >= 0 else int(np.argmin(np.hypot(people[:, 0], people[:, 1])))
        number = int(scene.number[who])
        waited = self.wait(number)
        if self.is_out(waited):
            self.judge(number)
        return waited, self.is_out(waited)

    def wait(self, number: int) -> float:
        """Wait for a person one period more; return how long it waited so far, s."""
        waited = self._waited.get(number, 0.0) + self._period
        self._waited[number], self._free[number] = waited, 0.0
        return waited

    def is_out(self, waited: float) -> bool:
        """Tell whether it waited long enough."""
        return waited >= self._config.patience_s
