"""One drive of the SJMC thesis's chapter 5 and of its Table 2.2, by kind.

Where the text is silent: the robot is 0.5 m past the obstacle's far face when the clock stops; the
target of 5.2.3 is far ahead, so that the angle to it is the robot's own; walkers draw 0.8 to
1.4 m/s; who stands in 5.2.4 faces the robot within 60 degrees. Table 2.2 names no set-up at all:
here a hall of 14 x 8 m, 3 or 9 posts, 3 or 9 people who walk to and fro and do not see the robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from experiments.crowd_scenes import ROBOT
from experiments.planner_drives import Course, drive_course
from experiments.planner_judge import Drive
from experiments.planner_wavefront import WavefrontPeer
from floornav_common.se2 import SE2
from sim_bridge.people.schema import WalkerPlan
from sim_bridge.world import Column, RobotPlacement, Wall, World, load_world
from sjmc_planner.config import LocalPlannerConfig
from sjmc_planner.methods import make_method
from sjmc_planner.planning import Method
from sjmc_planner.sjmc_config import SjmcConfig

STATIC, CROSSING, STANDING, ONCOMING, HALL = "static", "crossing", "standing", "oncoming", "hall"
WALKS = (0.8, 1.4)
STRAIGHT_RAD = math.radians(10.0)
PUBLISHED, WAVEFRONT = "sjmc_published", "wavefront"
SLIM = "vfh_plus_slim"  # VFH+ told a disk out of which the tail looks
_SLIM_M = 0.45
_CENTER = -0.145  # of the robot's outline, ahead of base_link, m
_FAR_FACE, _PAST = -0.79, 0.5
_MODEL = "segway_urg"
_POSTS = {"low": 3, "high": 9}
_KEEP_S = 0.2
_ASIDE = 0.3  # a step aside, m


@dataclass(frozen=True)
class Task:
    """A drive.

    Attributes:
        kind: `STATIC`, `CROSSING`, `STANDING`, `ONCOMING` or `HALL`.
        method: By name.
        number: Of the repetition.
        seed: Of the experiment.
        distance: Of the start (static) or of the person who sets out (crossing), m.
        response: C of the published rule, s.
        danger: L_DANGER of the published rule, m.
        density: `low` or `high` (hall).
        is_dynamic: Whether people walk in the hall, instead of posts standing there.
        is_yielding: Whether the person notices and makes room (standing, oncoming).
    """

    kind: str
    method: str
    number: int
    seed: int
    distance: float = 0.0
    response: float = 2.7
    danger: float = 1.9
    density: str = ""
    is_dynamic: bool = False
    is_yielding: bool = True


@dataclass(frozen=True)
class Outcome:
    """What came of it.

    Attributes:
        is_done: Whether the robot got past, or to its goal.
        time_s: Until then, or until time was up.
        path_m: Way driven.
        is_straight: Whether it faced within 10 degrees of the target, always.
        contacts: Touches of anything.
        by_robot: Of these, those that were the robot's doing.
        min_gap_m: Least distance to a person; inf with nobody.
        heading_changes: Turns by more than 15 degrees.
        waited_s: Time at rest.
        has_moved: Whether the first person went aside by 0.3 m or more before the robot was
            abreast of them.
        track: t, x, y, yaw of the robot, shape (N, 4).
        people: t, x, y of the first person, shape (M, 3).
    """

    is_done: bool
    time_s: float
    path_m: float
    is_straight: bool
    contacts: int
    by_robot: int
    min_gap_m: float
    heading_changes: int
    waited_s: float
    has_moved: bool
    track: np.ndarray
    people: np.ndarray

    @property
    def is_success(self) -> bool:
        """Whether it got there and touched nothing."""
        return self.is_done and self.contacts == 0


def run_task(task: Task) -> Outcome:
    """Drive one task."""
    sjmc = SjmcConfig(published_response_s=task.response, published_danger_m=task.danger)
    rng = np.random.default_rng([task.seed, task.number])
    course = _COURSES[task.kind](task, rng)
    seed = int(rng.integers(2**31))
    return _outcome(drive_course(course, _method(task.method, sjmc), ROBOT, seed), task)


def _method(name: str, sjmc: SjmcConfig) -> Method:
    if name == WAVEFRONT:
        return WavefrontPeer(LocalPlannerConfig(robot=ROBOT))
    if name == SLIM:
        slim = replace(ROBOT, radius_m=_SLIM_M, front_m=0.0, rear_m=0.0, half_width_m=0.0)
        return make_method(LocalPlannerConfig(method="vfh_plus", robot=slim))
    return make_method(LocalPlannerConfig(method=name, robot=ROBOT, sjmc=sjmc))


def _static(task: Task, rng: np.random.Generator) -> Course:
    del rng
    world = load_world("sjmc_static", {"start_distance_m": task.distance})
    goal = (-task.distance - 0.5, 0.0)
    return Course(world, goal, limit_s=60.0, is_over=lambda pose: _is_past(pose))


def _is_past(pose: SE2) -> bool:
    return bool((pose @ np.array([[_CENTER, 0.0]]))[0, 0] < _FAR_FACE - _PAST)


def _crossing(task: Task, rng: np.random.Generator) -> Course:
    figures = {"distance_m": task.distance, "walker_speed_m_s": float(rng.uniform(*WALKS))}
    world = load_world("sjmc_crossing", figures)
    return Course(world, (-20.0, 0.0), limit_s=60.0, is_over=lambda pose: pose.x < -1.5)


def _standing(task: Task, rng: np.random.Generator) -> Course:
    person = WalkerPlan(
        name="person", path_m=((0.0, 0.0),), is_reacting=True, never_notices=not task.is_yielding
    )
    T = SE2(0.0, 0.0, float(rng.uniform(-math.pi / 3.0, math.pi / 3.0)))
    aside = float(rng.uniform(-0.15, 0.15))
    start, goal, over = T @ np.array([[5.0, aside], [-20.0, aside], [-2.0, aside]])
    robot = RobotPlacement(
        model=_MODEL, position_m=tuple(start), yaw_deg=math.degrees(T.yaw) + 180.0
    )
    world = World(name="standing", walls=_room(-9, -9, 9, 9), people=(person,), robots=(robot,))
    return Course(
        world, tuple(goal), limit_s=60.0,
        is_over=lambda pose: (T.inverse() @ pose).x < -2.0,
    )  # fmt: skip


def _oncoming(task: Task, rng: np.random.Generator) -> Course:
    figures = {
        "walker_speed_m_s": float(rng.uniform(*WALKS)), "never_notices": not task.is_yielding
    }  # fmt: skip
    world = load_world("sjmc_oncoming", figures)
    return Course(world, (-20.0, 0.0), limit_s=60.0, is_over=lambda pose: pose.x < -2.0)


def _hall(task: Task, rng: np.random.Generator) -> Course:
    num, robot = _POSTS[task.density], RobotPlacement(model=_MODEL, position_m=(1.0, 4.0))
    world = World(name="hall", walls=_room(0, 0, 14, 8), robots=(robot,))
    if task.is_dynamic:
        world = replace(world, people=tuple(_to_and_fro(k, num, rng) for k in range(num)))
    else:
        places = _apart(num, rng)
        posts = [
            Column(name="post", center_m=(float(x), float(y)), radius_m=0.2) for x, y in places
        ]
        world = replace(world, columns=tuple(posts))
    return Course(world, (13.0, 4.0), limit_s=90.0)


def _to_and_fro(k: int, num: int, rng: np.random.Generator) -> WalkerPlan:
    x = 3.5 + 8.0 * (k + float(rng.uniform(0.0, 1.0))) / num
    ends = [(x, 0.6), (x + float(rng.uniform(-1.5, 1.5)), 7.4)]
    ends = ends[:: int(rng.choice([-1, 1]))]
    return WalkerPlan(
        name=f"walker {k + 1}", path_m=tuple(ends), speed_m_s=float(rng.uniform(*WALKS)),
        repeats=True, starts_s=float(rng.uniform(0.0, 4.0)),
    )  # fmt: skip


def _apart(num: int, rng: np.random.Generator) -> np.ndarray:
    """Draw places 1.9 m apart, so that there is a way through, with one in the robot's way."""
    while True:
        places = rng.uniform((3.0, 1.2), (11.0, 6.8), (num, 2))
        places[0, 1] = 4.0 + rng.uniform(-0.2, 0.2)
        off = np.linalg.norm(places[:, None] - places[None], axis=-1) + 10.0 * np.eye(num)
        if off.min() > 1.9:
            return places


