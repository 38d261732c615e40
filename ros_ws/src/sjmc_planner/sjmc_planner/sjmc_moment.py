"""All that one decision of `sjmc` goes by: the scene, and how far each course is free."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import stopping_speed
from sjmc_planner.planning import Debug, Goal, RobotState, Velocity
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_course import courses
from sjmc_planner.sjmc_region import Box, free_ways
from sjmc_planner.sjmc_rollout import Foreseen, Foresight
from sjmc_planner.sjmc_scene import Scene
from sjmc_planner.sjmc_turning_in import turning_in_bound

_WIDEST = math.radians(120.0)
_SEEN_M = 1.0  # so far beyond the robot a course has to have been looked along
_NO_SPEED, _NO_GAP = 0.03, 1e-6
_MET_M = 0.2  # from the outline to a person's disk: legs reach out of it
_MET_S = 0.35  # or so soon before: from its slowest backing the robot is at rest by then
_KEEP_GAP = 1e-3  # nearer than asked for already: no nearer than this, m


@dataclass(frozen=True)
class Moment:
    """What is known when deciding.

    Attributes:
        state: How the robot moves.
        goal: Where to go.
        scene: Surroundings.
        is_judged: Who is judged not to yield, shape (N,), bool.
        bearings: Of the courses, the target's first, shape (K,), rad.
        free: How far each is free of what does not yield, shape (K,), m; 0 where not looked.
        not_shut: The same of what is known, looked or not.
        fastest: What the travel speed, the goal and the horizon allow, m/s.
        is_met: Whether one of several who walk is right before the robot.
        is_blind: Whether the way that the robot faces was not looked along.
        now: Gaps of now.
        near: Things that braking may come near, and how far to keep off each, shape (M, 3), m.
        people: People who may come near meanwhile, rows as in the scene.
        braked: What comes of braking now.
    """

    state: RobotState
    goal: Goal
    scene: Scene
    is_judged: np.ndarray
    bearings: np.ndarray
    free: np.ndarray
    not_shut: np.ndarray
    fastest: float
    is_met: bool
    is_blind: bool
    now: Foreseen
    near: np.ndarray
    people: np.ndarray
    braked: Foreseen


class MomentReader:
    """Puts together what a decision goes by.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        box: What the robot takes up.
        foresight: Looks ahead.
        delay: Time until a command acts, s.
    """

    def __init__(
        self, robot: RobotConfig, config: SjmcConfig, box: Box, foresight: Foresight, delay: float
    ) -> None:
        self._robot, self._config, self._box = robot, config, box
        self._half = box.half_width + robot.margin_m
        self._foresight, self._delay = foresight, delay

    def of(self, state: RobotState, goal: Goal, scene: Scene, is_judged: np.ndarray) -> Moment:
        """Return what is known, with how far each course is free of what does not yield."""
        config, robot = self._config, self._robot
        bearings = courses(goal.bearing, config.course_step_rad, _WIDEST)
        is_solid = (is_judged | self._is_beside(goal.bearing, scene)) & ~scene.is_moving
        points = np.concatenate((scene.things, scene.people[is_solid, :2]))
        radii = np.zeros(len(points))
        radii[len(scene.things) :] = scene.people[is_solid, 4] + config.clearance_m
        free = free_ways(bearings, points, radii, self._box.front, self._half)
        free[free + self._box.front > self.reach(goal)] = np.inf
        not_shut = free.copy()
        looked = robot.radius_m, _SEEN_M
        free[scene.ends.unseen(bearings, *looked)] = 0.0
        heading = np.zeros(1) if robot.drive == "differential" else bearings[:1]
        is_blind = bool(scene.ends.unseen(heading, *looked)[0])
        room = min(goal.distance, scene.ends.horizon - self._box.front)
        fastest = min(robot.speed_m_s, stopping_speed(room, robot.accel_m_s2, self._delay))
        is_met = scene.num_walking > 1 and self._is_met(scene)
        now = self._foresight.gaps(scene.solids, scene.people)
        near = self._foresight.within_reach(state.velocity, fastest, scene.solids)
        near = self._foresight.kept_off(near, robot.margin_m)
        people = self._foresight.may_meet(state.velocity, fastest, scene.people)
        braked = self._foresight.look(state.velocity, 0.0, 0.0, 0.0, near, people)
        return Moment(
            state, goal, scene, is_judged, bearings, free, not_shut, fastest, is_met, is_blind, now,
            near, people, braked,
        )  # fmt: skip

    def _is_met(self, scene: Scene) -> bool:
        """Tell whether somebody who walks is right before the robot's front half."""
        walking, box = scene.people[scene.is_moving], self._box
        ahead = np.maximum(walking[:, 0] - box.front, 0.0)
        aside = np.maximum(np.abs(walking[:, 1]) - box.half_width, 0.0)
        inward = -(ahead * walking[:, 2] + np.sign(walking[:, 1]) * aside * walking[:, 3])
        away = np.maximum(np.hypot(ahead, aside), _NO_GAP)
        gap = away - walking[:, 4] - _MET_S * np.maximum(inward / away, 0.0)
        is_before = walking[:, 0] > 0.5 * (box.front - box.rear)
        return bool((is_before & (gap < _MET_M)).any())

    def _is_beside(self, course: float, scene: Scene) -> np.ndarray:
        """Tell who is not in D along a course but too near beside it, shape (N,), bool."""
        across = math.cos(course) * scene.people[:, 1] - math.sin(course) * scene.people[:, 0]
        return np.asarray(np.abs(across) >= self._half + scene.people[:, 4])

    def reach(self, goal: Goal) -> float:
        """Return how far things count: D ends at the target, or where the robot can stop."""
        robot = self._robot
        stop = robot.speed_m_s * (self._delay + robot.speed_m_s / (2.0 * robot.accel_m_s2))
        target = float(np.hypot(*goal.point)) + robot.margin_m + self._box.front
        return max(target, min(goal.distance, stop) + self._box.front)

    def is_clear(self, seen: Foreseen, moment: Moment) -> bool:
        """Tell whether a look ahead keeps its distances, or at least what there is of them."""
        return seen.thing_gap >= 0.0 and self.keeps_off_people(seen, moment)

    def keeps_off_people(self, seen: Foreseen, moment: Moment) -> bool:
        """Tell the same of people alone."""
        person = min(self._config.clearance_m, moment.now.people_gap - _KEEP_GAP)
        return seen.people_gap >= person

    def turning_in(self, course: float, moment: Moment) -> float:
        """Return how fast it may meet who may turn into a course, m/s."""
        config, box = self._config, self._box
        return turning_in_bound(
            course, moment.scene, box.front, box.rear, self._half, config.clearance_m,
            config.caution_m, self._robot.accel_m_s2, self._delay, config.turns_in_s,
        )[0]  # fmt: skip

    def without_people(self, moment: Moment) -> Moment:
        """Return the same with nobody there, to tell for whom or what the robot stops."""
        if not len(moment.scene.people):
            return moment
        now = moment.state.velocity
        near = self._foresight.within_reach(now, moment.fastest, moment.scene.things)
        near, nobody = self._foresight.kept_off(near, self._robot.margin_m), moment.people[:0]
        braked = self._foresight.look(now, 0.0, 0.0, 0.0, near, nobody)
        return replace(moment, is_met=False, near=near, people=nobody, braked=braked)

    def around(self, moment: Moment) -> str:
        """Return whom or what a turning run goes around, in words."""
        things = moment.scene.things
        args = things, np.zeros(len(things)), self._box.front, self._half
        is_person = moment.not_shut[0] < free_ways(moment.bearings[:1], *args)[0]
        if moment.is_judged.any() and (is_person or moment.not_shut[0] >= self._config.look_m):
            return "around a person who does not yield"
        return "around a person" if is_person else "around a thing"

    def debug(self, moment: Moment, command: Velocity, who: int) -> Debug:
        """Return what was weighed, the course that a command takes and who counts."""
        lengths = np.minimum(moment.free, self._config.look_m)
        units = np.column_stack((np.cos(moment.bearings), np.sin(moment.bearings)))
        ways = [np.array([[0.0, 0.0], a * u]) for a, u in zip(lengths, units, strict=True)]
        course = math.atan2(command.y, command.x) if command.speed > _NO_SPEED else 0.0
        off = np.abs(np.remainder(moment.bearings - course + np.pi, 2.0 * np.pi) - np.pi)
        region = self._box.grown(self._robot.margin_m).corners()
        times = moment.free / self._robot.speed_m_s
        ahead = self._box.front
        zones = ahead + self._config.danger_m, ahead + self._config.caution_m
        return Debug(region, ways, times, int(np.argmin(off)), zones, moment.scene.people, who)
