"""SJMC with people told apart: who is in the way, where they go, and whether they make room.

The questions are the thesis's (Fig. 3.3): may the course to the target be kept, must an obstacle be
avoided, is the target reached (asked first here; in a loop the same). Tracks of people give what it
left out: v_ox, v_oy and t_avoid, per person. Beyond it:
- t_aware shrinks with the distance, and a person counts as not yielding once standing in the way
  where eq. 3.5 leaves no speed to speak of; things (wide and standing) are never waited for;
- who walks through D is waited for, also inside L_DANGER, while the robot can stop, up to a time;
- a course is driven at a speed from which braking keeps clear of things and of people as foreseen;
  of two sides the one taken first is kept until the target's course is open again;
- who would come too near even if it stopped is met by backing, or by turning away in time.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sjmc_planner.config import RobotConfig
from sjmc_planner.limited_motion import stopping_speed
from sjmc_planner.omni_velocity import Cycle
from sjmc_planner.planning import (
    BACKING,
    BLOCKED,
    BRAKING,
    DRIVING,
    REACHED,
    STILL,
    TURNING,
    WAITING,
    Decision,
    Goal,
    Obstacles,
    RobotState,
    Velocity,
)
from sjmc_planner.sjmc_config import SjmcConfig
from sjmc_planner.sjmc_course import preferred
from sjmc_planner.sjmc_moment import Moment, MomentReader
from sjmc_planner.sjmc_people import (
    InTheWay,
    Patience,
    bystander_in_reach,
    is_not_yielding,
    people_in_the_way,
    stands_near,
)
from sjmc_planner.sjmc_region import box_of
from sjmc_planner.sjmc_retreat import Retreat
from sjmc_planner.sjmc_rollout import Foreseen, Foresight
from sjmc_planner.sjmc_room import make_room
from sjmc_planner.sjmc_scene import SceneReader
from sjmc_planner.sjmc_way_out import WayOut
from sjmc_planner.tracking_config import TrackingConfig
from sjmc_planner.unicycle_motion import Unicycle

_SHARES = (1.0, 0.75, 0.5, 0.3, 0.15)  # of a course's speed, tried in turn
_LOOKS = (1.0, 0.5, 0.25)  # of look_m
_MOST = 24  # courses looked along with each
_SLOW, _HELD, _HELD_SHARE = 0.03, 0.1, 0.9  # m/s
_CREEP = 0.2  # m/s
_WISHES = 3  # in a row to turn away: till then it brakes, as turns that end at once do not


class Sjmc:
    """The method, for holonomic and differential robots.

    Args:
        robot: What the robot is.
        config: Settings of the method.
        tracking: Settings of the tracker.
        cycle: Rhythm of the runner.
    """

    def __init__(
        self, robot: RobotConfig, config: SjmcConfig, tracking: TrackingConfig, cycle: Cycle
    ) -> None:
        self._robot, self._config, self._cycle = robot, config, cycle
        self._box = box_of(robot)
        self._half = self._box.half_width + robot.margin_m
        self._delay = robot.idle_time_s + cycle.period
        self._scenes = SceneReader(tracking, config.person_width_m, cycle.unseen_gap, cycle.period)
        self._foresight = Foresight(robot, self._box, self._delay, config.horizon_s)
        self._moments = MomentReader(robot, config, self._box, self._foresight, self._delay)
        self._patience = Patience(config, cycle.period)
        self._unicycle = Unicycle(robot) if robot.drive == "differential" else None
        self._retreat = Retreat(robot, config, cycle.period)
        self._way_out = WayOut(self._unicycle, self._foresight, self._moments, cycle.period)
        self._side = 0
        self._has_minded = self._is_backing = False
        self._num_wished = 0

    def decide(
        self, state: RobotState, obstacles: Obstacles, goal: Goal, *, has_debug: bool = False
    ) -> Decision:
        """Return the command for now (Fig. 3.3; the end is asked first)."""
        scene = self._scenes.read(state, obstacles)
        self._retreat.note(state)
        self._retreat.mind(state, scene)
        self._way_out.note(state.moved.yaw)
        if goal.distance <= self._cycle.goal_tolerance:  # end
            return Decision(STILL, REACHED)
        self._patience.mind(self._has_minded)
        self._has_minded = False
        is_judged = self._patience.begin(scene, goal.bearing)
        moment = self._moments.of(state, goal, scene, is_judged)
        ahead = self._in_the_way(goal.bearing, moment)
        if is_not_yielding(ahead, scene, self._config):
            self._patience.judge(int(scene.number[ahead.who]))
            is_judged[ahead.who] = True
            moment = self._moments.of(state, goal, scene, is_judged)
        num_wished = self._num_wished
        decision = self._way_out.turn(moment) or self._on_course(moment) or self._around(moment)
        if decision is None:
            decision = self._way_out.begin_turn(moment, self._open_courses(moment))
        if self._num_wished == num_wished:
            self._num_wished = 0
        if self._retreat.is_due(decision) and not obstacles.shows_nothing:
            decision = self._way_out.back(moment, self._retreat) or decision
        if decision is None:
            decision = self._stuck(moment)
        self._is_backing = decision.state == BACKING
        if has_debug:
            who = self._in_the_way(goal.bearing, moment).who
            decision = replace(decision, debug=self._moments.debug(moment, decision.command, who))
        return decision

    def _on_course(self, moment: Moment) -> Decision | None:
        """Return the straight run, waiting included; None if something stands in its way."""
        if moment.free[0] < self._config.look_m or moment.is_blind:
            return None
        course, ahead = moment.goal.bearing, self._in_the_way(moment.goal.bearing, moment)
        beside = self._beside(course, moment)
        speed, seen = self._safe_speed(course, min(ahead.bound, beside), moment)
        alone, _ = self._safe_speed(course, math.inf, self._moments.without_people(moment))
        is_for_person = speed < _HELD_SHARE * alone
        if speed > _SLOW:
            if moment.free[0] == math.inf:
                self._side = 0
            is_held = is_for_person and speed < min(_HELD, _HELD_SHARE * beside)
            if is_held and self._patience.wait_for(ahead, moment.scene)[1]:
                return None
            reason = "slower for a person" if is_for_person else ""
            return Decision(self._command(course, speed), DRIVING, reason)
        if not (moment.is_met or self._moments.keeps_off_people(seen, moment)):
            made = self._make_room(seen, moment)
            if made is not None:
                return made
        if not is_for_person:
            return None
        waited, is_out = self._patience.wait_for(ahead, moment.scene)
        if is_out:
            return None
        is_walking = ahead.who >= 0 and moment.scene.is_moving[ahead.who]
        whom = "a person" if is_walking else "what may be a person"
        return Decision(STILL, WAITING, f"for {whom}, {waited:.1f} s")

    def _make_room(self, seen: Foreseen, moment: Moment) -> Decision | None:
        """Return how to give way to who would come too near even if it stopped."""
        args = moment.state, moment.scene, self._foresight, seen, self._retreat.behind
        room = make_room(*args, self._robot, self._config, self._is_backing)
        if room is None:
            return None
        speed, course = room
        if speed < 0.0:
            return Decision(Velocity(speed, 0.0, 0.0), BACKING, "makes room for a person")
        self._num_wished += 1
        if self._num_wished < _WISHES:
            return None
        return Decision(self._command(course, speed), TURNING, "out of a person's way")

    def _around(self, moment: Moment) -> Decision | None:
        """Return the turning run; None if no course is open."""
        if not self._moments.is_clear(moment.braked, moment):
            return None
        order = preferred(moment.bearings, moment.goal.bearing, moment.free, self._side)
        for look in _LOOKS:
            far = min(look * self._config.look_m, self._moments.reach(moment.goal))
            for k in order[moment.free[order] >= far][:_MOST]:
                course = float(moment.bearings[k])
                ahead = self._in_the_way(course, moment)
                if k != 0 and stands_near(ahead, self._config):
                    continue
                bound = min(ahead.bound, self._beside(course, moment))
                stop = stopping_speed(moment.free[k], self._robot.accel_m_s2, self._delay)
                speed, _ = self._safe_speed(course, min(bound, stop), moment)
                if moment.is_blind and self._unicycle is not None:
                    return self._turned(course, moment)
                if speed > _SLOW:
                    self._side = 0 if k == 0 else 1 if k % 2 == 1 else -1
                    return Decision(
                        self._command(course, speed), TURNING, self._moments.around(moment)
                    )
        return None

    def _open_courses(self, moment: Moment) -> np.ndarray:
        """Return the courses to turn to, open as far as is known, the best first, rad."""
        order = preferred(moment.bearings, moment.goal.bearing, moment.not_shut, self._side)
        far = min(_LOOKS[-1] * self._config.look_m, self._moments.reach(moment.goal))
        return np.asarray(moment.bearings[order[moment.not_shut[order] >= far]])

    def _stuck(self, moment: Moment) -> Decision:
        """Return what is left: creep on where that is safe, or stand."""
        ahead = self._in_the_way(moment.goal.bearing, moment)
        bound = min(_CREEP, ahead.bound, self._moments.turning_in(moment.goal.bearing, moment))
        speed, _ = self._safe_speed(moment.goal.bearing, bound, moment)
        reason = "the way is not seen" if moment.is_blind else "no course is open"
        if speed > _SLOW and not moment.is_blind:
            return Decision(self._command(moment.goal.bearing, speed), DRIVING, f"slowly: {reason}")
        is_still = moment.state.velocity.speed < _SLOW
        return Decision(STILL, BLOCKED if is_still else BRAKING, reason)

    def _turned(self, course: float, moment: Moment) -> Decision:
        """Return how to face a course that was seen, from one that was not: stand, then turn."""
        reason = "the way ahead is not seen"
        if moment.state.velocity.speed > _SLOW:
            return Decision(STILL, BRAKING, reason)
        return Decision(self._command(course, 0.0), TURNING, reason)

    def _in_the_way(self, course: float, moment: Moment) -> InTheWay:
        args = moment.scene, moment.is_judged, self._box.front, self._half
        return people_in_the_way(course, *args, self._config)

    def _beside(self, course: float, moment: Moment) -> float:
        """Return how fast it may come up to who stands beside a course, m/s."""
        known = self._patience.known(moment.scene)
        args = moment.scene, known, self._box.front, self._half, self._config
        bound, _ = bystander_in_reach(course, *args, self._patience.is_spent)
        if bound < moment.fastest:
            self._has_minded = True
        return min(bound, self._moments.turning_in(course, moment))

    def _safe_speed(self, course: float, bound: float, moment: Moment) -> tuple[float, Foreseen]:
        """Return the most speed from which braking keeps clear, and what is foreseen at it."""
        most, now = min(bound, moment.fastest), moment.state.velocity
        around = moment.near, moment.people
        if most <= _SLOW or moment.is_met or not self._moments.is_clear(moment.braked, moment):
            return 0.0, moment.braked
        for share in _SHARES:
            seen = self._foresight.look(now, course, share * most, self._cycle.period, *around)
            if self._moments.is_clear(seen, moment):
                return share * most, seen
        return 0.0, moment.braked

    def _command(self, course: float, speed: float) -> Velocity:
        if self._unicycle is not None:
            return self._unicycle.command(course, speed)
        return Velocity(speed * math.cos(course), speed * math.sin(course), 0.0)
