"""How fast to meet who comes beside the way and may turn into it.

People who come towards a robot are not held to the line that they walk on: they swerve around each
other and back, and one who has passed by foreseen at constant velocity may turn in a moment later.
What can be promised without knowing what they will do is passive motion safety (Bouraine, Fraichard
and Salhi 2012): should there be a contact, the robot is at rest by then. So of everybody who walks
before it, it is asked how soon they could be in D by turning in as sharply as people do, how soon
they would be level with its front, and from what speed it is at rest before the later of both.

People take up another velocity within a relaxation time (Helbing and Molnar 1995: 0.5 s), so who
walks faster turns in more sharply.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from sjmc_planner.sjmc_scene import Scene

# numba keeps these kernels by this file's date alone: see `unicycle_motion`.
_KNOWN_S = 0.15  # until a turn shows in a track: a scan, and what the filter holds back
_LEAST = 0.1  # m/s
_AT_REST = 0.04  # m/s: as good as standing


@numba.njit(cache=True, nogil=True)
def time_to_turn_in(beside: float, outward: float, accel: float) -> float:
    """Return how soon who is beside D can be in it: beside + outward t - accel t^2 / 2 = 0, s.

    Args:
        beside: From the body to D, m.
        outward: Speed away from D, m/s.
        accel: How sharply it turns in, m/s^2.
    """
    if beside <= 0.0:
        return 0.0
    return (outward + math.sqrt(outward * outward + 2.0 * accel * beside)) / accel


@numba.njit(cache=True, nogil=True)
def speed_to_rest_by(time: float, brake: float, delay: float) -> float:
    """Return the speed from which a robot is at rest in a time, m/s."""
    return max(brake * (time - delay) + _AT_REST, 0.0)


@numba.njit(cache=True, nogil=True)
def speed_to_rest_before(distance: float, closing: float, brake: float, delay: float) -> float:
    """Return the speed from which a robot is at rest before it meets who comes, m/s.

    Until then, v / brake + delay, it drives v delay + v^2 / (2 brake) and the other comes
    closing (v / brake + delay); both together are the distance.

    Args:
        distance: Between them, m.
        closing: Speed of who comes, m/s.
        brake: Deceleration, m/s^2.
        delay: Until it brakes, s.
    """
    room = distance - closing * delay
    if room <= 0.0:
        return 0.0
    half = delay + closing / brake
    return brake * (math.sqrt(half * half + 2.0 * room / brake) - half)


def turning_in_bound(
    course: float, scene: Scene, front: float, rear: float, half: float, air: float,
    reach: float, brake: float, delay: float, turn_time: float,
) -> tuple[float, int]:  # fmt: skip
    """Return how fast it may drive along a course among who comes, and who allows least.

    Args:
        course: Bearing, rad.
        scene: Surroundings.
        front: How far the robot reaches ahead of its base, m.
        rear: And behind, m.
        half: Half of the width of D, m.
        air: To keep to who comes straight on, m.
        reach: Who is farther from its front does not count, m.
        brake: Its deceleration, m/s^2.
        delay: Until a command acts, s.
        turn_time: In which people turn in at their speed, s; 0 = no regard.

    Returns:
        m/s, inf for nobody; the row of the person, -1 for nobody.
    """
    if turn_time == 0.0:
        return math.inf, -1
    args = course, scene.people, scene.is_moving
    late = delay + _KNOWN_S
    found = _least(*args, front, 0.5 * (front - rear), half, air, reach, brake, late, turn_time)
    return float(found[0]), int(found[1])


@numba.njit(cache=True, nogil=True)
def _least(course, people, is_moving, front, middle, half, air, reach, brake, delay, turn_time):  # type: ignore[no-untyped-def]
    c, s = math.cos(course), math.sin(course)
    least, who = np.inf, -1
    for i in range(len(people)):
        x, y, vx, vy, r = people[i]
        along, across = c * x + s * y, c * y - s * x
        going, left = max(c * vx + s * vy, 0.0), c * vy - s * vx
        distance, closing = along - front - r - air, max(-(c * vx + s * vy), 0.0)
        if not is_moving[i] or distance > reach:
            continue
        accel = max(math.hypot(vx, vy), _LEAST) / turn_time
        t_in = time_to_turn_in(abs(across) - half - r, left if across > 0.0 else -left, accel)
        if along + r - t_in * closing <= middle:
            continue  # it is past the front half by then
        bound = max(
            speed_to_rest_by(t_in, brake, delay),
            speed_to_rest_before(distance + going * going / (2.0 * accel), closing, brake, delay),
        )
        if bound < least:
            least, who = bound, i
    return least, who
