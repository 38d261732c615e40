"""Making room for who would come too near even if the robot stopped: back, or turn away in time.

Who would walk over it anyway had better meet a robot that stands. Among several who walk it backs
slowly, and stands while one of them is right before it: whoever gives way to one gets into the way
of the next, and a robot that stands is the one that they can reckon with.
"""

from __future__ import annotations

import math

import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.planning import RobotState, Velocity
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_rollout import Foreseen, Foresight
from sjmc_planner.sjmc_scene import Scene

_BACK = (-0.15, -0.3, -0.5)  # m/s; only the first among several
_AWAY = (20.0, 40.0, 60.0, 80.0, 100.0)  # deg
_HOLD_S = 1.5
_HOPELESS = -0.2  # m
_SEEN_M = 1.0  # so far beyond the robot a way has to have been looked along
_GAIN, _GAIN_ON = 0.05, 0.005  # better than standing by this at least, to begin and to go on, m


def make_room(
    state: RobotState,
    scene: Scene,
    foresight: Foresight,
    standing: Foreseen,
    behind: float,
    robot: RobotConfig,
    config: SjmcConfig,
    is_backing: bool = False,
) -> tuple[float, float] | None:
    """Return the speed and the course that make room; None for standing still.

    Args:
        state: How the robot moves.
        scene: Surroundings.
        foresight: Looks ahead.
        standing: What comes of braking.
        behind: How far it may back, m.
        robot: Its limits.
        config: Clearances and times.
        is_backing: Whether it was decided to back already, whatever the robot does as yet.
    """
    now, fastest = state.velocity, robot.speed_m_s
    things = foresight.within_reach(now, fastest, scene.solids, _HOLD_S)
    people = foresight.may_meet(now, fastest, scene.people, _HOLD_S)
    gain = _GAIN_ON if is_backing else _GAIN
    best, chosen = max(standing.people_gap + gain, _HOPELESS), None
    for wanted in _BACK if scene.num_walking <= 1 else _BACK[:1]:
        if behind <= 0.02:
            break
        speed = max(wanted, -fastest)
        back = Velocity(speed, 0.0, 0.0)
        seen = foresight.obey(now, back, behind / -speed, things, people)
        if seen.people_gap > best and seen.thing_gap > 0.0:
            best, chosen = seen.people_gap, (speed, 0.0)
        if best >= config.clearance_m:
            return chosen
    if standing.people_time > config.dodge_s:
        return chosen
    for angle in _AWAY:
        sides = _seen(angle, scene, robot)
        for share in (1.0, 0.5):
            speed, gaps = share * robot.speed_m_s, {}
            for course in sides:
                seen = foresight.look(now, course, speed, _HOLD_S, things, people)
                gaps[course] = seen.people_gap if seen.thing_gap >= robot.margin_m else -math.inf
            course = max(gaps, key=gaps.__getitem__, default=0.0)
            if course != 0.0 and gaps[course] > best + _GAIN:
                best, chosen = gaps[course], (speed, course)
    return chosen


def _seen(angle: float, scene: Scene, robot: RobotConfig) -> list[float]:
    """Return the courses an angle (deg) to either side whose way was looked along, rad.

    A differential robot drives along its heading while it turns: that has to be seen too.
    """
    looked = robot.radius_m, _SEEN_M
    if robot.drive == "differential" and scene.ends.unseen(np.zeros(1), *looked)[0]:
        return []
    sides = np.radians([angle, -angle])
    return [float(course) for course in sides[~scene.ends.unseen(sides, *looked)]]
