"""Where the crowd experiment drives: a corridor, a doorway, a living room, a crossing.

People, robot and goals of a run follow from its seed. People are those of `sim_bridge`: they keep
clear of walls and of each other, notice the robot late or never (one in ten), and step aside or
not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from floornav_common.se2 import SE2
from sim_bridge.people.obstacles import Obstacles
from sim_bridge.people.people import drawn_walkers
from sim_bridge.people.schema import Crowd, Point, WalkerPlan
from sim_bridge.solids import solids_of
from sim_bridge.world import Column, Door, Furniture, RobotPlacement, Wall, World
from sjmc_planner.config import RobotConfig

ROBOT_MODEL = "segway_urg"
# The thesis's robot: its outline, 3 km/h, and the limits of the simulated drive.
ROBOT = RobotConfig(
    drive="differential", radius_m=0.57, margin_m=0.03, front_m=0.20, rear_m=0.49,
    half_width_m=0.28, speed_m_s=0.833, accel_m_s2=0.8, yaw_rate_rad_s=1.2, yaw_accel_rad_s2=2.5,
    idle_time_s=0.1,
)  # fmt: skip
NEVER_SHARE = 0.1
_LEVEL, _ASIDE = 0.3, 1.5  # where a drive is over, before and beside its goal, m
_APART = 0.7  # people at the start from each other, m


@dataclass(frozen=True)
class Scene:
    """One run's place.

    Attributes:
        world: With the robot at its start and everybody.
        goal: In the world, m.
        all_yield: Whether everybody notices sooner or later.
    """

    world: World
    goal: Point
    all_yield: bool

    @property
    def straight_m(self) -> float:
        """From the start to the goal, m."""
        return math.dist(self.world.robots[0].position_m, self.goal)

    def is_finished(self, pose: SE2) -> bool:
        """Tell whether a robot is level with its goal, no farther aside than 1.5 m."""
        start = np.array(self.world.robots[0].position_m)
        way = (np.array(self.goal) - start) / self.straight_m
        off = np.array([pose.x, pose.y]) - start
        aside = float(way[0] * off[1] - way[1] * off[0])
        return float(way @ off) > self.straight_m - _LEVEL and abs(aside) < _ASIDE


def corridor(seed: int) -> Scene:
    """Return a corridor 3 m wide with four who come and two who go the robot's way."""
    rng = np.random.default_rng([seed, 1])
    places = _places(rng, [(7.0, 20.0)] * 4 + [(-3.5, -1.2)] * 2, (-1.0, 1.0))
    plans = []
    for k, (x, y) in enumerate(places):
        end = (-4.5, float(rng.uniform(-1.0, 1.0))) if k < 4 else (20.0, y)
        plans.append(_walker(rng, k, ((x, y), end)))
    walls = (_wall(-5.0, -1.5, 22.0, -1.5), _wall(-5.0, 1.5, 22.0, 1.5),
             _wall(-5.0, -1.5, -5.0, 1.5), _wall(22.0, -1.5, 22.0, 1.5))  # fmt: skip
    return scene_with("corridor", plans, (1.0, 0.0), (12.0, 0.0), walls=walls)


def doorway(seed: int) -> Scene:
    """Return two rooms and a doorway of 1.6 m: three come through it, one walks by before it."""
    rng = np.random.default_rng([seed, 2])
    places = _places(rng, [(2.0, 5.3)] * 3, (-2.4, 2.4))
    plans = []
    for k, place in enumerate(places):
        end = (float(rng.uniform(-5.3, -2.0)), float(rng.uniform(-2.4, 2.4)))
        aside = float(rng.uniform(-0.3, 0.3))
        path = (place, (0.8, aside), (-0.8, aside), end)
        plans.append(_walker(rng, k, path, starts_s=float(rng.uniform(0.0, 5.0))))
    x = float(rng.uniform(-2.2, -1.2))
    plans.append(_walker(rng, 3, ((x, -2.3), (x, 2.3)), repeats=True))
    door = Wall(from_m=(0.0, -3.0), to_m=(0.0, 3.0), doors=(Door(at_m=3.0, width_m=1.6),))
    start, goal = float(rng.uniform(-0.8, 0.8)), float(rng.uniform(-0.8, 0.8))
    walls = (*_room(-6.0, -3.0, 6.0, 3.0), door)
    return scene_with("doorway", plans, (-4.5, start), (4.0, goal), walls=walls)


