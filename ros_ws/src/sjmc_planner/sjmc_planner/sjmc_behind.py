"""Who was seen going behind the robot and may still be there, where no beam looks.

A track is forgotten a second after its person went out of view, but who went slowly is not gone by
then: everybody is carried on for longer where no beam looks, so that nobody is backed into.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.beam_ends import BeamEnds
from sjmc_planner.planning import RobotState
from sjmc_planner.sjmc_scene import Scene

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
_KEEP_S = 3.0


class Behind:
    """Remembers people who are out of view.

    Args:
        reach: Nearer to the base than this they are near, m.
        period: Time between two calls, s.
    """

    def __init__(self, reach: float, period: float) -> None:
        self._reach, self._period = reach, period
        self._rows = np.zeros((0, 6))  # x, y, vx, vy, time out of view, number

    def is_near(self, state: RobotState, scene: Scene) -> bool:
        """Tell whether somebody may be near where no beam looks; to be asked once a period."""
        moved = state.moved.x, state.moved.y, state.moved.yaw
        kept = _carried(self._rows, moved, self._period, scene.number, *_beams(scene.ends))
        fresh = np.zeros((len(scene.people), 6))
        fresh[:, :4], fresh[:, 5] = scene.people[:, :4], scene.number
        self._rows = np.concatenate((kept, fresh))
        return bool(_is_any_near(self._rows, self._reach, *_beams(scene.ends)))


def _beams(ends: BeamEnds) -> tuple[np.ndarray, float, float, tuple[float, ...]]:
    return ends.ranges, ends.angle_min, ends.angle_increment, ends.pose


@numba.njit(cache=True, nogil=True, inline="always")
def _is_out(x, y, ranges, angle_min, step, pose):  # type: ignore[no-untyped-def]
    """Tell whether no beam looked towards a place of the base frame."""
    angle = math.atan2(y - pose[1], x - pose[0]) - pose[4]
    beam = ((angle - angle_min) * (1.0 if step > 0.0 else -1.0)) % (2.0 * math.pi)
    k = int(np.rint(beam / abs(step)))
    return k >= len(ranges) or np.isnan(ranges[k])


@numba.njit(cache=True, nogil=True)
def _carried(rows, moved, period, shown, ranges, angle_min, step, pose):  # type: ignore[no-untyped-def]
    """Return those who are out of view and not shown, a period later, from where the robot is."""
    found = np.empty_like(rows)
    c, s = math.cos(moved[2]), math.sin(moved[2])
    count = 0
    for i in range(len(rows)):
        vx, vy, age = rows[i, 2], rows[i, 3], rows[i, 4] + period
        dx, dy = rows[i, 0] + period * vx - moved[0], rows[i, 1] + period * vy - moved[1]
        x, y = c * dx + s * dy, c * dy - s * dx
        is_shown = False
        for number in shown:
            is_shown |= number == rows[i, 5]
        if is_shown or age > _KEEP_S or not _is_out(x, y, ranges, angle_min, step, pose):
            continue
        found[count, 0], found[count, 1] = x, y
        found[count, 2], found[count, 3] = c * vx + s * vy, c * vy - s * vx
        found[count, 4], found[count, 5] = age, rows[i, 5]
        count += 1
    return found[:count].copy()


@numba.njit(cache=True, nogil=True)
def _is_any_near(rows, reach, ranges, angle_min, step, pose):  # type: ignore[no-untyped-def]
    for i in range(len(rows)):
        is_near = rows[i, 0] ** 2 + rows[i, 1] ** 2 < reach * reach
        if is_near and _is_out(rows[i, 0], rows[i, 1], ranges, angle_min, step, pose):
            return True
    return False