def _room(x0: float, y0: float, x1: float, y1: float) -> tuple[Wall, ...]:
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    ends = zip(corners, corners[1:] + corners[:1], strict=True)
    return tuple(Wall(from_m=(float(a), float(b)), to_m=(float(c), float(d)))
                 for (a, b), (c, d) in ends)  # fmt: skip


def _outcome(drive: Drive, task: Task) -> Outcome:
    first = next(iter(drive.people.values()), np.zeros((0, 3)))
    every = max(round(_KEEP_S / 0.01), 1)
    return Outcome(
        is_done=drive.is_reached, time_s=drive.time_s, path_m=drive.path_m,
        is_straight=drive.most_off_rad < STRAIGHT_RAD, contacts=len(drive.contacts),
        by_robot=sum(c.by_robot for c in drive.contacts), min_gap_m=drive.min_gap_m,
        heading_changes=drive.heading_changes, waited_s=drive.not_moving_s,
        has_moved=stepped_aside(first, drive.times, drive.poses),
        track=np.column_stack((drive.times, drive.poses))[::every], people=first,
    )  # fmt: skip


def stepped_aside(person: np.ndarray, times: np.ndarray, poses: np.ndarray) -> bool:
    """Tell whether somebody makes room by 0.3 m, before a robot has come abreast of them.

    Across the robot's first heading, which is the line that both are on (standing, oncoming): who
    goes on along it, or goes aside once the robot is there, makes no room.

    Args:
        person: t, x, y, shape (M, 3).
        times: Of the robot, shape (N,), s.
        poses: x, y, yaw of the robot, shape (N, 3).
    """
    if not len(person) or not len(poses):
        return False
    ahead = np.array([math.cos(poses[0, 2]), math.sin(poses[0, 2])])
    robot = np.column_stack([np.interp(person[:, 0], times, poses[:, k]) for k in (0, 1)])
    is_before = (person[:, 1:] - robot) @ ahead > 0.0
    aside = np.abs((person[:, 1:] - person[0, 1:]) @ np.array([-ahead[1], ahead[0]]))
    until = len(person) if is_before.all() else int(np.argmin(is_before))
    return bool(aside[:until].max(initial=0.0) >= _ASIDE)


_COURSES = {
    STATIC: _static, CROSSING: _crossing, STANDING: _standing, ONCOMING: _oncoming, HALL: _hall
}  # fmt: skip