def crossing(seed: int) -> Scene:
    """Return a hall where six people cross the robot's way about when it is there."""
    rng = np.random.default_rng([seed, 3])
    plans = []
    for k, x in enumerate(rng.permutation(np.linspace(2.5, 10.0, 6)).tolist()):
        side = float(rng.choice([-1.0, 1.0]))
        speed = float(rng.uniform(0.8, 1.5))
        there = x / ROBOT.speed_m_s + float(rng.uniform(-2.5, 2.5))
        path = ((x, 5.0 * side), (x + float(rng.uniform(-1.5, 1.5)), -5.0 * side))
        waits = max(0.0, there - 5.0 / speed)
        plans.append(_walker(rng, k, path, starts_s=waits, speed_m_s=speed))
    return scene_with(
        "crossing", plans, (0.0, 0.0), (11.5, 0.0), walls=_room(-2.0, -6.0, 14.0, 6.0)
    )


def living_room(seed: int) -> Scene:
    """Return a furnished room of 7 x 5.5 m where three people go to and fro, at 0.5 to 1 m/s."""
    rng = np.random.default_rng([seed, 4])
    boxes = (
        Furniture(name="sofa", center_m=(1.7, 0.5), size_m=(1.8, 0.8, 1.1), surface="cloth"),
        Furniture(name="cupboard", center_m=(6.1, 0.35), size_m=(1.4, 0.5, 1.9)),
        Furniture(name="bookcase", center_m=(3.5, 5.2), size_m=(2.0, 0.35, 1.9)),
    )
    columns = (
        Column(name="high table", center_m=(3.6, 2.2), radius_m=0.45, height_m=1.1),
        Column(name="floor lamp", center_m=(5.6, 4.7), radius_m=0.12, height_m=1.6),
    )
    scene = scene_with("living room", [], (0.9, 2.8), (6.1, 2.8), walls=_room(0.0, 0.0, 7.0, 5.5),
                   boxes=boxes, columns=columns)  # fmt: skip
    crowd = Crowd(num=3, low_m=(1.9, 1.2), high_m=(6.4, 4.8), num_goals=5, free_m=0.45)
    plans = []
    for plan in drawn_walkers(crowd, Obstacles(solids_of(scene.world)), seed):
        pauses = tuple(rng.choice([0.0, 0.0, 1.0, 3.0], len(plan.path_m)).tolist())
        speed = float(rng.uniform(0.5, 1.0))
        plans.append(
            replace(plan, speed_m_s=speed, pauses_s=pauses, never_notices=_never_notices(rng))
        )
    return _with_people(scene, plans)


SCENES = {
    "corridor": corridor, "doorway": doorway, "living_room": living_room, "crossing": crossing
}  # fmt: skip


def _places(
    rng: np.random.Generator, ranges_x: list[tuple[float, float]], range_y: tuple[float, float]
) -> list[Point]:
    """Draw a place for each range of x, apart from each other."""
    places: list[Point] = []
    for low, high in ranges_x:
        while True:
            place = float(rng.uniform(low, high)), float(rng.uniform(*range_y))
            if all(math.dist(place, other) > _APART for other in places):
                places.append(place)
                break
    return places


def _walker(
    rng: np.random.Generator, number: int, path: tuple[Point, ...], *, starts_s: float = 0.0,
    speed_m_s: float = 0.0, repeats: bool = False,
) -> WalkerPlan:  # fmt: skip
    return WalkerPlan(
        name=f"walker {number + 1}", path_m=path, speed_m_s=speed_m_s, starts_s=starts_s,
        repeats=repeats, is_reacting=True, never_notices=_never_notices(rng),
    )  # fmt: skip


def _never_notices(rng: np.random.Generator) -> bool:
    return bool(rng.random() < NEVER_SHARE)


def scene_with(
    name: str, plans: list[WalkerPlan], start: Point, goal: Point, *,
    walls: tuple[Wall, ...] = (), boxes: tuple[Furniture, ...] = (),
    columns: tuple[Column, ...] = (),
) -> Scene:  # fmt: skip
    """Return a scene whose robot starts facing its goal."""
    yaw = math.degrees(math.atan2(goal[1] - start[1], goal[0] - start[0]))
    robot = RobotPlacement(model=ROBOT_MODEL, position_m=start, yaw_deg=yaw)
    world = World(name=name, walls=walls, boxes=boxes, columns=columns, robots=(robot,))
    return _with_people(Scene(world, goal, True), plans)


def _with_people(scene: Scene, plans: list[WalkerPlan]) -> Scene:
    all_yield = not any(plan.never_notices for plan in plans)
    return Scene(replace(scene.world, people=tuple(plans)), scene.goal, all_yield)


def _wall(x1: float, y1: float, x2: float, y2: float) -> Wall:
    return Wall(from_m=(x1, y1), to_m=(x2, y2))


def _room(x1: float, y1: float, x2: float, y2: float) -> tuple[Wall, ...]:
    return (_wall(x1, y1, x2, y1), _wall(x2, y1, x2, y2), _wall(x2, y2, x1, y2),
            _wall(x1, y2, x1, y1))  # fmt: skip
